#include "world/sim/monitored_pairs.hpp"

#include <algorithm>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <tuple>

namespace hecaton::world {
namespace {

constexpr double kUnbounded = std::numeric_limits<double>::infinity();
/// Subtracted from a block's bound: sums of many motions are rounded [m].
constexpr double kRounding = 1e-9;

/// No point of a unit ball around the origin moves farther when it turns from R0 to R1: 2 sin(θ/2) = ‖R1 − R0‖_F / √2.
double turn_between(const Pose& X0, const Pose& X1) {
  return (X1.linear() - X0.linear()).norm() / std::numbers::sqrt2;
}

constexpr std::uint64_t kFirstSelfPair = std::uint64_t{1} << 63;
std::uint64_t order_of(int a, int b) {
  return static_cast<std::uint64_t>(b) << 32 | static_cast<std::uint32_t>(a);
}

}  // namespace

void PairBlocks::rebuild(std::span<const MonitoredPair> pairs, std::span<const int> side_of_part) {
  blocks_.clear();
  runs_.clear();
  std::map<std::pair<int, int>, int> index_of;  // by both sides
  int last = -1;
  for (int i = 0; i < static_cast<int>(pairs.size()); ++i) {
    const MonitoredPair& pair = pairs[i];
    const int a = side_of_part[pair.a];
    const int b = side_of_part[pair.b];
    if (last >= 0 && blocks_[last].a == a && blocks_[last].b == b) {
      runs_[last].back().end = i + 1;
      continue;
    }
    const auto [entry, is_new] = index_of.try_emplace({a, b}, static_cast<int>(blocks_.size()));
    last = entry->second;
    if (is_new) {
      blocks_.push_back({a, b, pair.kind, -kUnbounded});
      runs_.emplace_back();
    }
    runs_[last].push_back({i, i + 1});
  }
}

void PairBlocks::reset_bounds() {
  for (Block& block : blocks_) block.lower_ref = -kUnbounded;
}

std::span<const PairRun> PairBlocks::candidates(std::span<const double> travel,
                                                const std::array<double, kContactKinds>& smallest) {
  open_.clear();
  open_runs_.clear();
  for (int i = 0; i < static_cast<int>(blocks_.size()); ++i) {
    const Block& block = blocks_[i];
    const double lower = block.lower_ref - (travel[block.a] + travel[block.b]);
    if (lower > 0.0 && lower >= smallest[static_cast<std::size_t>(block.kind)]) continue;
    open_.push_back(i);
    open_runs_.insert(open_runs_.end(), runs_[i].begin(), runs_[i].end());
  }
  // Of two pairs at the same distance, the report names the first.
  std::sort(open_runs_.begin(), open_runs_.end(),
            [](const PairRun& one, const PairRun& other) { return one.first < other.first; });
  return open_runs_;
}

void PairBlocks::update(std::span<const MonitoredPair> pairs, std::span<const double> part_travel,
                        std::span<const double> travel) {
  for (const int i : open_) {
    Block& block = blocks_[i];
    double lower = kUnbounded;
    for (const PairRun& run : runs_[i]) {
      for (const MonitoredPair& pair : pairs.subspan(run.first, run.end - run.first)) {
        const double own = pair.lower_ref - (part_travel[pair.a] + part_travel[pair.b]);
        lower = std::min(lower, pair.state.watched() ? -kUnbounded : own);
      }
    }
    block.lower_ref = lower + (travel[block.a] + travel[block.b]) - kRounding;
  }
}

MonitoredPairs::MonitoredPairs(std::vector<ArmBodies> arms) : arms_(std::move(arms)) {
  for (int arm = 0; arm < static_cast<int>(arms_.size()); ++arm) {
    const ArmBodies& bodies = arms_[arm];
    first_link_.push_back(static_cast<int>(carriers_.size()));
    first_part_.push_back(static_cast<int>(parts_.size()));
    int links = 0;
    for (const auto& part : bodies.parts) links = std::max(links, part.link + 1);
    carriers_.resize(carriers_.size() + links);
    for (const auto& part : bodies.parts) {
      if (part.link < 0) throw std::invalid_argument("arm '" + bodies.name + "': a part has no link");
      MonitoredPart added;
      added.carrier = first_link_[arm] + part.link;
      added.arm = arm;
      added.link = part.link;
      added.moves = part.moves;
      added.name = name_index(bodies.name + "/" + part.link_name);
      add_part(std::move(added), arm, part.shape);
    }
    const int parts = static_cast<int>(bodies.parts.size());
    for (const auto& [a, b] : bodies.self_pairs) {
      if (std::min(a, b) < 0 || std::max(a, b) >= parts || a == b) {
        throw std::invalid_argument("arm '" + bodies.name + "': its self pairs name parts that do not exist");
      }
    }
  }
  links_ = static_cast<int>(carriers_.size());
  link_parts_ = static_cast<int>(parts_.size());
  side_travel_.assign(arms_.size(), 0.0);
  adopt();
}

int MonitoredPairs::name_index(const std::string& name) {
  const auto [entry, is_new] = name_indices_.try_emplace(name, static_cast<int>(names_.size()));
  if (is_new) {
    names_.push_back(name);
    name_parts_.push_back(0);
  }
  return entry->second;
}

void MonitoredPairs::add_part(MonitoredPart part, int side, const PlacedShape& placed) {
  const BoundingSphere bound = bounding_sphere(placed.shape);
  part.shape = make_bullet_shape(placed.shape);
  if (const auto* points = std::get_if<Points>(&placed.shape)) part.balls = cloud_balls(points->cloud);
  part.X_CS = placed.X_BS;
  part.centre_C = placed.X_BS * bound.centre;
  part.radius = bound.radius;
  part.rank = name_parts_[part.name]++;
  carriers_[part.carrier].parts.push_back(static_cast<int>(parts_.size()));
  parts_.push_back(std::move(part));
  travel_.push_back(0.0);
  sides_.push_back(side);
}

void MonitoredPairs::set_obstacles(std::span<const Obstacle> obstacles, const std::string& handled) {
  for (int i = link_parts_; i < part_count(); ++i) --name_parts_[parts_[i].name];
  parts_.erase(parts_.begin() + link_parts_, parts_.end());
  seen_ = 0;
  waiting_.clear();
  travel_.resize(link_parts_);
  sides_.resize(link_parts_);
  side_travel_.resize(arms_.size());
  carriers_.resize(links_);
  for (const Obstacle& obstacle : obstacles) {
    const int side = static_cast<int>(side_travel_.size());
    side_travel_.push_back(0.0);
    carriers_.emplace_back();
    MonitoredPart part;
    part.carrier = static_cast<int>(carriers_.size()) - 1;
    part.moves = obstacle.attachment || !std::holds_alternative<StaticMotion>(obstacle.motion);
    part.handled = obstacle.name == handled;
    std::string name = obstacle.name;
    if (obstacle.attachment) {
      const auto carrier = std::find_if(arms_.begin(), arms_.end(),
                                        [&](const ArmBodies& arm) { return arm.name == obstacle.attachment->arm; });
      if (carrier == arms_.end()) continue;
      part.arm = static_cast<int>(carrier - arms_.begin());
      name.insert(0, carrier->name + "/");
    }
    part.name = name_index(name);
    for (const PlacedShape& placed : obstacle.shapes) add_part(part, side, placed);
  }
  adopt();
}

std::optional<ContactKind> MonitoredPairs::kind_of(const MonitoredPart& a, const MonitoredPart& b) const {
  if (a.arm != b.arm && a.arm >= 0 && b.arm >= 0) {
    const bool one_robot = arms_[a.arm].robot >= 0 && arms_[a.arm].robot == arms_[b.arm].robot;
    if (one_robot) return a.moves && b.moves ? std::optional(ContactKind::kArmArm) : std::nullopt;
    return a.moves || b.moves ? std::optional(ContactKind::kArmArm) : std::nullopt;
  }
  if (a.arm != b.arm) {
    return a.moves || b.moves ? std::optional(ContactKind::kArmObstacle) : std::nullopt;
  }
  // Two free or two carried obstacles are no pair; two links are one only as a listed self pair.
  if (a.arm < 0 || (a.link < 0) == (b.link < 0)) return std::nullopt;
  const auto& may_touch = arms_[a.arm].grasp_links;
  const bool touches = std::find(may_touch.begin(), may_touch.end(), std::max(a.link, b.link)) != may_touch.end();
  return touches ? std::nullopt : std::optional(ContactKind::kArmSelf);
}

MonitoredPair::Identity MonitoredPairs::identity(int a, int b) const {
  const auto name_a = static_cast<std::uint32_t>(parts_[a].name);
  const auto name_b = static_cast<std::uint32_t>(parts_[b].name);
  return {std::uint64_t{name_a} << 32 | name_b, parts_[b].rank * name_parts_[parts_[a].name] + parts_[a].rank};
}

MonitoredPair MonitoredPairs::near_pair(int mover, int standing) const {
  MonitoredPair pair;
  std::tie(pair.a, pair.b) = std::minmax(mover, standing);
  pair.order = order_of(pair.a, pair.b);
  pair.kind = ContactKind::kArmObstacle;
  pair.identity = identity(pair.a, pair.b);
  return pair;
}

std::vector<MonitoredPair> MonitoredPairs::pairs_in_blocks() const {
  std::vector<MonitoredPair> pairs;
  const auto add = [&](int a, int b, ContactKind kind, std::uint64_t order) {
    MonitoredPair& pair = pairs.emplace_back();
    pair.a = a;
    pair.b = b;
    pair.order = order;
    pair.kind = kind;
    pair.identity = identity(a, b);
    pair.state.handled = parts_[a].handled || parts_[b].handled;
  };
  std::vector<int> of_arms;  // two parts of free obstacles are no pair
  std::vector<int> others;
  for (int b = 0; b < part_count(); ++b) {
    const bool of_arm = parts_[b].arm >= 0;
    if (parts_[b].stands()) continue;
    const auto add_with = [&](int a) {
      if (const auto kind = kind_of(parts_[a], parts_[b])) add(a, b, *kind, order_of(a, b));
    };
    if (of_arm) {
      // Ascending, over both.
      auto other = others.begin();
      for (const int a : of_arms) {
        for (; other != others.end() && *other < a; ++other) add_with(*other);
        add_with(a);
      }
      for (; other != others.end(); ++other) add_with(*other);
    } else {
      for (const int a : of_arms) add_with(a);
    }
    (of_arm ? of_arms : others).push_back(b);
  }
  std::uint64_t order = kFirstSelfPair;
  for (std::size_t arm = 0; arm < arms_.size(); ++arm) {
    for (const auto& [a, b] : arms_[arm].self_pairs) {
      add(first_part_[arm] + a, first_part_[arm] + b, ContactKind::kArmSelf, order++);
    }
  }
  return pairs;
}

void MonitoredPairs::adopt() {
  PairStates known;
  PairStates watched;
  known.reserve(pairs_.size());
  for_each([&](const MonitoredPair& pair) {
    known[pair.identity] = pair.state;
    if (pair.state.watched()) watched[pair.identity] = pair.state;
  });
  movers_.clear();
  for (int i = 0; i < part_count(); ++i) {
    if (parts_[i].moves_with_arm()) movers_.push_back(i);
  }
  pairs_ = pairs_in_blocks();
  for (MonitoredPair& pair : pairs_) {
    const auto before = known.find(pair.identity);
    if (before != known.end()) pair.state = before->second;
  }
  blocks_.rebuild(pairs_, sides_);

  near_.clear(part_count());
  for (int i = link_parts_; i < part_count(); ++i) {
    if (!parts_[i].handled) continue;
    if (parts_[i].stands()) {
      for (const int mover : movers_) near_.keep(*this, mover, i, {.handled = true});
    } else if (parts_[i].moves_with_arm()) {
      for (int other = link_parts_; other < part_count(); ++other) {
        if (parts_[other].stands()) near_.keep(*this, i, other, {.handled = true});
      }
    }
  }
  keep_near(watched);
}

void MonitoredPairs::keep_near(const PairStates& states) {
  if (states.empty()) return;
  std::vector<std::pair<int, int>> by_name;  // and index
  for (int i = 0; i < part_count(); ++i) by_name.emplace_back(parts_[i].name, i);
  std::sort(by_name.begin(), by_name.end());
  const auto parts_of = [&](std::uint64_t name) {
    const auto first = std::lower_bound(by_name.begin(), by_name.end(), std::pair(static_cast<int>(name), 0));
    auto last = first;
    while (last != by_name.end() && last->first == static_cast<int>(name)) ++last;
    return std::span(first, last);
  };
  for (const auto& [known, state] : states) {
    for (const auto& [name_a, a] : parts_of(known.first >> 32)) {
      for (const auto& [name_b, b] : parts_of(known.first & 0xFFFFFFFFU)) {
        const bool near = parts_[a].moves_with_arm() && parts_[b].stands();
        const bool near_too = parts_[b].moves_with_arm() && parts_[a].stands();
        if ((near || near_too) && identity(a, b) == known) near_.keep(*this, near ? a : b, near ? b : a, state);
      }
    }
  }
}

void MonitoredPairs::set_states(const PairStates& states) {
  for_each([&](MonitoredPair& pair) {
    const auto known = states.find(pair.identity);
    pair.state = known == states.end() ? PairState{} : known->second;
  });
  keep_near(states);
  reset_bounds();
}

bool MonitoredPairs::any_standing_pair() const {
  return near_.any_standing() && std::any_of(movers_.begin(), movers_.end(), [&](int mover) { return placed(mover); });
}

std::span<MonitoredPair* const> MonitoredPairs::candidates(const std::array<double, kContactKinds>& smallest) {
  open_.clear();
  open_near_.clear();
  for (const PairRun& run : blocks_.candidates(side_travel_, smallest)) {
    for (int i = run.first; i < run.end; ++i) open_.push_back(&pairs_[i]);
  }
  near_.candidates(*this, smallest[static_cast<std::size_t>(ContactKind::kArmObstacle)], open_near_);
  // Of two pairs at the same distance, the report names the first.
  const auto earlier = [](const MonitoredPair* one, const MonitoredPair* other) { return one->order < other->order; };
  std::sort(open_near_.begin(), open_near_.end(), earlier);
  const auto middle = open_.insert(open_.end(), open_near_.begin(), open_near_.end());
  std::inplace_merge(open_.begin(), middle, open_.end(), earlier);
  return open_;
}

void MonitoredPairs::place(std::span<const MeasuredArm> arms, const PresentStates& obstacles) {
  const std::size_t count = obstacles.states.size();
  if (arms.size() != arms_.size() || count + links_ != carriers_.size() ||
      (!obstacles.changes.empty() && obstacles.changes.size() != count)) {
    throw std::invalid_argument("the contact monitor needs one entry per arm and one per obstacle");
  }
  for (std::size_t arm = 0; arm < arms_.size(); ++arm) {
    if (!arms[arm].known) continue;
    const int end = arm + 1 < arms_.size() ? first_link_[arm + 1] : links_;
    if (static_cast<int>(arms[arm].X_WL.size()) < end - first_link_[arm]) {
      throw std::invalid_argument("arm '" + arms_[arm].name + "': fewer link poses than links with shapes");
    }
    double farthest = 0.0;
    for (int link = first_link_[arm]; link < end; ++link) {
      if (carriers_[link].parts.empty()) continue;
      farthest = std::max(farthest, move(carriers_[link], arms[arm].X_WL[link - first_link_[arm]]));
    }
    side_travel_[arm] += farthest;
  }
  const std::vector<int> waiting = std::move(waiting_);
  waiting_.clear();
  for (const int i : waiting) place_obstacle(i, obstacles.states[i], arms);
  std::uint64_t latest = seen_;
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint64_t change = obstacles.changes.empty() ? seen_ + 1 : obstacles.changes[i];
    if (change <= seen_) continue;
    latest = std::max(latest, change);
    place_obstacle(static_cast<int>(i), obstacles.states[i], arms);
  }
  seen_ = obstacles.changes.empty() ? 0 : latest;
}

