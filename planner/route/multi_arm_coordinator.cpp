#include "planner/route/multi_arm_coordinator.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include "planner/global/validity_kernel.hpp"
#include "planner/local/joint_distance.hpp"

namespace hecaton::planner {
namespace {

/// An arm joins a plan whose start is within kStartTolerance, and whose end is within kGoalTolerance of its goal, in
/// each joint [rad | m].
constexpr double kStartTolerance = 0.3;
constexpr double kGoalTolerance = 0.05;
/// A point is reached within this, in each joint [rad | m].
constexpr double kPointTolerance = 0.08;
/// Time-outs for all arms to join, and for all arms to reach the next point [s]; the second counts
/// with the speed of the slowest arm.
constexpr double kJoinTimeout = 1.0;
constexpr double kPointTimeout = 4.0;
/// The interval between questions grows by this factor, up to kMaxInterval [s].
constexpr double kIntervalGrowth = 1.5;
constexpr double kMaxInterval = 20.0;

/// True if the reach of arm i comes within `influence` [m] of the own arm's.
bool may_interact(const CellGeometry& geometry, int i, double influence) {
  const world::BoundingSphere& own = geometry.arm_reach(geometry.self());
  const world::BoundingSphere& other = geometry.arm_reach(i);
  return (own.centre - other.centre).norm() < own.radius + other.radius + influence;
}

}  // namespace

MultiArmCoordinator::MultiArmCoordinator(const LocalParameters& parameters, std::uint64_t seed,
                                         std::uint32_t numbers_after)
    : stall_timeout_(parameters.method->traits().coordinates ? parameters.coordination.stall_timeout : 0.0),
      interval_(stall_timeout_),
      random_(seed),
      since_answer_(stall_timeout_),
      number_(numbers_after) {}

std::optional<RouteQuestion> MultiArmCoordinator::next(const ArmController& controller, const TickResult& result,
                                                       std::span<const ArmObservation> arms,
                                                       std::span<const world::ObstacleState> obstacles) {
  if (stall_timeout_ <= 0.0 || arms.size() < 2) return std::nullopt;
  const double dt = controller.control_period();
  since_answer_ += dt;
  const bool free_to_plan = result.status != TickStatus::kHolding && result.status != TickStatus::kStaleInput;
  if (!free_to_plan) {
    leave();
    proposal_.reset();
    return std::nullopt;
  }
  choose_plan(controller, arms);
  if (participating()) advance(controller, arms, dt);
  if (participating() || open_ || !controller.under_way() || controller.tracks()) return std::nullopt;
  const double stalled_for = controller.goal_progress().time_without_progress();
  if (stalled_for < stall_timeout_) interval_ = stall_timeout_;
  if (stalled_for < stall_timeout_ || since_answer_ < interval_ || !controller.memory().right_of_way.leads)
    return std::nullopt;
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
    const bool follows = arms[i].known && arms[i].plans && !arms[i].lost() && may_interact(geometry, i, influence);
    if (!own && (!follows || joints + more > global::kMaxDimensions)) continue;
    if (!own) joints += more;
    question.planned.push_back(i);
    question.q.push_back(own ? controller.setpoint().q : question.arms.back());
    question.q_goal.push_back(own ? *controller.goal() : arms[i].has_goal ? arms[i].q_goal : question.arms.back());
  }
  question.obstacles = extrapolated_obstacles(obstacles);
  question.seed = random_.next();
  return question;
}

namespace {

void describe_plan(MemoryArchive& archive, std::shared_ptr<const CoupledPlan>& plan) {
  std::optional<CoupledPlan> value;
  if (plan) value = *plan;
  archive.optional(value);
  if (archive.loads()) plan = value ? std::make_shared<const CoupledPlan>(std::move(*value)) : nullptr;
}

}  // namespace

void MultiArmCoordinator::Part::describe(MemoryArchive& archive) {
  describe_plan(archive, plan);
  archive(progress);
  archive.count(index);
  archive.optional(target);
  archive.count(reached_by_all);
  archive(since_progress, all_joined);
  if (!archive.loads() || !plan) return;
  const bool fits = progress.proposer >= 0 && index >= 0 && index < static_cast<int>(plan->arms.size()) &&
                    !plan->points.empty() && reached_by_all < static_cast<int>(plan->points.size());
  if (!fits) archive.fail();
}

// Of the open question only what receive() uses.
void MultiArmCoordinator::describe(MemoryArchive& archive) {
  archive(interval_, random_);
  archive.list(question_.planned, [&](int& arm) { archive.index(arm); });
  archive.list(question_.q, [&](JointVector& q) { archive.any_joints(q); });
  archive(open_, dropped_, since_answer_, number_);
  archive.count(proposed_);
  describe_plan(archive, proposal_);
  archive(part_, last_);
}

void MultiArmCoordinator::receive(const RouteAnswer& answer) {
  open_ = false;
  since_answer_ = 0.0;
  if (std::exchange(dropped_, false)) return;
  interval_ = std::min(kMaxInterval, kIntervalGrowth * interval_);
  const bool found = answer.kind == RouteAnswer::Kind::kFound || answer.kind == RouteAnswer::Kind::kStraight;
  if (!found || participating()) return;
  auto plan = std::make_shared<CoupledPlan>();
  plan->number = ++number_;
  ++proposed_;
  plan->arms = question_.planned;
  plan->points.push_back(question_.q);
  plan->points.insert(plan->points.end(), answer.points.begin(), answer.points.end());
  proposal_ = std::move(plan);
}

void MultiArmCoordinator::withdraw() {
  leave();
  proposal_.reset();
  dropped_ = open_;
}

