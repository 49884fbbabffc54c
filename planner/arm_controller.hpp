#pragma once
/// The reactive planner of one arm between ticks: its goal, its last set-point and its memory.

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "planner/goal_progress.hpp"
#include "planner/local/latency_compensation.hpp"
#include "planner/local/speed_ramp.hpp"
#include "planner/model/range_sensor.hpp"
#include "planner/tick.hpp"

namespace hecaton::planner {

/// Calls tick() once a period and selects its target: goal, route point or coupled plan. The planner service and the
/// simulation run the same code. Not thread-safe.
class ArmController {
 public:
  /// `control_period` [s]. `seed`: of the arm's random choices (subspaces), so that they are repeatable.
  ArmController(CellGeometry geometry, LocalParameters parameters, double control_period, std::uint64_t seed);

  /// Replaces the cell's obstacles. Allocates. An arm with a guide passes them to the guide.
  void set_obstacles(std::span<const world::Obstacle> obstacles);

  /// Passes a scan of one of the arm's sensors to the guide; ignored without one.
  void sense(const RangeScan& scan) {
    if (guide_) guide_->sense(scan);
  }
  /// The guide of the arm's method; null for methods without one.
  [[nodiscard]] const MotionGuide* guide() const { return guide_.get(); }

  /// With a `trajectory` to it, the arm follows that from `time` on [s]: it waits, and goes around what blocks it for
  /// long, within the path tolerance if the trajectory has one.
  void set_goal(const JointVector& q_goal, std::shared_ptr<const TimedTrajectory> trajectory = {}, double time = 0.0);
  /// Removes the goal: the arm brakes, stays where it comes to rest, and gives way.
  void cancel_goal();
  [[nodiscard]] bool has_goal() const { return goal_.has_value(); }

  /// Starts the next set-point from the measured state. Call when the drive has not followed the last one.
  void forget_setpoint() { setpoint_.reset(); }
  /// Accounts for skipped periods: the drive had no set-point for `time` [s] and has begun to stop. The next set-point
  /// continues from that stop.
  void skip(double time);

  /// The ordered share of the velocity limits, above 0 to 1, from the next step() on. The limits follow it on a
  /// SpeedRamp. The lower of the order and OwnArmFeedback::speed_scaling is in force.
  void order_speed(double share) { ordered_speed_ = share; }
  /// The share of the velocity limits in force, as of the last step().
  [[nodiscard]] double speed() const { return speed_; }
  /// The period in which judgements of progress count [s]: a slow arm gets longer. For an arm that moves the control
  /// period times speed(), for one that stands the control period.
  [[nodiscard]] double progress_period() const {
    return memory_.local.without_progress > 0.0 ? dt_ : dt_ * std::max(speed_, kSlowestShare);
  }

  /// Plans one control period. The set-point continues from the last one. If the measured position deviates from its
  /// reference by more than 0.05 rad or m, the set-point starts again from the measured state. The reference is the
  /// set-point that the drive had at that time, less the drive's tracking delay. All states count as older by that
  /// delay (docs/explanation/0006-latency-compensation.md, "Arms that lag"). Allocates only in a guide, or when the
  /// delay begins.
  TickResult step(const OwnArmFeedback& feedback, std::span<const ArmObservation> arms,
                  std::span<const world::ObstacleState> obstacles, bool hold);
  /// Records that the last period's set-point was sent under this number. Numbers grow.
  void sent(std::uint64_t number) { sent_.sent(number, *setpoint_); }

  /// The same without delays: the drive got the last set-point at once, and `measured` is the present state.
  TickResult step(const MeasuredState& measured, std::span<const ArmObservation> arms,
                  std::span<const world::ObstacleState> obstacles, bool hold);

  /// Lets a blocked arm wait up to `time` [s] for a rollout before its method deviates.
  void wait_for_rollout(double time) { memory_.local.rollout_wait = time; }
  /// Begins the manoeuvre in the next period. An arm on a route accepts only ManoeuvreKind::kEvade.
  void begin(const Manoeuvre& manoeuvre);
  /// Follows these points from the next period on; the last one is the goal. Empty: leaves the route.
  void follow(std::vector<JointVector> points);
  [[nodiscard]] const Route& route() const { return route_; }
  /// From the next period on the arm moves to `q_aim` and stays there, with or without a goal. It leaves its route and
  /// yields to no arm.
  void follow_coupled_plan(const JointVector& q_aim);
  /// Ends follow_coupled_plan().
  void leave_coupled_plan();

