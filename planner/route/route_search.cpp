#include "planner/route/route_search.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

namespace hecaton::planner {
namespace {

/// Clearance beyond the security distance dₛ, tried in this order [m]. Near dₛ, the velocity dampers slow the arm down.
constexpr std::array kClearanceLevels = {0.03, 0.01, 0.002};
/// The first and the last edge may be closer than dₛ by this [m]: a blocked arm stands close to an obstacle, and the
/// dampers always let it move away.
constexpr double kEndTolerance = 0.01;
/// Clearance between links of one arm beyond their security distance [m]; links are close to each other by design.
constexpr double kSelfClearance = 0.002;
/// Samples at each level for one arm, a few ms; for n arms together, n² times as many.
constexpr std::uint64_t kIterations = 4000;
/// More arms than this get kIterations samples only: joint sampling hardly solves their conflicts.
constexpr std::size_t kMaxSampledArms = 2;
/// Cost of expanding a vertex of the super graph, in checks of a configuration.
constexpr std::uint64_t kChecksPerExpansion = 4;
/// Samples around an end that is not free, and their largest distance in each joint [rad | m].
constexpr int kEndSamples = 256;
constexpr double kMaxEndDistance = 0.6;
/// Between checked configurations of an edge that is not proven [rad | m].
constexpr double kStep = 0.05;
/// Longest edge of a route in each joint [rad | m]: with longer ones, a continuous joint could turn the other way.
constexpr double kMaxEdge = 1.5;
/// Longest edge of a coupled plan in each joint [rad | m]; the arms wait for each other at each point.
constexpr double kMaxCoupledEdge = 0.3;

std::vector<float> padded(const global::Validity& validity, const std::vector<double>& q) {
  std::vector<float> result(validity.stride(), 0.0F);
  std::transform(q.begin(), q.end(), result.begin(), [](double x) { return static_cast<float>(x); });
  return result;
}

/// Equal within rounding.
bool same(const std::vector<double>& a, const std::vector<double>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), [](double x, double y) { return std::abs(x - y) < 1e-9; });
}

}  // namespace

RouteSearch::RouteSearch(std::vector<Arm> arms, std::vector<LocalParameters> parameters, int self)
    : arms_(std::move(arms)), parameters_(std::move(parameters)), self_(self), geometry_(arms_, self) {}

void RouteSearch::set_obstacles(std::span<const world::Obstacle> obstacles) {
  obstacles_.assign(obstacles.begin(), obstacles.end());
  geometry_.set_obstacles(obstacles_);
  levels_.clear();
  graphs_.clear();
}

/// Deferred to the first question, because covering links with spheres takes long.
void RouteSearch::build(const std::vector<int>& planned) {
  if (!levels_.empty() && planned == planned_) return;
  levels_.clear();
  graphs_.clear();
  planned_ = planned;
  lower_.clear();
  upper_.clear();
  std::vector<CellGeometry> geometries;
  double security = 0.0;
  double self_security = 0.0;
  for (const int arm : planned) {
    geometries.emplace_back(arms_, arm).set_obstacles(obstacles_);
    const JointLimits& limits = arms_[arm].limits;
    lower_.insert(lower_.end(), limits.lower.begin(), limits.lower.end());
    upper_.insert(upper_.end(), limits.upper.begin(), limits.upper.end());
    security = std::max(security, parameters_[arm].damper.security_distance);
    self_security = std::max(self_security, parameters_[arm].damper.self_security_distance);
  }
  global::ValidityOptions options;
  options.step = kStep;
  for (const double clearance : kClearanceLevels) {
    options.padding = security + clearance;
    options.self_padding = self_security + std::min(clearance, kSelfClearance);
    levels_.emplace_back(geometries, std::span<const global::WorldBody>(), options);
  }
  options.padding = std::max(0.0, security - kEndTolerance);
  options.self_padding = std::max(0.0, self_security - kEndTolerance);
  levels_.emplace_back(geometries, std::span<const global::WorldBody>(), options);
  graphs_.resize(levels_.size());
}