bool MultiArmCoordinator::can_join(const CoupledPlan& plan, const ArmController& controller) const {
  const int self = controller.geometry().self();
  const auto found = std::find(plan.arms.begin(), plan.arms.end(), self);
  if (found == plan.arms.end() || plan.points.empty() || controller.tracks()) return false;
  const auto index = static_cast<std::size_t>(found - plan.arms.begin());
  for (const auto& point : plan.points) {
    const bool valid = point.size() == plan.arms.size() && point[index].size() == controller.setpoint().q.size();
    if (!valid) return false;
  }
  const JointLimits& limits = controller.geometry().own_arm().limits;
  const JointVector& begins = plan.points.front()[index];
  const JointVector& ends = plan.points.back()[index];
  const JointVector& wanted = controller.under_way() ? *controller.goal() : begins;
  return farthest_joint(limits, controller.setpoint().q, begins) < kStartTolerance &&
         farthest_joint(limits, wanted, ends) < kGoalTolerance;
}

/// Of several plans, the arm follows that of the proposer with the highest priority (planner/local/right_of_way.hpp).
/// It does not join a plan again that it has left.
void MultiArmCoordinator::choose_plan(const ArmController& controller, std::span<const ArmObservation> arms) {
  const int self = controller.geometry().self();
  const auto offered = [&](int i) { return i == self ? proposal_ : arms[i].proposal; };
  const auto priority = [&](int i) { return Priority{i == self ? controller.priority() : arms[i].priority, i}; };
  if (participating()) {
    const auto current = offered(part_.progress.proposer);
    if (!current || current->number != part_.progress.number) leave();
  }
  for (int i = 0; i < static_cast<int>(arms.size()); ++i) {
    const auto plan = offered(i);
    if (!plan || part_.progress.of(i, plan->number) || last_.of(i, plan->number)) continue;
    if (participating() && !priority(i).precedes(priority(part_.progress.proposer))) continue;
    if (!can_join(*plan, controller)) continue;
    if (participating()) leave();
    join(i, plan);
    part_.index = static_cast<int>(std::find(plan->arms.begin(), plan->arms.end(), self) - plan->arms.begin());
  }
  // The arm withdraws its proposal when it does not follow the plan itself.
  if (proposal_ && !part_.progress.of(self, proposal_->number)) proposal_.reset();
}

void MultiArmCoordinator::join(int proposer, std::shared_ptr<const CoupledPlan> plan) {
  part_ = {};
  part_.progress = {proposer, plan->number, -1};
  part_.plan = std::move(plan);
}

void MultiArmCoordinator::leave() {
  if (!participating()) return;
  last_ = part_.progress;
  part_ = {};
}

/// Selects the next point once all arms have reached the last one.
void MultiArmCoordinator::advance(const ArmController& controller, std::span<const ArmObservation> arms, double dt) {
  const int self = controller.geometry().self();
  const int last = static_cast<int>(part_.plan->points.size()) - 1;
  int reached_by_all = part_.progress.reached;
  bool all_joined = true;
  bool failed = false;
  double slowest = controller.speed();
  for (const int i : part_.plan->arms) {
    if (i == self) continue;
    slowest = std::min(slowest, arms[i].speed);
    failed = failed || !arms[i].plans || arms[i].lost();  // its last progress is no longer valid
    const bool joined = arms[i].progress.of(part_.progress.proposer, part_.progress.number);
    all_joined = all_joined && joined;
    reached_by_all = std::min(reached_by_all, joined ? arms[i].progress.reached : -1);
  }
  const double counted = part_.all_joined ? dt * std::max(slowest, kSlowestShare) : dt;
  part_.since_progress =
      reached_by_all > part_.reached_by_all || (all_joined && !part_.all_joined) ? 0.0 : part_.since_progress + counted;
  const bool left = part_.all_joined && !all_joined && part_.reached_by_all < last;
  part_.all_joined = part_.all_joined || all_joined;
  part_.reached_by_all = std::max(part_.reached_by_all, reached_by_all);
  const bool late = part_.since_progress > (part_.all_joined ? kPointTimeout : kJoinTimeout);
  const bool same_goal = !controller.under_way() || ends_at_goal(controller);
  if (left || failed || late || !same_goal || part_.reached_by_all == last) {
    leave();
    return;
  }
  const int next = next_point();
  const JointVector& target = part_.plan->points[next][part_.index];
  const JointLimits& limits = controller.geometry().own_arm().limits;
  if (part_.all_joined && farthest_joint(limits, controller.setpoint().q, target) < kPointTolerance) {
    part_.progress.reached = std::max(part_.progress.reached, next);
  }
  part_.target = target;
}

int MultiArmCoordinator::next_point() const {
  const int last = static_cast<int>(part_.plan->points.size()) - 1;
  return std::min(part_.all_joined ? part_.reached_by_all + 1 : 0, last);
}

std::vector<JointVector> MultiArmCoordinator::left() const {
  std::vector<JointVector> points;
  if (!part_.target) return points;
  for (auto i = static_cast<std::size_t>(next_point()); i < part_.plan->points.size(); ++i) {
    points.push_back(part_.plan->points[i][static_cast<std::size_t>(part_.index)]);
  }
  return points;
}

bool MultiArmCoordinator::ends_at_goal(const ArmController& controller) const {
  const JointLimits& limits = controller.geometry().own_arm().limits;
  return farthest_joint(limits, *controller.goal(), part_.plan->points.back()[part_.index]) < kGoalTolerance;
}

}  // namespace hecaton::planner
