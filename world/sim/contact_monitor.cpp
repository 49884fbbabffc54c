#include "world/sim/contact_monitor.hpp"

#include <algorithm>
#include <limits>
#include <unordered_map>

#include "world/sim/monitored_pairs.hpp"

namespace hecaton::world {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr std::size_t kMaxEvents = 100;
/// A tolerated pair becomes a contact when it overlaps this much deeper [m].
constexpr double kToleratedDepth = 1e-3;

/// A separation with indices for names: an update makes no strings.
struct Found {
  double distance = kInfinity;
  ContactKind kind = ContactKind::kArmArm;
  int a = 0;
  int b = 0;
  double time = 0.0;
};

struct Tally {
  std::uint64_t contacts = 0;
  bool checked = false;  ///< a pair of this kind was checked
  Found smallest;
};

}  // namespace

struct ContactMonitor::Impl {
  explicit Impl(std::vector<ArmBodies> arms) : bodies(std::move(arms)) { count_touching(); }

  MonitoredPairs bodies;
  std::unordered_map<std::uint64_t, int> touching;  ///< touching pairs of parts with each two names
  std::array<Tally, kContactKinds> tallies;
  std::vector<Found> events;
  std::uint64_t exact_checks = 0;
  double time = 0.0;

  Tally& tally(const MonitoredPair& pair) { return tallies[static_cast<std::size_t>(pair.kind)]; }

  Separation named(const Found& found) const {
    const auto& names = bodies.names();
    return {found.distance, found.kind, names[found.a], names[found.b], found.time};
  }
  Found found(const MonitoredPair& pair, double distance) const {
    return {distance, pair.kind, bodies.part(pair.a).name, bodies.part(pair.b).name, time};
  }

  Found indexed(const Separation& separation) {
    return {separation.distance, separation.kind, bodies.name_index(separation.a), bodies.name_index(separation.b),
            separation.time};
  }

  void count_touching() {
    touching.clear();
    bodies.for_each([&](const MonitoredPair& pair) {
      if (pair.state.touching) ++touching[pair.identity.first];
    });
  }

  double compute(MonitoredPair& pair) {
    const double distance = bodies.exact_distance(pair);
    ++exact_checks;
    pair.lower_ref = distance - kDistanceError + bodies.travel(pair);
    pair.upper_ref = distance + kDistanceError - bodies.travel(pair);
    return distance;
  }

  static bool tolerated(PairState& state, double distance) {
    if (state.handled) {
      state.handled = false;
      state.tolerated = distance <= kPartedDistance;
      state.tolerated_distance = distance;
    }
    if (state.tolerated && (distance > kPartedDistance || distance < state.tolerated_distance - kToleratedDepth)) {
      state.tolerated = false;
    }
    return state.tolerated;
  }

  void record(MonitoredPair& pair, double distance) {
    if (tolerated(pair.state, distance)) return;
    Tally& kind = tally(pair);
    if (distance < kind.smallest.distance) kind.smallest = found(pair, distance);
    if (!pair.state.touching && distance <= 0.0) {
      pair.state.touching = true;
      if (++touching[pair.identity.first] > 1) return;
      ++kind.contacts;
      if (events.size() < kMaxEvents) events.push_back(found(pair, distance));
    } else if (pair.state.touching && distance > kPartedDistance) {
      pair.state.touching = false;
      --touching[pair.identity.first];
    }
  }

  /// A handled pair that is surely apart needs no distance: what a hand carries has many pairs.
  void forget_if_apart(MonitoredPair& pair, double travel) {
    if (pair.state.touching || pair.state.tolerated) return;
    if (std::max(pair.lower_ref - travel, bodies.sphere_distance(pair)) > kPartedDistance) pair.state.handled = false;
  }

  /// Tightens the bounds, then computes the distance if they do not suffice.
  void refine(MonitoredPair& pair, double travel) {
    if (!bodies.placed(pair)) return;
    Tally& kind = tally(pair);
    kind.checked = true;
    if (pair.state.handled) forget_if_apart(pair, travel);
    if (!pair.state.handled && !pair.state.tolerated) {
      double lower = std::max(pair.lower_ref - travel, bodies.sphere_distance(pair));
      const auto unchanged = [&] {
        // The pair can neither have begun nor ended a contact, and its distance is no new minimum.
        const bool same = pair.state.touching ? pair.upper_ref + travel <= kPartedDistance : lower > 0.0;
        return same && lower >= kind.smallest.distance;
      };
      if (!unchanged()) lower = std::max(lower, bodies.gap_along_last_normal(pair));
      pair.lower_ref = lower + travel;
      if (unchanged()) return;
    }
    record(pair, compute(pair));
  }

  void check(MonitoredPair& pair) {
    const double travel = bodies.travel(pair);
    const double lower = pair.lower_ref - travel;
    if (!pair.state.watched() && lower > 0.0 && lower >= tally(pair).smallest.distance) return;
    refine(pair, travel);
  }

  void update() {
    std::array<double, kContactKinds> smallest;
    for (std::size_t kind = 0; kind < kContactKinds; ++kind) smallest[kind] = tallies[kind].smallest.distance;
    if (bodies.any_standing_pair()) tallies[static_cast<std::size_t>(ContactKind::kArmObstacle)].checked = true;
    for (MonitoredPair* pair : bodies.candidates(smallest)) check(*pair);
    bodies.update_bounds();
  }
};