RouteSearch::Configuration RouteSearch::concatenated(const JointPoint& point) const {
  Configuration all;
  for (const JointVector& q : point) all.insert(all.end(), q.begin(), q.end());
  return all;
}

JointPoint RouteSearch::split(const Configuration& q) const {
  JointPoint point;
  const double* from = q.data();
  for (const int arm : planned_) {
    const Eigen::Index joints = arms_[arm].limits.lower.size();
    point.emplace_back(Eigen::Map<const Eigen::VectorXd>(from, joints));
    from += joints;
  }
  return point;
}

/// `to` plus full turns of continuous joints, nearest to `from`.
RouteSearch::Configuration RouteSearch::nearest_turn(const Configuration& from, const Configuration& to) const {
  Configuration near = to;
  for (std::size_t j = 0; j < near.size(); ++j) {
    if (std::isinf(upper_[j])) near[j] = from[j] + std::remainder(to[j] - from[j], 2.0 * std::numbers::pi);
  }
  return near;
}

/// A blocked arm may stand closer to something than the padding of this level. Then no proof holds at the first end,
/// and the rest of the edge is checked at steps.
bool RouteSearch::edge_free(int level, const Configuration& a, const Configuration& b) const {
  const global::Validity& validity = levels_[level];
  const std::vector<float> from = padded(validity, a);
  const bool proven = validity.state_free(from.data());
  return validity.edge_free(from.data(), padded(validity, nearest_turn(a, b)).data(), {.proven = proven});
}

/// The rest of the route from the farthest point that a free edge reaches. Checked at the last level, because a route
/// may have been found there.
std::optional<std::vector<JointPoint>> RouteSearch::keep(const RouteQuestion& question) const {
  const int level = static_cast<int>(kClearanceLevels.size()) - 1;
  std::vector<Configuration> left;
  for (const JointPoint& point : question.remaining) left.push_back(concatenated(point));
  for (std::size_t i = 0; i + 1 < left.size(); ++i) {
    if (!edge_free(level + (i + 2 == left.size() ? 1 : 0), left[i], left[i + 1])) return std::nullopt;
  }
  const Configuration from = concatenated(question.q);
  for (std::size_t i = left.size(); i > 0; --i) {
    if (!edge_free(i == 1 ? level + 1 : level, from, left[i - 1])) continue;
    return std::vector(question.remaining.begin() + static_cast<std::ptrdiff_t>(i) - 1, question.remaining.end());
  }
  return std::nullopt;
}

/// q if it is free at `level`; otherwise a free configuration nearby with a free edge to q.
std::optional<RouteSearch::Configuration> RouteSearch::free_near(int level, const Configuration& q,
                                                                 Random& random) const {
  const global::Validity& validity = levels_[level];
  if (validity.state_free(padded(validity, q).data())) return q;
  const int least = static_cast<int>(levels_.size()) - 1;
  for (int i = 1; i <= kEndSamples; ++i) {
    const double reach = kMaxEndDistance * i / kEndSamples;
    Configuration near = q;
    for (std::size_t j = 0; j < q.size(); ++j) {
      near[j] = std::clamp(q[j] + random.uniform(-reach, reach), lower_[j], upper_[j]);
    }
    if (validity.state_free(padded(validity, near).data()) && edge_free(least, q, near)) return near;
  }
  return std::nullopt;
}

/// The points after the first one, with long edges divided.
std::vector<JointPoint> RouteSearch::divided(const std::vector<Configuration>& points) const {
  std::vector<JointPoint> result;
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    const Configuration& a = points[i];
    const Configuration& b = points[i + 1];
    double longest = 0.0;
    for (std::size_t j = 0; j < a.size(); ++j) longest = std::max(longest, std::abs(b[j] - a[j]));
    const int parts =
        std::max(1, static_cast<int>(std::ceil(longest / (planned_.size() > 1 ? kMaxCoupledEdge : kMaxEdge))));
    for (int k = 1; k <= parts; ++k) {
      Configuration point = b;
      for (std::size_t j = 0; k < parts && j < a.size(); ++j) point[j] = a[j] + (b[j] - a[j]) * k / parts;
      result.push_back(split(point));
    }
  }
  return result;
}

