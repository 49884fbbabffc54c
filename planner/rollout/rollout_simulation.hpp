#pragma once
/// Rollouts: short simulations of an arm and its neighbours that predict the effect of a manoeuvre.

#include <memory>
#include <span>
#include <vector>

#include "planner/tick.hpp"

namespace hecaton::planner {

/// Obstacle motion is predicted for this long [s]; later predictions are unreliable.
inline constexpr double kLookaheadTime = 1.5;
/// The weight of an obstacle's present acceleration falls linearly to zero within this time [s].
inline constexpr double kAccelerationHorizon = 1.0;

/// Initial state of one arm.
struct RolloutArm {
  JointVector q;                     ///< [rad | m]
  JointVector qd;                    ///< [rad/s | m/s]
  JointVector q_goal;                ///< [rad | m]; ignored without goal
  bool has_goal = false;             ///< false: it only gives way
  bool plans = false;                ///< false: it stands still, or others move it
  bool foreign = false;              ///< others move it: it keeps its velocity within its limits, and gives way to none
  JointVector position_uncertainty;  ///< of a lost arm (ArmObservation)
  double speed = 1.0;                ///< share of its velocity limits that it uses, 0 to 1
  LocalMemory memory;                ///< memory of its planner, as far as known
};

/// Every arm that plans runs its own tick, every drive follows exactly, and obstacles move at their present velocity,
/// which changes by their acceleration. Deterministic. Not thread-safe.
class RolloutSimulation {
 public:
  /// `parameters`: one per arm. `dt`: time step, larger than the control period [s].
  RolloutSimulation(const std::vector<Arm>& arms, std::vector<LocalParameters> parameters, double dt);

  void set_obstacles(std::span<const world::Obstacle> obstacles);

  /// Starts a rollout with time step `dt` [s]. `obstacles`: one per obstacle. `accelerations`: one per obstacle [m/s²],
  /// or none.
  void begin(std::span<const RolloutArm> arms, std::span<const world::ObstacleState> obstacles,
             std::span<const Eigen::Vector3d> accelerations, double dt);
  void begin(std::span<const RolloutArm> arms, std::span<const world::ObstacleState> obstacles) {
    begin(arms, obstacles, {}, dt_);
  }
  /// Advances by dt. All arms tick on the same instant.
  void step();

  [[nodiscard]] double time() const { return time_; }  ///< since begin() [s]

  [[nodiscard]] const RolloutArm& arm(int i) const { return arms_[i]; }
  [[nodiscard]] RolloutArm& arm(int i) { return arms_[i]; }
  [[nodiscard]] const JointLimits& limits(int i) const { return geometries_[i].own_arm().limits; }
  [[nodiscard]] int arms() const { return static_cast<int>(geometries_.size()); }
  /// Time at which arm i reached its goal [s]; negative: not yet.
  [[nodiscard]] double reached(int i) const { return reached_[i]; }
  /// Least TickResult::clearance_margin of arm i in the first `kLookaheadTime` seconds [m].
  [[nodiscard]] double clearance_margin(int i) const { return clearance_margin_[i]; }
  [[nodiscard]] double clearance_margin_of_moving(int i) const { return clearance_margin_of_moving_[i]; }

 private:
  /// As the planner of arm i publishes it: other arms do not yield to an arm at its goal.
  [[nodiscard]] bool is_under_way(int i) const { return arms_[i].has_goal && reached_[i] < 0.0; }

  std::vector<CellGeometry> geometries_;  ///< one per arm as the own arm
  std::vector<LocalParameters> parameters_;
  std::vector<TickScratch> scratch_;
  double dt_;
  double time_ = 0.0;
  std::vector<RolloutArm> arms_;
  std::vector<double> reached_;
  std::vector<double> clearance_margin_;
  std::vector<double> clearance_margin_of_moving_;
  std::vector<ArmObservation> seen_;
  std::vector<world::ObstacleState> obstacles_;
  std::vector<Eigen::Vector3d> accelerations_;  ///< of obstacles at begin() [m/s²]
};

}  // namespace hecaton::planner
