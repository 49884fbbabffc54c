#include "planner/route/route_search.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "planner/local/goal_objective.hpp"

namespace hecaton::planner {
namespace {

/// What a route keeps beyond dₛ, tried in this order [m]: dampers let an arm go fast with the first, creep with the
/// last.
constexpr std::array kBeyondSecurity = {0.03, 0.01, 0.002};
/// An arm in trouble stands near something: from there, and to such a goal, the last step may keep this much less than
/// dₛ [m]. Dampers always let an arm go away from things.
constexpr double kLeastBelowSecurity = 0.01;
/// So many samples at each distance: some ms at most.
constexpr std::uint64_t kIterations = 4000;
/// Configurations around a crowded end, at most so far away in each joint [rad | m].
constexpr int kBeside = 256;
constexpr double kFarthestBeside = 0.6;
/// Between configurations that are checked [rad | m].
constexpr double kStep = 0.05;
/// Continuous joints go the short way round: no straight part of a route turns a joint farther than this [rad].
constexpr double kLongestPart = 1.5;

std::vector<double> as_vector(const JointVector& q) {
  return {q.data(), q.data() + q.size()};
}

std::vector<float> padded(const global::Validity& validity, const JointVector& q) {
  std::vector<float> result(validity.stride(), 0.0F);
  std::transform(q.data(), q.data() + q.size(), result.begin(), [](double x) { return static_cast<float>(x); });
  return result;
}

/// The points after the first, with long parts divided.
std::vector<JointVector> divided(const std::vector<JointVector>& points) {
  std::vector<JointVector> result;
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    const JointVector way = points[i + 1] - points[i];
    const int parts = std::max(1, static_cast<int>(std::ceil(way.cwiseAbs().maxCoeff() / kLongestPart)));
    for (int k = 1; k < parts; ++k) result.push_back(points[i] + way * (static_cast<double>(k) / parts));
    result.push_back(points[i + 1]);
  }
  return result;
}

}  // namespace

RouteSearch::RouteSearch(std::vector<Arm> arms, int self, const LocalParameters& parameters)
    : geometry_(std::move(arms), self), parameters_(parameters) {}

void RouteSearch::set_obstacles(std::span<const world::Obstacle> obstacles) {
  geometry_.set_obstacles(obstacles);
  levels_.clear();
}

/// Not before the first question: to cover an arm's links with balls takes a while.
void RouteSearch::build() {
  if (!levels_.empty()) return;
  const double security = parameters_.damper.security_distance;
  global::ValidityOptions options;
  options.step = kStep;
  for (const double beyond : kBeyondSecurity) {
    options.padding = security + beyond;
    levels_.emplace_back(std::vector{geometry_}, std::span<const global::WorldBody>(), options);
  }
  options.padding = std::max(0.0, security - kLeastBelowSecurity);
  levels_.emplace_back(std::vector{geometry_}, std::span<const global::WorldBody>(), options);
}

bool RouteSearch::straight(int level, const JointVector& a, const JointVector& b) const {
  const global::Validity& validity = levels_[level];
  const JointVector to = a + joint_difference(geometry_.own_arm().limits, a, b);
  return validity.edge_free(padded(validity, a).data(), padded(validity, to).data());
}

/// The farthest point that is in sight, and the rest as it was. The last level: who follows a route is near things.
std::optional<std::vector<JointVector>> RouteSearch::keep(const RouteQuestion& question) const {
  const int level = static_cast<int>(kBeyondSecurity.size()) - 1;
  const std::vector<JointVector>& left = question.left;
  for (std::size_t i = 0; i + 1 < left.size(); ++i) {
    if (!straight(level + (i + 2 == left.size() ? 1 : 0), left[i], left[i + 1])) return std::nullopt;
  }
  for (std::size_t i = left.size(); i > 0; --i) {
    if (!straight(i == 1 ? level + 1 : level, question.q, left[i - 1])) continue;
    return std::vector(left.begin() + static_cast<std::ptrdiff_t>(i) - 1, left.end());
  }
  return std::nullopt;
}

/// q itself if it keeps the distance of `level`; otherwise what does so nearby and is reached straight.
std::optional<JointVector> RouteSearch::beside(int level, const JointVector& q, Random& random) const {
  const global::Validity& validity = levels_[level];
  if (validity.state_free(padded(validity, q).data())) return q;
  const int least = static_cast<int>(levels_.size()) - 1;
  const JointLimits& limits = geometry_.own_arm().limits;
  for (int i = 1; i <= kBeside; ++i) {
    const double reach = kFarthestBeside * i / kBeside;
    JointVector near = q;
    for (Eigen::Index j = 0; j < q.size(); ++j) {
      near[j] = std::clamp(q[j] + random.uniform(-reach, reach), limits.lower[j], limits.upper[j]);
    }
    if (validity.state_free(padded(validity, near).data()) && straight(least, q, near)) return near;
  }
  return std::nullopt;
}

std::optional<std::vector<JointVector>> RouteSearch::search(int level, const RouteQuestion& question) const {
  Random random(question.seed);
  const JointVector goal = question.q + joint_difference(geometry_.own_arm().limits, question.q, question.q_goal);
  const auto first = beside(level, question.q, random);
  const auto last = beside(level, goal, random);
  if (!first || !last) return std::nullopt;
  global::PlanOptions options;
  options.seed = random.next();
  options.budget.iterations = kIterations;
  options.certify = 1;
  const global::Plan plan = global::plan(levels_[level], as_vector(*first), as_vector(*last), options);
  if (!plan.solved()) return std::nullopt;
  std::vector<JointVector> points{question.q};
  for (const std::vector<double>& q : plan.path) {
    const JointVector point = Eigen::Map<const Eigen::VectorXd>(q.data(), static_cast<Eigen::Index>(q.size()));
    if (point != points.back()) points.push_back(point);
  }
  if (points.back() != goal) points.push_back(goal);
  return divided(points);
}

RouteAnswer RouteSearch::answer(const RouteQuestion& question) {
  build();
  std::vector<Pose> X_WO;
  for (const world::ObstacleState& obstacle : question.obstacles) X_WO.push_back(obstacle.X_WO);
  const std::vector<global::WorldBody> bodies = global::world_bodies(geometry_, X_WO, question.arms);
  for (global::Validity& level : levels_) level.set_world(bodies);
  const std::uint64_t before = checks();
  const int searched = static_cast<int>(kBeyondSecurity.size());
  RouteAnswer answer;
  if (straight(searched - 1, question.q, question.q_goal)) {
    answer.kind = RouteAnswer::Kind::kStraight;
  } else if (auto kept = keep(question); kept && !question.left.empty()) {
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
  answer.checks = checks() - before;
  return answer;
}

std::uint64_t RouteSearch::checks() const {
  std::uint64_t sum = 0;
  for (const global::Validity& level : levels_) sum += level.checks();
  return sum;
}

}  // namespace hecaton::planner