ContactMonitor::ContactMonitor(std::vector<ArmBodies> arms) : impl_(std::make_unique<Impl>(std::move(arms))) {}
ContactMonitor::~ContactMonitor() = default;
ContactMonitor::ContactMonitor(ContactMonitor&&) noexcept = default;
ContactMonitor& ContactMonitor::operator=(ContactMonitor&&) noexcept = default;

void ContactMonitor::set_obstacles(std::span<const Obstacle> obstacles, const std::string& handled) {
  impl_->bodies.set_obstacles(obstacles, handled);
  impl_->count_touching();
}

void ContactMonitor::update(std::span<const MeasuredArm> arms, const PresentStates& obstacles, double time) {
  impl_->time = time;
  impl_->bodies.place(arms, obstacles);
  impl_->update();
}

ContactReport ContactMonitor::report() const {
  ContactReport report;
  for (int i = 0; i < kContactKinds; ++i) {
    const Tally& tally = impl_->tallies[i];
    KindReport& kind = report.kinds[i];
    kind.contacts = tally.contacts;
    report.contacts += tally.contacts;
    // All pairs that were checked may have been tolerated.
    kind.has_smallest = tally.checked && tally.smallest.distance < kInfinity;
    if (!kind.has_smallest) continue;
    kind.smallest = impl_->named(tally.smallest);
    if (!report.has_smallest || kind.smallest.distance < report.smallest.distance) report.smallest = kind.smallest;
    report.has_smallest = true;
  }
  for (const Found& event : impl_->events) report.events.push_back(impl_->named(event));
  return report;
}

ContactCheckpoint ContactMonitor::checkpoint() const {
  ContactCheckpoint checkpoint{report(), {}};
  const auto& names = impl_->bodies.names();
  std::vector<const MonitoredPair*> watched;
  impl_->bodies.for_each([&](const MonitoredPair& pair) {
    if (pair.state.watched()) watched.push_back(&pair);
  });
  std::sort(watched.begin(), watched.end(),
            [](const MonitoredPair* one, const MonitoredPair* other) { return one->order < other->order; });
  for (const MonitoredPair* pair : watched) {
    checkpoint.pairs.push_back({names[impl_->bodies.part(pair->a).name], names[impl_->bodies.part(pair->b).name],
                                pair->identity.second, pair->state});
  }
  return checkpoint;
}

void ContactMonitor::restore(const ContactCheckpoint& checkpoint) {
  for (std::size_t i = 0; i < kContactKinds; ++i) {
    const KindReport& kind = checkpoint.report.kinds[i];
    impl_->tallies[i] = {kind.contacts, kind.has_smallest, kind.has_smallest ? impl_->indexed(kind.smallest) : Found{}};
  }
  impl_->events.clear();
  for (const Separation& event : checkpoint.report.events) impl_->events.push_back(impl_->indexed(event));
  PairStates states;
  for (const PairCheckpoint& known : checkpoint.pairs) {
    const auto a = static_cast<std::uint64_t>(impl_->bodies.name_index(known.a));
    const auto b = static_cast<std::uint64_t>(impl_->bodies.name_index(known.b));
    states[{a << 32 | b, known.occurrence}] = known.state;
  }
  impl_->bodies.set_states(states);
  impl_->count_touching();
}

void ContactMonitor::reset() {
  impl_->tallies = {};
  impl_->events.clear();
  impl_->bodies.for_each([](MonitoredPair& pair) { pair.state.touching = false; });
  impl_->bodies.reset_bounds();
  impl_->count_touching();
}

std::optional<Separation> ContactMonitor::nearest(int arm, bool with_self) const {
  Impl& impl = *impl_;
  const MonitoredPairs& bodies = impl.bodies;
  Found nearest;
  std::uint64_t order = 0;
  const auto compare = [&](MonitoredPair& pair) {
    if (bodies.part(pair.a).arm != arm && bodies.part(pair.b).arm != arm) return;
    if ((pair.kind == ContactKind::kArmSelf && !with_self) || !bodies.placed(pair)) return;
    if (pair.lower_ref - bodies.travel(pair) > nearest.distance) return;
    if (bodies.sphere_distance(pair) > nearest.distance) return;
    const double distance = impl.compute(pair);
    if (distance > nearest.distance || (distance == nearest.distance && pair.order > order)) return;
    nearest = impl.found(pair, distance);
    order = pair.order;
  };
  impl.bodies.for_each(compare);
  for (const int mover : bodies.movers()) {
    if (bodies.part(mover).arm != arm || !bodies.placed(mover)) continue;
    const auto compare_with = [&](int standing) {
      MonitoredPair pair = bodies.near_pair(mover, standing);
      compare(pair);
    };
    if (nearest.distance == kInfinity) {  // no pair yet: any obstacle bounds the distance
      for (int i = 0; i < bodies.part_count() && nearest.distance == kInfinity; ++i) {
        if (bodies.part(i).stands() && bodies.placed(i)) compare_with(i);
      }
    }
    if (nearest.distance < kInfinity) {
      bodies.near().within(bodies, mover, std::max(nearest.distance, 0.0), compare_with);
    }
  }
  if (nearest.distance == kInfinity) return std::nullopt;
  return impl.named(nearest);
}

std::uint64_t ContactMonitor::exact_checks() const {
  return impl_->exact_checks;
}

}  // namespace hecaton::world
