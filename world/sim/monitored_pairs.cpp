#include "world/sim/monitored_pairs.hpp"

#include <algorithm>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <unordered_map>

namespace hecaton::world {
namespace {

constexpr double kUnbounded = std::numeric_limits<double>::infinity();
/// Subtracted from a block's bound: sums of many motions are rounded [m].
constexpr double kRounding = 1e-9;

/// No point of a unit ball around the origin moves farther when it turns from R0 to R1: 2 sin(θ/2) = ‖R1 − R0‖_F / √2.
double turn_between(const Pose& X0, const Pose& X1) {
  return (X1.linear() - X0.linear()).norm() / std::numbers::sqrt2;
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
  adopt(all_pairs());
}

int MonitoredPairs::name_index(const std::string& name) {
  const auto [entry, is_new] = name_indices_.try_emplace(name, static_cast<int>(names_.size()));
  if (is_new) names_.push_back(name);
  return entry->second;
}

void MonitoredPairs::add_part(MonitoredPart part, int side, const PlacedShape& placed) {
  const BoundingSphere bound = bounding_sphere(placed.shape);
  part.shape = make_bullet_shape(placed.shape);
  part.X_CS = placed.X_BS;
  part.centre_C = placed.X_BS * bound.centre;
  part.radius = bound.radius;
  carriers_[part.carrier].parts.push_back(static_cast<int>(parts_.size()));
  parts_.push_back(std::move(part));
  travel_.push_back(0.0);
  sides_.push_back(side);
}

void MonitoredPairs::set_obstacles(std::span<const Obstacle> obstacles, const std::string& handled) {
  parts_.erase(parts_.begin() + link_parts_, parts_.end());
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
  adopt(all_pairs());
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

std::vector<MonitoredPair> MonitoredPairs::all_pairs() const {
  std::vector<MonitoredPair> pairs;
  const auto add = [&](int a, int b, ContactKind kind) {
    MonitoredPair pair;
    pair.a = a;
    pair.b = b;
    pair.kind = kind;
    pair.state.handled = parts_[a].handled || parts_[b].handled;
    pair.lower_ref = -kUnbounded;
    pair.upper_ref = kUnbounded;
    pairs.push_back(pair);
  };
  for (int b = 0; b < static_cast<int>(parts_.size()); ++b) {
    for (int a = 0; a < b; ++a) {
      if (const auto kind = kind_of(parts_[a], parts_[b])) add(a, b, *kind);
    }
  }
  for (std::size_t arm = 0; arm < arms_.size(); ++arm) {
    for (const auto& [a, b] : arms_[arm].self_pairs) {
      add(first_part_[arm] + a, first_part_[arm] + b, ContactKind::kArmSelf);
    }
  }
  return pairs;
}

void MonitoredPairs::adopt(std::vector<MonitoredPair> pairs) {
  std::map<MonitoredPair::Identity, PairState> known;
  for (const MonitoredPair& pair : pairs_) known[pair.identity] = pair.state;

  struct Group {
    int index;
    int pairs = 0;
  };
  std::unordered_map<std::uint64_t, Group> groups;  // by both names
  for (int i = 0; i < static_cast<int>(pairs.size()); ++i) {
    MonitoredPair& pair = pairs[i];
    const auto a = static_cast<std::uint32_t>(parts_[pair.a].name);
    const auto b = static_cast<std::uint32_t>(parts_[pair.b].name);
    const std::uint64_t names = std::uint64_t{a} << 32 | b;
    Group& group = groups.try_emplace(names, Group{static_cast<int>(groups.size())}).first->second;
    pair.index = i;
    pair.group = group.index;
    pair.identity = {names, group.pairs++};
    const auto before = known.find(pair.identity);
    if (before != known.end()) pair.state = before->second;
  }
  normals_.assign(pairs.size(), Eigen::Vector3d::UnitZ());
  pairs_ = std::move(pairs);
  blocks_.rebuild(pairs_, sides_);
  group_count_ = static_cast<int>(groups.size());
}

void MonitoredPairs::place(std::span<const MeasuredArm> arms, std::span<const ObstacleState> obstacles) {
  if (arms.size() != arms_.size() || obstacles.size() + links_ != carriers_.size()) {
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
  for (std::size_t i = 0; i < obstacles.size(); ++i) {
    Carrier& carrier = carriers_[links_ + i];
    if (carrier.parts.empty()) continue;
    const int arm = parts_[carrier.parts.front()].arm;
    if (arm < 0 || arms[arm].known) side_travel_[arms_.size() + i] += move(carrier, obstacles[i].X_WO);
  }
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
  const Eigen::Vector3d n_W = carriers_[a.carrier].X_WC.linear() * normals_[pair.index];
  return gap_along(to_bullet(n_W), *a.shape, X_WS(a), *b.shape, X_WS(b));
}

double MonitoredPairs::exact_distance(const MonitoredPair& pair) {
  const MonitoredPart& a = parts_[pair.a];
  const MonitoredPart& b = parts_[pair.b];
  const SignedDistance found = signed_distance(*a.shape, X_WS(a), *b.shape, X_WS(b));
  normals_[pair.index] = carriers_[a.carrier].X_WC.linear().transpose() * from_bullet(found.n_W);
  return found.distance;
}

}  // namespace hecaton::world
