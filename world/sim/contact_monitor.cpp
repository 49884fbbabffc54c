#include "world/sim/contact_monitor.hpp"

#include <algorithm>
#include <limits>

#include "world/sim/monitored_pairs.hpp"

namespace hecaton::world {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr std::size_t kMaxEvents = 100;
/// Error of a computed distance, for the bounds derived from it [m].
constexpr double kDistanceError = 2e-4;
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
  std::vector<int> group_touching;  ///< touching pairs of parts in each group
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
    group_touching.assign(bodies.group_count(), 0);
    for (const MonitoredPair& pair : bodies.pairs()) group_touching[pair.group] += pair.state.touching ? 1 : 0;
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
      if (++group_touching[pair.group] > 1) return;
      ++kind.contacts;
      if (events.size() < kMaxEvents) events.push_back(found(pair, distance));
    } else if (pair.state.touching && distance > kPartedDistance) {
      pair.state.touching = false;
      --group_touching[pair.group];
    }
  }

  /// Tightens the bounds, then computes the distance if they do not suffice.
  void refine(MonitoredPair& pair, double travel) {
    if (!bodies.placed(pair)) return;
    Tally& kind = tally(pair);
    kind.checked = true;
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
    for (const PairRun& run : bodies.candidates(smallest)) {
      for (int i = run.first; i < run.end; ++i) check(bodies.pairs()[i]);
    }
    bodies.update_blocks();
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

void ContactMonitor::update(std::span<const MeasuredArm> arms, std::span<const ObstacleState> obstacles, double time) {
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
  for (const MonitoredPair& pair : impl_->bodies.pairs()) {
    if (!pair.state.watched()) continue;
    checkpoint.pairs.push_back({names[impl_->bodies.part(pair.a).name], names[impl_->bodies.part(pair.b).name],
                                pair.identity.second, pair.state});
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
  for (MonitoredPair& pair : impl_->bodies.pairs()) {
    const auto& names = impl_->bodies.names();
    const std::string& a = names[impl_->bodies.part(pair.a).name];
    const std::string& b = names[impl_->bodies.part(pair.b).name];
    pair.state = {};
    for (const PairCheckpoint& known : checkpoint.pairs) {
      if (known.occurrence == pair.identity.second && known.a == a && known.b == b) pair.state = known.state;
    }
  }
  impl_->bodies.reset_blocks();
  impl_->count_touching();
}

void ContactMonitor::reset() {
  impl_->tallies = {};
  impl_->events.clear();
  for (MonitoredPair& pair : impl_->bodies.pairs()) pair.state.touching = false;
  impl_->count_touching();
}

std::optional<Separation> ContactMonitor::nearest(int arm, bool with_self) const {
  Impl& impl = *impl_;
  Found nearest;
  for (MonitoredPair& pair : impl.bodies.pairs()) {
    if (impl.bodies.part(pair.a).arm != arm && impl.bodies.part(pair.b).arm != arm) continue;
    if ((pair.kind == ContactKind::kArmSelf && !with_self) || !impl.bodies.placed(pair)) continue;
    if (pair.lower_ref - impl.bodies.travel(pair) >= nearest.distance) continue;
    if (impl.bodies.sphere_distance(pair) >= nearest.distance) continue;
    const double distance = impl.compute(pair);
    if (distance < nearest.distance) nearest = impl.found(pair, distance);
  }
  if (nearest.distance == kInfinity) return std::nullopt;
  return impl.named(nearest);
}

std::uint64_t ContactMonitor::exact_checks() const {
  return impl_->exact_checks;
}

}  // namespace hecaton::world