  /// The arm follows a trajectory: its goal has one, whose time is not over, and the arm does not go around something.
  [[nodiscard]] bool follows_trajectory() const { return goal_ && memory_.local.tracking.follows(); }
  /// The arm follows a trajectory, or stays near it. It then takes no route and no coupled plan.
  [[nodiscard]] bool tracks() const { return goal_ && (follows_trajectory() || memory_.local.tracking.is_bound()); }
  /// The arm has a goal and has not reached it yet, as of the last period.
  [[nodiscard]] bool under_way() const { return goal_ && memory_.local.right_of_way.under_way; }
  /// Progress towards the goal. Periods with status kHolding or kStaleInput do not count.
  [[nodiscard]] const ProgressMonitor& goal_progress() const { return goal_progress_; }
  /// The arm's number in the right of way, to be published.
  [[nodiscard]] std::uint32_t priority() const { return memory_.local.right_of_way.priority; }

  /// While the arm goes around something on its trajectory, the later point to which it goes.
  [[nodiscard]] const std::optional<JointVector>& goal() const { return goal_; }
  /// The last set-point. Precondition: step() was called.
  [[nodiscard]] const MeasuredState& setpoint() const { return *setpoint_; }
  [[nodiscard]] bool has_setpoint() const { return setpoint_.has_value(); }
  [[nodiscard]] const LocalMemory& memory() const { return memory_.local; }
  [[nodiscard]] const CellGeometry& geometry() const { return geometry_; }
  [[nodiscard]] const LocalParameters& parameters() const { return parameters_; }
  [[nodiscard]] double control_period() const { return dt_; }

  /// The memory without the obstacles. That of a guide cannot be saved: then the archive fails.
  void describe(MemoryArchive& archive);

 private:
  /// `tracking_error`: measured minus reference position [rad | m]; empty: the drive follows none of the set-points.
  /// `input`: with arms, obstacles, hold and speed scaling.
  TickResult step_from(const MeasuredState& measured, const std::optional<JointVector>& tracking_error,
                       TickInput input);

  void age_states(double delay, TickInput& input);
  void resume_trajectory(bool follows, const TickInput& input);
  void follow_trajectory(bool follows, const TickResult& result);
  void go_around();
  void return_to_trajectory(double time);
  void give_up_for_now();
  void select_target(const JointVector& q);
  [[nodiscard]] TickResult tick_by_guide(TickInput& input);
  void stay_where_guided(const TickInput& input, TickResult& result);

  CellGeometry geometry_;
  LocalParameters parameters_;
  double state_age_limit_;  ///< of the parameters [s]
  double dt_;
  TickScratch scratch_;
  TickMemory memory_;
  std::optional<JointVector> goal_;
  ProgressMonitor goal_progress_;
  Route route_;
  std::optional<JointVector> aim_;  ///< of follow_coupled_plan()
  std::optional<MeasuredState> setpoint_;
  SetpointLog sent_;
  std::vector<bool> obstacle_moves_;  ///< not only where it is put
  // While the arm lags behind its set-points: the states, as old as they are when it has caught up with the next one.
  std::vector<ArmObservation> arms_then_;
  std::vector<world::ObstacleState> obstacles_then_;
  std::unique_ptr<MotionGuide> guide_;
  SpeedRamp ramp_;
  double ordered_speed_ = 1.0;
  double speed_ = 1.0;
  /// An arm that goes around something on its trajectory.
  struct Aside {
    double rejoin = 0.0;   ///< time of the trajectory to which it goes [s]
    double ahead = 0.0;    ///< of that time before the time at which it has left [s]
    double elapsed = 0.0;  ///< [s]
    double rest = 0.0;     ///< how long it waits before it tries again within the tolerance [s]; 0: the first try

    void describe(MemoryArchive& archive) { archive(rejoin, ahead, elapsed, rest); }
  };
  Aside aside_;
  bool pauses_ = false;  ///< the last period did not follow the trajectory: hold, or old inputs
};

}  // namespace hecaton::planner