void MonitoredPairs::place_obstacle(int obstacle, const ObstacleState& state, std::span<const MeasuredArm> arms) {
  Carrier& carrier = carriers_[links_ + obstacle];
  if (carrier.parts.empty()) return;
  const MonitoredPart& first = parts_[carrier.parts.front()];
  if (first.arm >= 0 && !arms[first.arm].known) {
    if (std::find(waiting_.begin(), waiting_.end(), obstacle) == waiting_.end()) waiting_.push_back(obstacle);
    return;
  }
  const bool same = carrier.placed && carrier.X_WC.matrix() == state.X_WO.matrix();
  if (same) return;
  side_travel_[arms_.size() + obstacle] += move(carrier, state.X_WO);
  if (!first.stands()) return;
  for (const int part : carrier.parts) near_.put(*this, part);
}

double MonitoredPairs::move(Carrier& carrier, const Pose& X_WC) {
  const double turn = turn_between(carrier.X_WC, X_WC);
  double farthest = 0.0;
  for (const int index : carrier.parts) {
    MonitoredPart& part = parts_[index];
    const Eigen::Vector3d centre_W = X_WC * part.centre_C;
    const double moved = carrier.placed ? (centre_W - part.centre_W).norm() + turn * part.radius : 0.0;
    travel_[index] += moved;
    farthest = std::max(farthest, moved);
    part.centre_W = centre_W;
  }
  carrier.X_WC = X_WC;
  carrier.placed = true;
  return farthest;
}

