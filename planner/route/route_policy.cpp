#include "planner/route/route_policy.hpp"

#include <algorithm>
#include <utility>

namespace hecaton::planner {
namespace {

/// Between two looks at whether a route is free [s].
constexpr double kLookInterval = 0.1;
/// On a route an arm must come nearer to its end, by this share of what is left, within this time [s].
constexpr double kNearer = 0.98;
constexpr double kPatienceOnRoute = 2.0;
/// Off a route, each question that did not help is followed by a pause that is so many times longer, up to kLongest
/// [s].
constexpr double kGrowth = 1.5;
constexpr double kLongest = 8.0;

/// An answer is for an arm that is still so near to where it asked, in each joint [rad | m].
constexpr double kStillThere = 0.5;
/// An arm with a joint faster than this is on its way, and where it is now is not where it will be in the way [rad/s |
/// m/s].
constexpr double kMoves = 0.1;

RouteQuestion make_question(const ArmController& controller, std::span<const ArmObservation> arms,
                            std::span<const world::ObstacleState> obstacles) {
  RouteQuestion question;
  const int self = controller.geometry().self();
  question.planned = {self};
  question.q = {controller.setpoint().q};
  question.q_goal = {*controller.goal()};
  const auto stands = [&](int i) { return i != self && arms[i].qd.cwiseAbs().maxCoeff() <= kMoves; };
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
    : after_(parameters.method->traits().coordinates ? parameters.replanning.stall_timeout : 0.0),
      patience_(after_),
      random_(seed),
      since_answer_(after_) {}

RoutePolicy::Next RoutePolicy::next(const ArmController& controller, const TickResult& result,
                                    std::span<const ArmObservation> arms,
                                    std::span<const world::ObstacleState> obstacles) {
  Next next;
  if (after_ <= 0.0) return next;
  const double dt = controller.control_period();
  since_answer_ += dt;
  const bool free_to_plan = result.status != TickStatus::kHolding && result.status != TickStatus::kStaleInput;
  const Route& route = controller.route();
  if (!controller.under_way() || !free_to_plan) return next;
  if (route.under_way()) {
    const double left = route.length(controller.geometry().own_arm().limits, controller.setpoint().q);
    const bool nearer = !on_route_ || left < kNearer * nearest_;
    if (nearer) nearest_ = left;
    stuck_ = nearer || result.yields_to >= 0 ? 0.0 : stuck_ + dt;
    next.leaves_route = stuck_ > kPatienceOnRoute;
  }
  on_route_ = route.under_way() && !next.leaves_route;
  const bool lost = controller.goal_progress().time_without_progress() >= after_;
  if (!lost && !on_route_) patience_ = after_;
  const bool due = since_answer_ >= (on_route_ ? kLookInterval : patience_) && (on_route_ || lost);
  if (open_ || !due || !knows_all(controller, arms)) return next;
  open_ = true;
  RouteQuestion& question = next.question.emplace(make_question(controller, arms, obstacles));
  if (on_route_) {
    for (const JointVector& point : route.left()) question.left.push_back({point});
  }
  question.seed = random_.next();
  q_ = controller.setpoint().q;
  q_goal_ = *controller.goal();
  return next;
}

std::optional<std::vector<JointVector>> RoutePolicy::answered(const RouteAnswer& answer,
                                                              const ArmController& controller) {
  open_ = false;
  since_answer_ = 0.0;
  if (std::exchange(dropped_, false) || !controller.goal() || *controller.goal() != q_goal_) return std::nullopt;
  const JointLimits& limits = controller.geometry().own_arm().limits;
  if (joint_difference(limits, controller.setpoint().q, q_).cwiseAbs().maxCoeff() > kStillThere) {
    return std::nullopt;
  }
  const bool was_on_route = controller.route().under_way();
  if (!was_on_route) patience_ = std::min(kLongest, kGrowth * patience_);
  const bool goes = answer.kind == RouteAnswer::Kind::kFound;
  if (goes) {
    ++found_;
    on_route_ = false;  // another route is another length
  }
  // What was asked while the arm was on a route that it has left meanwhile has no answer any more.
  if (answer.kind == RouteAnswer::Kind::kKept && !was_on_route) return std::nullopt;
  if (!goes && !was_on_route) return std::nullopt;
  std::vector<JointVector> points;
  for (const JointPoint& point : answer.points) points.push_back(point.front());
  return points;
}

}  // namespace hecaton::planner
