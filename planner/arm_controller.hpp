#pragma once
/// One arm's planner between ticks: its goal, its set-point, its memory. The service and the simulation both run this.

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "planner/goal_progress.hpp"
#include "planner/local/latency_compensation.hpp"
#include "planner/model/range_sensor.hpp"
#include "planner/tick.hpp"

namespace hecaton::planner {

class ArmController {
 public:
  /// `seed` makes the arm's random choices (subspaces) its own and repeatable.
  ArmController(CellGeometry geometry, LocalParameters parameters, double control_period, std::uint64_t seed);

  /// Takes over the cell's obstacles (added, removed, attached, …). Allocates. An arm with a guide hands them to it.
  void set_obstacles(std::span<const world::Obstacle> obstacles);

  /// What one of the arm's sensors has measured; only a guide listens.
  void sense(const RangeScan& scan) {
    if (guide_) guide_->sense(scan);
  }
  /// What the arm gathers beside its ticks; null for methods without.
  [[nodiscard]] const MotionGuide* guide() const { return guide_.get(); }

  void set_goal(const JointVector& q_goal);
  /// Forgets the goal: brakes, stays where it comes to rest, gives way.
  void cancel_goal();
  [[nodiscard]] bool has_goal() const { return goal_.has_value(); }

  /// The next set-point begins from the measured state: the drive has not followed the last one (held, stopped, new).
  void forget_setpoint() { setpoint_.reset(); }
  /// The drive had no successor of the last set-point for `time` [s] after that was due: it has begun to stop, and the
  /// next set-point goes on from there.
  void skip(double time);

  /// One control period. The set-point continues from the last one, unless the arm is not where it was told to be (a
  /// stop, a limit, a driver that just started): then it begins again from where the arm is. The drive is measured
  /// against the set-point that it had (docs/design/0006-latency-compensation.md, "The own arm").
  TickResult step(const OwnArmFeedback& news, std::span<const ArmObservation> arms,
                  std::span<const world::ObstacleState> obstacles, bool hold);
  /// The last period's set-point went to the drive under this number. Numbers grow.
  void sent(std::uint64_t number) { sent_.sent(number, *setpoint_); }

  /// The same for a drive that got the last period's set-point at once and was measured just now.
  TickResult step(const MeasuredState& measured, std::span<const ArmObservation> arms,
                  std::span<const world::ObstacleState> obstacles, bool hold);

  /// An arm that finds its way blocked waits up to `time` [s] for a manoeuvre before it turns aside by itself.
  void wait_for_rollout(double time) { memory_.local.rollout_wait = time; }
  /// From the next period on the arm tries this; an arm on a route only evades what comes.
  void begin(const Manoeuvre& manoeuvre);
  /// From the next period on the arm goes by these points, the last of which is its goal; empty: it finds its own way.
  void follow(std::vector<JointVector> points);
  [[nodiscard]] const Route& route() const { return route_; }
  /// From the next period on the arm goes to q_aim, and stays there, with or without a goal of its own; it makes room
  /// for nobody, and leaves its route.
  void follow_coupled_plan(const JointVector& q_aim);
  /// It finds its own way again.
  void leave_coupled_plan();

  /// Has a goal and has not been there yet; as of the last period.
  [[nodiscard]] bool under_way() const { return goal_ && memory_.local.right_of_way.under_way; }
  /// How it has come nearer to its goal, or not; periods in which it was held or knew too little do not count.
  [[nodiscard]] const ProgressMonitor& goal_progress() const { return goal_progress_; }
  /// The arm's priority in the right of way, to be published.
  [[nodiscard]] std::uint32_t priority() const { return memory_.local.right_of_way.priority; }

  [[nodiscard]] const std::optional<JointVector>& goal() const { return goal_; }
  /// Where the last period's command leads; after the first step.
  [[nodiscard]] const MeasuredState& setpoint() const { return *setpoint_; }
  [[nodiscard]] const LocalMemory& memory() const { return memory_.local; }
  [[nodiscard]] const CellGeometry& geometry() const { return geometry_; }
  [[nodiscard]] const LocalParameters& parameters() const { return parameters_; }
  [[nodiscard]] double control_period() const { return dt_; }

 private:
  /// `tracking_error`: measured minus reference position [rad | m]; empty: the drive follows none of our set-points.
  TickResult step_from(const MeasuredState& measured, const std::optional<JointVector>& tracking_error,
                       std::span<const ArmObservation> arms, std::span<const world::ObstacleState> obstacles,
                       bool hold);

  void select_target(const JointVector& q);
  [[nodiscard]] TickResult tick_by_guide(TickInput& input);
  void stay_where_guided(const TickInput& input, TickResult& result) const;

  CellGeometry geometry_;
  LocalParameters parameters_;
  double dt_;
  TickScratch scratch_;
  TickMemory memory_;
  std::optional<JointVector> goal_;
  ProgressMonitor goal_progress_;
  Route route_;
  std::optional<JointVector> aim_;  ///< of follow_coupled_plan()
  std::optional<MeasuredState> setpoint_;
  SetpointLog sent_;
  std::unique_ptr<MotionGuide> guide_;
};

}  // namespace hecaton::planner
