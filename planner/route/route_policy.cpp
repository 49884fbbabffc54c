#include "planner/route/route_policy.hpp"

#include <algorithm>
#include <utility>

#include "planner/local/joint_distance.hpp"

namespace hecaton::planner {
namespace {

/// Between two checks of a route under way [s].
constexpr double kCheckInterval = 0.1;
/// On a route, the remaining length must fall by this factor within kRouteTimeout [s].
constexpr double kProgressFactor = 0.98;
constexpr double kRouteTimeout = 2.0;
/// Off a route, the interval between questions grows by this factor, up to kMaxQuestionInterval [s].
constexpr double kQuestionIntervalGrowth = 1.5;
constexpr double kMaxQuestionInterval = 8.0;

/// An answer is valid while the arm is within this of where it asked, in each joint [rad | m].
constexpr double kAnswerTolerance = 0.5;
/// Routes ignore an arm with a joint faster than this: it will not stay where it is [rad/s | m/s].
constexpr double kMovingSpeed = 0.1;

RouteQuestion make_question(const ArmController& controller, std::span<const ArmObservation> arms,
                            std::span<const world::ObstacleState> obstacles) {
  RouteQuestion question;
  const int self = controller.geometry().self();
  question.planned = {self};
  question.q = {controller.setpoint().q};
  question.q_goal = {*controller.goal()};
  const auto stands = [&](int i) { return i != self && arms[i].qd.cwiseAbs().maxCoeff() <= kMovingSpeed; };
  for (int i = 0; i < static_cast<int>(arms.size()); ++i) {
    question.arms.push_back(stands(i) ? extrapolated_position(controller.geometry(), arms, i) : JointVector());
  }
  question.obstacles = extrapolated_obstacles(obstacles);
  return question;
}

bool knows_all(const ArmController& controller, std::span<const ArmObservation> arms) {
  for (int i = 0; i < static_cast<int>(arms.size()); ++i) {
    if (i != controller.geometry().self() && !arms[i].known) return false;
  }
  return true;
}

}  // namespace

RoutePolicy::RoutePolicy(const LocalParameters& parameters, std::uint64_t seed)
    : stall_timeout_(parameters.method->traits().coordinates ? parameters.replanning.stall_timeout : 0.0),
      interval_(stall_timeout_),
      random_(seed),
      since_answer_(stall_timeout_) {}

RoutePolicy::Next RoutePolicy::next(const ArmController& controller, const TickResult& result,
                                    std::span<const ArmObservation> arms,
                                    std::span<const world::ObstacleState> obstacles) {
  Next next;
  if (stall_timeout_ <= 0.0) return next;
  const double dt = controller.control_period();
  since_answer_ += dt;
  const bool free_to_plan = result.status != TickStatus::kHolding && result.status != TickStatus::kStaleInput;
  const Route& route = controller.route();
  if (!controller.under_way() || !free_to_plan || controller.tracks()) return next;
  if (route.under_way()) {
    const double left = route.length(controller.geometry().own_arm().limits, controller.setpoint().q);
    const bool nearer = !on_route_ || left < kProgressFactor * nearest_;
    if (nearer) nearest_ = left;
    stuck_ = nearer || result.yields_to >= 0 ? 0.0 : stuck_ + controller.progress_period();
    next.leaves_route = stuck_ > kRouteTimeout;
  }
  on_route_ = route.under_way() && !next.leaves_route;
  const bool stalled = controller.goal_progress().time_without_progress() >= stall_timeout_;
  if (!stalled && !on_route_) interval_ = stall_timeout_;
  const bool due = since_answer_ >= (on_route_ ? kCheckInterval : interval_) && (on_route_ || stalled);
  if (open_ || !due || !knows_all(controller, arms)) return next;
  open_ = true;
  RouteQuestion& question = next.question.emplace(make_question(controller, arms, obstacles));
  if (on_route_) {
    for (const JointVector& point : route.left()) question.remaining.push_back({point});
  }
  question.seed = random_.next();
  q_ = controller.setpoint().q;
  q_goal_ = *controller.goal();
  return next;
}

std::optional<std::vector<JointVector>> RoutePolicy::receive(const RouteAnswer& answer,
                                                             const ArmController& controller) {
  open_ = false;
  since_answer_ = 0.0;
  if (std::exchange(dropped_, false) || !controller.goal() || *controller.goal() != q_goal_) return std::nullopt;
  const JointLimits& limits = controller.geometry().own_arm().limits;
  if (farthest_joint(limits, controller.setpoint().q, q_) > kAnswerTolerance) {
    return std::nullopt;
  }
  const bool was_on_route = controller.route().under_way();
  if (!was_on_route) interval_ = std::min(kMaxQuestionInterval, kQuestionIntervalGrowth * interval_);
  const bool found = answer.kind == RouteAnswer::Kind::kFound;
  if (found) {
    ++begun_;
    on_route_ = false;  // the remaining length of another route is not comparable
  }
  // The arm has left the route that the answer is about.
  if (answer.kind == RouteAnswer::Kind::kKept && !was_on_route) return std::nullopt;
  if (!found && !was_on_route) return std::nullopt;
  std::vector<JointVector> points;
  for (const JointPoint& point : answer.points) points.push_back(point.front());
  return points;
}

}  // namespace hecaton::planner
