#include "planner/route/multi_arm_coordinator.hpp"

#include <algorithm>
#include <utility>

#include "planner/global/validity_data.hpp"

namespace hecaton::planner {
namespace {

/// An arm joins where the plan begins no farther from it than this, in each joint, and has it go where it wants to go
/// [rad | m].
constexpr double kNearBeginning = 0.3;
constexpr double kSameGoal = 0.05;
/// A point counts as reached within this, in each joint [rad | m].
constexpr double kReached = 0.08;
/// All arms must have joined after the first time, and all have reached the next point after the second [s].
constexpr double kToJoin = 1.0;
constexpr double kToAdvance = 4.0;
/// Each question is followed by a pause that is so many times longer, up to kLongestPause [s].
constexpr double kPauseGrowth = 1.5;
constexpr double kLongestPause = 20.0;

double farthest_joint(const JointLimits& limits, const JointVector& a, const JointVector& b) {
  return joint_difference(limits, a, b).cwiseAbs().maxCoeff();
}

bool may_meet(const CellGeometry& geometry, int i, double influence) {
  const world::BoundingSphere& own = geometry.arm_reach(geometry.self());
  const world::BoundingSphere& other = geometry.arm_reach(i);
  return (own.centre - other.centre).norm() < own.radius + other.radius + influence;
}

}  // namespace

MultiArmCoordinator::MultiArmCoordinator(const LocalParameters& parameters, std::uint64_t seed,
                                         std::uint32_t numbers_after)
    : after_(parameters.method->traits().coordinates ? parameters.coordination.stall_timeout : 0.0),
      patience_(after_),
      random_(seed),
      since_answer_(after_),
      number_(numbers_after) {}

std::optional<RouteQuestion> MultiArmCoordinator::next(const ArmController& controller, const TickResult& result,
                                                       std::span<const ArmObservation> arms,
                                                       std::span<const world::ObstacleState> obstacles) {
  if (after_ <= 0.0 || arms.size() < 2) return std::nullopt;
  const double dt = controller.control_period();
  since_answer_ += dt;
  const bool free_to_plan = result.status != TickStatus::kHolding && result.status != TickStatus::kStaleInput;
  if (!free_to_plan) {
    leave();
    proposal_.reset();
    return std::nullopt;
  }
  join_or_stay(controller, arms);
  if (takes_part()) advance(controller, arms, dt);
  if (takes_part() || open_ || !controller.under_way()) return std::nullopt;
  const double lost = controller.goal_progress().time_without_progress();
  if (lost < after_) patience_ = after_;
  if (lost < after_ || since_answer_ < patience_ || !controller.memory().right_of_way.leads) return std::nullopt;
  question_ = make_question(controller, arms, obstacles);
  if (question_.planned.size() < 2) return std::nullopt;
  open_ = true;
  return question_;
}

RouteQuestion MultiArmCoordinator::make_question(const ArmController& controller, std::span<const ArmObservation> arms,
                                                 std::span<const world::ObstacleState> obstacles) {
  RouteQuestion question;
  const CellGeometry& geometry = controller.geometry();
  const double influence = controller.parameters().damper.influence_distance;
  int joints = geometry.own_arm().model->joints();
  for (int i = 0; i < static_cast<int>(arms.size()); ++i) {
    const bool own = i == geometry.self();
    question.arms.push_back(own || !arms[i].known ? JointVector() : extrapolated_position(geometry, arms, i));
    const int more = geometry.arms()[i].model->joints();
    const bool follows = arms[i].known && arms[i].plans && !arms[i].lost() && may_meet(geometry, i, influence);
    if (!own && (!follows || joints + more > global::kMostDimensions)) continue;
    if (!own) joints += more;
    question.planned.push_back(i);
    question.q.push_back(own ? controller.setpoint().q : question.arms.back());
    question.q_goal.push_back(own ? *controller.goal() : arms[i].has_goal ? arms[i].q_goal : question.arms.back());
  }
  question.obstacles = extrapolated_obstacles(obstacles);
  question.seed = random_.next();
  return question;
}

void MultiArmCoordinator::answered(const RouteAnswer& answer) {
  open_ = false;
  since_answer_ = 0.0;
  if (std::exchange(dropped_, false)) return;
  patience_ = std::min(kLongestPause, kPauseGrowth * patience_);
  const bool goes = answer.kind == RouteAnswer::Kind::kFound || answer.kind == RouteAnswer::Kind::kStraight;
  if (!goes || takes_part()) return;
  auto plan = std::make_shared<CoupledPlan>();
  plan->number = ++number_;
  ++proposed_;
  plan->arms = question_.planned;
  plan->points.push_back(question_.q);
  plan->points.insert(plan->points.end(), answer.points.begin(), answer.points.end());
  proposal_ = std::move(plan);
}

void MultiArmCoordinator::resign() {
  leave();
  proposal_.reset();
  dropped_ = open_;
}

bool MultiArmCoordinator::suits(const CoupledPlan& plan, const ArmController& controller) const {
  const int self = controller.geometry().self();
  const auto found = std::find(plan.arms.begin(), plan.arms.end(), self);
  if (found == plan.arms.end() || plan.points.empty()) return false;
  const auto index = static_cast<std::size_t>(found - plan.arms.begin());
  for (const auto& point : plan.points) {
    const bool fits = point.size() == plan.arms.size() && point[index].size() == controller.setpoint().q.size();
    if (!fits) return false;
  }
  const JointLimits& limits = controller.geometry().own_arm().limits;
  const JointVector& begins = plan.points.front()[index];
  const JointVector& ends = plan.points.back()[index];
  const JointVector& wanted = controller.under_way() ? *controller.goal() : begins;
  return farthest_joint(limits, controller.setpoint().q, begins) < kNearBeginning &&
         farthest_joint(limits, wanted, ends) < kSameGoal;
}

/// The plan of whoever goes first [planner/local/right_of_way.hpp] counts; one that the arm has left it does not join
/// again.
void MultiArmCoordinator::join_or_stay(const ArmController& controller, std::span<const ArmObservation> arms) {
  const int self = controller.geometry().self();
  const auto offered = [&](int i) { return i == self ? proposal_ : arms[i].proposal; };
  const auto priority = [&](int i) { return Priority{i == self ? controller.priority() : arms[i].priority, i}; };
  if (takes_part()) {
    const auto current = offered(part_.progress.proposer);
    if (!current || current->number != part_.progress.number) leave();
  }
  for (int i = 0; i < static_cast<int>(arms.size()); ++i) {
    const auto plan = offered(i);
    if (!plan || part_.progress.of(i, plan->number) || last_.of(i, plan->number)) continue;
    if (takes_part() && !priority(i).precedes(priority(part_.progress.proposer))) continue;
    if (!suits(*plan, controller)) continue;
    if (takes_part()) leave();
    join(i, plan);
    part_.index = static_cast<int>(std::find(plan->arms.begin(), plan->arms.end(), self) - plan->arms.begin());
  }
  // What nobody goes by is withdrawn.
  if (proposal_ && !part_.progress.of(self, proposal_->number)) proposal_.reset();
}

void MultiArmCoordinator::join(int proposer, std::shared_ptr<const CoupledPlan> plan) {
  part_ = {};
  part_.progress = {proposer, plan->number, -1};
  part_.plan = std::move(plan);
}

void MultiArmCoordinator::leave() {
  if (!takes_part()) return;
  last_ = part_.progress;
  part_ = {};
}

/// To the next point once all have reached the last one.
void MultiArmCoordinator::advance(const ArmController& controller, std::span<const ArmObservation> arms, double dt) {
  const int self = controller.geometry().self();
  const int last = static_cast<int>(part_.plan->points.size()) - 1;
  int together = part_.progress.reached;
  bool all_joined = true;
  bool failed = false;
  for (const int i : part_.plan->arms) {
    if (i == self) continue;
    failed = failed || !arms[i].plans || arms[i].lost();  // what it said last it says no more
    const bool joined = arms[i].progress.of(part_.progress.proposer, part_.progress.number);
    all_joined = all_joined && joined;
    together = std::min(together, joined ? arms[i].progress.reached : -1);
  }
  part_.since_together =
      together > part_.together || (all_joined && !part_.all_joined) ? 0.0 : part_.since_together + dt;
  const bool left = part_.all_joined && !all_joined && part_.together < last;
  part_.all_joined = part_.all_joined || all_joined;
  part_.together = std::max(part_.together, together);
  const bool late = part_.since_together > (part_.all_joined ? kToAdvance : kToJoin);
  const bool wants_it = !controller.under_way() || suits_goal(controller);
  if (left || failed || late || !wants_it || part_.together == last) {
    leave();
    return;
  }
  const int next = std::min(part_.all_joined ? part_.together + 1 : 0, last);
  const JointVector& aim = part_.plan->points[next][part_.index];
  const JointLimits& limits = controller.geometry().own_arm().limits;
  if (part_.all_joined && farthest_joint(limits, controller.setpoint().q, aim) < kReached) {
    part_.progress.reached = std::max(part_.progress.reached, next);
  }
  part_.aim = aim;
}

bool MultiArmCoordinator::suits_goal(const ArmController& controller) const {
  const JointLimits& limits = controller.geometry().own_arm().limits;
  return farthest_joint(limits, *controller.goal(), part_.plan->points.back()[part_.index]) < kSameGoal;
}

}  // namespace hecaton::planner