/// Samples all joints together; if that fails for several arms, searches the super graph.
global::Plan RouteSearch::plan(int level, const Configuration& from, const Configuration& to, std::uint64_t seed) {
  const std::size_t arms = planned_.size();
  global::PlanOptions options;
  options.seed = seed;
  options.budget.iterations = arms > kMaxSampledArms ? kIterations : kIterations * arms * arms;
  global::Plan sampled = global::plan(levels_[level], from, to, options);
  return sampled.solved() || arms == 1 ? sampled : plan_by_roadmaps(level, from, to, options);
}

global::Plan RouteSearch::plan_by_roadmaps(int level, const Configuration& from, const Configuration& to,
                                           const global::PlanOptions& options) {
  const global::Validity& validity = levels_[level];
  std::unique_ptr<global::SuperGraph>& graph = graphs_[level];
  if (!graph) graph = std::make_unique<global::SuperGraph>(validity.planned(), validity.options());
  graph->set_world(world_);
  global::Plan plan = graph->plan(from, to, options.seed);
  expansions_ += plan.iterations;
  for (std::size_t i = 0; i + 1 < plan.path.size(); ++i) {
    // Checks of two arms at a time hold for all arms, except for rounding.
    if (!edge_free(level, plan.path[i], plan.path[i + 1])) return {};
  }
  global::simplify(validity, options, plan);
  return plan;
}

std::optional<std::vector<JointPoint>> RouteSearch::search(int level, const RouteQuestion& question) {
  Random random(question.seed);
  const Configuration start = concatenated(question.q);
  const Configuration goal = nearest_turn(start, concatenated(question.q_goal));
  const auto first = free_near(level, start, random);
  const auto last = free_near(level, goal, random);
  if (!first || !last) return std::nullopt;
  const global::Plan found = plan(level, *first, *last, random.next());
  if (!found.solved()) return std::nullopt;
  std::vector<Configuration> points{start};
  for (const Configuration& q : found.path) {
    if (q != points.back()) points.push_back(q);
  }
  // The path may end at the goal plus full turns.
  const Configuration end = nearest_turn(points.back(), goal);
  if (!same(points.back(), end)) points.push_back(end);
  return divided(points);
}

RouteAnswer RouteSearch::answer(const RouteQuestion& question) {
  build(question.planned);
  std::vector<Pose> X_WO;
  for (const world::ObstacleState& obstacle : question.obstacles) X_WO.push_back(obstacle.X_WO);
  std::vector<JointVector> others = question.arms;
  for (const int arm : question.planned) others[arm].resize(0);
  world_ = global::world_bodies(geometry_, X_WO, others);
  for (global::Validity& level : levels_) level.set_world(world_);
  expansions_ = 0;
  const std::uint64_t before = checks();
  const int searched = static_cast<int>(kClearanceLevels.size());
  RouteAnswer answer;
  if (edge_free(searched - 1, concatenated(question.q), concatenated(question.q_goal))) {
    answer.kind = RouteAnswer::Kind::kStraight;
    if (planned_.size() > 1) {
      const Configuration start = concatenated(question.q);
      answer.points = divided({start, nearest_turn(start, concatenated(question.q_goal))});
    }
  } else if (auto kept = keep(question); kept && !question.remaining.empty()) {
    answer.kind = RouteAnswer::Kind::kKept;
    answer.points = std::move(*kept);
  } else {
    for (int level = 0; level < searched && answer.kind == RouteAnswer::Kind::kNone; ++level) {
      if (auto found = search(level, question)) {
        answer.kind = RouteAnswer::Kind::kFound;
        answer.points = std::move(*found);
      }
    }
  }
  answer.checks = checks() - before + kChecksPerExpansion * expansions_;
  return answer;
}

std::uint64_t RouteSearch::checks() const {
  std::uint64_t sum = 0;
  for (const global::Validity& level : levels_) sum += level.checks();
  for (const auto& graph : graphs_) sum += graph ? graph->checks() : 0;
  return sum;
}

}  // namespace hecaton::planner