double MonitoredPairs::sphere_distance(const MonitoredPair& pair) const {
  const MonitoredPart& a = parts_[pair.a];
  const MonitoredPart& b = parts_[pair.b];
  return (a.centre_W - b.centre_W).norm() - a.radius - b.radius;
}

btTransform MonitoredPairs::X_WS(const MonitoredPart& part) const {
  return to_bullet(carriers_[part.carrier].X_WC * part.X_CS);
}

double MonitoredPairs::gap_along_last_normal(const MonitoredPair& pair) const {
  const MonitoredPart& a = parts_[pair.a];
  const MonitoredPart& b = parts_[pair.b];
  const Eigen::Vector3d n_W = carriers_[a.carrier].X_WC.linear() * pair.n_C;
  return gap_along(to_bullet(n_W), *a.shape, X_WS(a), *b.shape, X_WS(b));
}

double MonitoredPairs::exact_distance(MonitoredPair& pair) const {
  const MonitoredPart& a = parts_[pair.a];
  const MonitoredPart& b = parts_[pair.b];
  SignedDistance found;
  if (a.balls) {
    found = a.balls->distance_from(*b.shape, X_WS(b), X_WS(a));
    found.n_W = -found.n_W;
  } else if (b.balls) {
    found = b.balls->distance_from(*a.shape, X_WS(a), X_WS(b));
  } else {
    found = signed_distance(*a.shape, X_WS(a), *b.shape, X_WS(b));
  }
  pair.n_C = carriers_[a.carrier].X_WC.linear().transpose() * from_bullet(found.n_W);
  return found.distance;
}

}  // namespace hecaton::world
