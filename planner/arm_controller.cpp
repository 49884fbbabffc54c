#include "planner/arm_controller.hpp"

#include <algorithm>
#include <limits>
#include <utility>
#include <variant>

#include "planner/local/goal_objective.hpp"
#include "planner/local/joint_distance.hpp"
#include "planner/trajectory/stop_profile.hpp"

namespace hecaton::planner {
namespace {

/// Beyond this tracking error the drive does not follow its set-points [rad | m].
constexpr double kLostTrack = 0.05;
/// An arm that waits this long on a trajectory goes around what blocks it [s]. Within a path tolerance there may be no
/// way: then it waits twice as long before each further try, up to kLongestRest.
constexpr double kLongestWait = 2.0;
constexpr double kLongestRest = 32.0;
/// It goes to a point this much later [s] and this far away [rad | m], or to the end. After kAroundTimeout without
/// arrival it tries twice the time. Within a path tolerance the straight way to the point must be near the trajectory:
/// it is kLeastInTolerance times the tolerance away.
constexpr double kFirstAhead = 1.0;
constexpr double kLeastAround = 0.3;
constexpr double kLeastInTolerance = 4.0;
constexpr double kAroundTimeout = 8.0;
/// It follows the trajectory again when each joint is within this of that point [rad | m], and within this share of the
/// path tolerance.
constexpr double kRejoins = 0.05;
constexpr double kRejoinsShare = 0.4;

bool is_lost(const JointVector& tracking_error) {
  return tracking_error.cwiseAbs().maxCoeff() > kLostTrack;
}

double smallest_tolerance(const TimedTrajectory& trajectory) {
  return trajectory.has_path_tolerance() ? trajectory.path_tolerance.minCoeff()
                                         : std::numeric_limits<double>::infinity();
}

}  // namespace

ArmController::ArmController(CellGeometry geometry, LocalParameters parameters, double control_period,
                             std::uint64_t seed)
    : geometry_(std::move(geometry)),
      parameters_(parameters),
      state_age_limit_(parameters.state_age_limit),
      dt_(control_period),
      scratch_(geometry_, parameters_),
      memory_{LocalMemory(seed)},
      sent_(geometry_.own_arm().limits, control_period),
      guide_(parameters_.method->make_guide(geometry_.own_arm(), control_period)),
      ramp_(geometry_.own_arm().limits) {}

void ArmController::set_obstacles(std::span<const world::Obstacle> obstacles) {
  obstacle_moves_.clear();
  for (const world::Obstacle& obstacle : obstacles) {
    obstacle_moves_.push_back(!std::holds_alternative<world::StaticMotion>(obstacle.motion));
  }
  if (guide_) return guide_->set_obstacles(obstacles);
  geometry_.set_obstacles(obstacles);
  scratch_.rebuild(geometry_);
}

void ArmController::set_goal(const JointVector& q_goal, std::shared_ptr<const TimedTrajectory> trajectory,
                             double time) {
  goal_ = q_goal;
  memory_.local.tracking = {};
  aside_ = {};
  if (trajectory) {
    memory_.local.tracking = {std::move(trajectory), TrackingPhase::kFollows, time, 0.0, false, {}};
    memory_.local.detour = {};
  }
  follow({});
  goal_progress_.restart();
  // The same goal counts as new if the arm has reached it before and then gave way.
  if (!under_way()) memory_.local.q_goal = {};
}

void ArmController::cancel_goal() {
  goal_.reset();
  memory_.local.tracking = {};
  follow({});
}

void ArmController::begin(const Manoeuvre& manoeuvre) {
  if (aim_ || ((route_.under_way() || follows_trajectory()) && manoeuvre.kind != ManoeuvreKind::kEvade)) return;
  planner::begin(manoeuvre, memory_.local);
}

void ArmController::follow(std::vector<JointVector> points) {
  // Progress is measured along the route, which may lead away from the goal at first.
  if (!route_.under_way() && points.size() > 1) goal_progress_.restart();
  route_.take(std::move(points));
  if (!route_.under_way() && memory_.local.detour.of_route) memory_.local.detour = {};
}

void ArmController::follow_coupled_plan(const JointVector& q_aim) {
  follow({});
  aim_ = q_aim;
}

void ArmController::leave_coupled_plan() {
  if (!aim_) return;
  aim_.reset();
  memory_.local.detour = {};
}

/// After a pause the arm is not where the trajectory was left.
void ArmController::resume_trajectory(bool follows, const TickInput& input) {
  TrajectoryTracking& tracking = memory_.local.tracking;
  if (!follows_trajectory() || input.hold || (follows && tracking.begun && !pauses_)) return;
  resume_tracking(geometry_.own_arm().limits, input.q, input.qd, tracking);
}

void ArmController::go_around() {
  TrajectoryTracking& tracking = memory_.local.tracking;
  const JointLimits& limits = geometry_.own_arm().limits;
  const double duration = tracking.trajectory->duration();
  const double least = std::min(kLeastAround, kLeastInTolerance * smallest_tolerance(*tracking.trajectory));
  do {
    aside_.ahead = std::max(kFirstAhead, 2.0 * aside_.ahead);
    aside_.rejoin = std::min(duration, tracking.time + aside_.ahead);
    goal_ = tracking.at(aside_.rejoin).q;
  } while (aside_.rejoin < duration && farthest_joint(limits, setpoint_->q, *goal_) < least);
  aside_.elapsed = 0.0;
  tracking.phase = tracking.trajectory->has_path_tolerance() ? TrackingPhase::kAround : TrackingPhase::kAside;
  tracking.rate = 0.0;
  follow({});
  goal_progress_.restart();
}

void ArmController::return_to_trajectory(double time) {
  TrajectoryTracking& tracking = memory_.local.tracking;
  tracking.phase = TrackingPhase::kFollows;
  tracking.time = time;
  tracking.rate = 0.0;
  goal_ = tracking.trajectory->end();
  aside_ = {};
  follow({});
  goal_progress_.restart();
  memory_.local.detour = {};
}

/// No way within the path tolerance was found. The arm waits where it is.
void ArmController::give_up_for_now() {
  const double rest = std::min(kLongestRest, std::max(kLongestWait, 2.0 * aside_.rest));
  return_to_trajectory(memory_.local.tracking.time);
  aside_.rejoin = memory_.local.tracking.time + kFirstAhead;
  aside_.rest = rest;
  memory_.local.without_progress = 0.0;
}

/// After a period in which the arm was free to plan: leaves a blocked trajectory, and joins it again. A planner whose
/// set-points the drive does not follow, such as a standby, never leaves it.
void ArmController::follow_trajectory(bool follows, const TickResult& result) {
  TrajectoryTracking& tracking = memory_.local.tracking;
  if (!follows) {
    if (tracking.phase == TrackingPhase::kAside || tracking.phase == TrackingPhase::kAround)
      return_to_trajectory(tracking.time);
    memory_.local.without_progress = 0.0;
    return;
  }
  if (tracking.follows()) {
    const double longest = std::max(kLongestWait, aside_.rest);
    if (memory_.local.without_progress > longest && result.yields_to < 0) go_around();
    if (tracking.time > aside_.rejoin) aside_.rest = 0.0;
    return;
  }
  const bool bound = tracking.phase == TrackingPhase::kAround;
  if (tracking.phase != TrackingPhase::kAside && !bound) return;
  const JointLimits& limits = geometry_.own_arm().limits;
  aside_.elapsed += progress_period();
  const double near = std::min(kRejoins, kRejoinsShare * smallest_tolerance(*tracking.trajectory));
  if (farthest_joint(limits, result.q, *goal_) < near) {
    return_to_trajectory(bound ? tracking.time : aside_.rejoin);
  } else if (aside_.elapsed > kAroundTimeout && aside_.rejoin < tracking.trajectory->duration()) {
    go_around();
  } else if (aside_.elapsed > kAroundTimeout && bound) {
    give_up_for_now();
  }
}

/// The point of a coupled plan comes first, then an evasion, then the next point of the route, then the goal.
void ArmController::select_target(const JointVector& q) {
  Detour& detour = memory_.local.detour;
  if (aim_) {
    detour = {true, *aim_, std::numeric_limits<double>::infinity(), true, false};
    memory_.local.deviation.active = false;
    return;
  }
  route_.pass(geometry_.own_arm().limits, q);
  if (!route_.under_way()) {
    if (detour.of_route) detour = {};
    return;
  }
  if (detour.active && detour.stays) return;
  detour = {true, route_.next(), std::numeric_limits<double>::infinity(), false, true};
  memory_.local.deviation.active = false;
}

void ArmController::describe(MemoryArchive& archive) {
  if (guide_) return archive.fail();
  memory_.local.describe(archive, *parameters_.method);
  archive.optional(goal_);
  archive(goal_progress_, route_);
  archive.optional(aim_);
  archive.optional(setpoint_);
  archive(sent_, ramp_, ordered_speed_, speed_, aside_, pauses_);
}

/// The arm is where the set-point says `delay` [s] later. By then all states are so much older, except that of an
/// obstacle which stays where it is put. What is too old is too old by the true age.
void ArmController::age_states(double delay, TickInput& input) {
  const double limit = state_age_limit_;
  parameters_.state_age_limit = limit + delay;
  arms_then_.assign(input.arms.begin(), input.arms.end());
  for (ArmObservation& arm : arms_then_) {
    if (!arm.lost()) arm.age += delay;
  }
  obstacles_then_.assign(input.obstacles.begin(), input.obstacles.end());
  for (std::size_t i = 0; i < obstacles_then_.size(); ++i) {
    const bool stays = i < obstacle_moves_.size() && !obstacle_moves_[i];
    if (!stays || obstacles_then_[i].age > limit) obstacles_then_[i].age += delay;
  }
  input.arms = arms_then_;
  input.obstacles = obstacles_then_;
}

void ArmController::skip(double time) {
  if (setpoint_) stop_for(geometry_.own_arm().limits, time, setpoint_->q, setpoint_->qd);
}

TickResult ArmController::step(const OwnArmFeedback& feedback, std::span<const ArmObservation> arms,
                               std::span<const world::ObstacleState> obstacles, bool hold) {
  if (!feedback.follows) forget_setpoint();
  parameters_.state_age_limit = state_age_limit_;
  std::optional<JointVector> tracking_error;
  const auto reference = sent_.reference(feedback.setpoint, feedback.setpoint_age - feedback.tracking_delay);
  if (reference) tracking_error = feedback.state.q - reference->q;
  TickInput input;
  input.arms = arms;
  input.obstacles = obstacles;
  input.hold = hold;
  input.speed_scaling = feedback.speed_scaling;
  if (feedback.tracking_delay > 0.0) age_states(feedback.tracking_delay, input);
  // An arm that is not where its set-points say may not be as old as it seems either. It begins where it was measured:
  // a set-point ahead of the arm would move it faster, and the next one would be further ahead.
  const bool lost = setpoint_ && tracking_error && is_lost(*tracking_error);
  const MeasuredState begin = lost ? feedback.state : dead_reckoned(geometry_.own_arm().limits, feedback, dt_);
  return step_from(begin, tracking_error, std::move(input));
}

TickResult ArmController::step(const MeasuredState& measured, std::span<const ArmObservation> arms,
                               std::span<const world::ObstacleState> obstacles, bool hold) {
  std::optional<JointVector> tracking_error;
  if (setpoint_) tracking_error = measured.q - setpoint_->q;
  TickInput input;
  input.arms = arms;
  input.obstacles = obstacles;
  input.hold = hold;
  return step_from(measured, tracking_error, std::move(input));
}

TickResult ArmController::step_from(const MeasuredState& measured, const std::optional<JointVector>& tracking_error,
                                    TickInput input) {
  const bool follows = setpoint_ && tracking_error && !is_lost(*tracking_error);
  if (!follows) setpoint_ = measured;

  input.dt = dt_;
  input.q = setpoint_->q;
  input.qd = setpoint_->qd;
  if (follows) input.tracking_error = *tracking_error;
  ramp_.advance(ordered_speed_, input.qd, dt_);
  speed_ = input.speed_scaling = std::min(input.speed_scaling, ramp_.share());
  input.has_goal = goal_.has_value();
  if (goal_) input.q_goal = *goal_;
  if ((input.has_goal || aim_) && !input.hold) select_target(input.q);
  resume_trajectory(follows, input);
  const bool tracked = follows_trajectory();
  TickResult result = guide_ ? tick_by_guide(input) : tick(geometry_, parameters_, input, memory_, scratch_);
  if (aim_ && (result.status == TickStatus::kDetouring || result.status == TickStatus::kIdle)) {
    result.status = TickStatus::kFollowingPlan;
  } else if (result.status == TickStatus::kDetouring && memory_.local.detour.of_route) {
    result.status = TickStatus::kFollowingRoute;
  }
  setpoint_ = MeasuredState{result.q, result.qd};
  const bool free_to_plan = result.status != TickStatus::kHolding && result.status != TickStatus::kStaleInput;
  pauses_ = !free_to_plan;
  if (tracked && free_to_plan) {
    goal_progress_.note_motion(memory_.local.without_progress == 0.0, progress_period());
  } else if (goal_ && free_to_plan) {
    const JointLimits& limits = geometry_.own_arm().limits;
    goal_progress_.note(
        route_.under_way() ? route_.length(limits, result.q) : joint_difference(limits, result.q, *goal_).norm(),
        progress_period());
  }
  if (goal_ && free_to_plan && memory_.local.tracking.trajectory) follow_trajectory(follows, result);
  return result;
}

/// The local planner moves to the guide's aim and gives way to other arms. The arm brakes where that motion would leave
/// the space that the guide allows.
TickResult ArmController::tick_by_guide(TickInput& input) {
  input.obstacles = {};
  GuidedPath path = GuidedPath::kStraight;
  bool at_last = true;
  if (input.has_goal && !input.hold) {
    const MotionGuide::Aim aim = guide_->guide(input.q, input.qd, input.q_goal);
    path = aim.path;
    at_last = aim.q == input.q_goal;
    input.q_goal = aim.q;
  }
  TickResult result = tick(geometry_, parameters_, input, memory_, scratch_);
  if (!input.hold) stay_where_guided(input, result);
  const bool goes = result.status == TickStatus::kMoving || result.status == TickStatus::kReached;
  if (goes && path == GuidedPath::kNone) result.status = TickStatus::kBlocked;
  if (goes && (path == GuidedPath::kSearching || (path == GuidedPath::kAround && !at_last)))
    result.status = TickStatus::kFollowingBoundary;
  if (goes && path == GuidedPath::kStraight && !at_last) result.status = TickStatus::kMoving;
  return result;
}

/// Velocities between the wanted one and braking satisfy the rows and limits, too, because both sets are convex. Their
/// stop paths are checked anew.
void ArmController::stay_where_guided(const TickInput& input, TickResult& result) {
  if (guide_->may_go(input.q, result.q, result.qd)) return;
  const JointVector wanted = result.qd;
  const JointVector braking = braking_velocity(geometry_.own_arm().limits, input.qd, input.dt);
  for (const double share : {0.5, 0.25, 0.0}) {
    result.qd = braking + share * (wanted - braking);
    result.q = input.q + 0.5 * (input.qd + result.qd) * input.dt;
    if (share > 0.0 && !stop_path_is_clear(result.qd, scratch_)) continue;
    if (guide_->may_go(input.q, result.q, result.qd)) return;
  }
}

}  // namespace hecaton::planner
