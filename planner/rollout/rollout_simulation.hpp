#pragma once
/// A cell, or the part of one that matters to an arm, played forward by one planner to see what comes of a manoeuvre:
/// every arm ticks, every drive follows, every obstacle goes on as it moves now.

#include <memory>
#include <span>
#include <vector>

#include "planner/tick.hpp"

namespace hecaton::planner {

/// What obstacles do is foreseen for so long: later they have turned, or others have come [s].
inline constexpr double kLookaheadTime = 1.5;
/// How an obstacle accelerates now says less and less about the next second, and nothing about later [s].
inline constexpr double kAccelerationHorizon = 1.0;

/// One arm when the play begins.
struct RolloutArm {
  JointVector q;                     ///< [rad | m]
  JointVector qd;                    ///< [rad/s | m/s]
  JointVector q_goal;                ///< [rad | m]; ignored without goal
  bool has_goal = false;             ///< without: it gives way
  bool plans = false;                ///< false: it stands still, whatever comes
  JointVector position_uncertainty;  ///< of an arm that was lost (ArmObservation)
  LocalMemory memory;                ///< what its planner remembers, as far as that is known
};

class RolloutSimulation {
 public:
  /// `parameters`: one per arm. `dt`: of the play, coarser than the control period [s].
  RolloutSimulation(const std::vector<Arm>& arms, std::vector<LocalParameters> parameters, double dt);

  void set_obstacles(std::span<const world::Obstacle> obstacles);

  /// Begins anew, in steps of `dt`. `obstacles`: one per obstacle; `accelerations`: theirs when the play begins [m/s²],
  /// or none.
  void begin(std::span<const RolloutArm> arms, std::span<const world::ObstacleState> obstacles,
             std::span<const Eigen::Vector3d> accelerations, double dt);
  void begin(std::span<const RolloutArm> arms, std::span<const world::ObstacleState> obstacles) {
    begin(arms, obstacles, {}, dt_);
  }
  /// dt forward: all arms tick on the same instant.
  void step();

  [[nodiscard]] double time() const { return time_; }  ///< since the beginning [s]
  [[nodiscard]] double dt() const { return dt_; }
  [[nodiscard]] const RolloutArm& arm(int i) const { return arms_[i]; }
  [[nodiscard]] RolloutArm& arm(int i) { return arms_[i]; }
  [[nodiscard]] const JointLimits& limits(int i) const { return geometries_[i].own_arm().limits; }
  [[nodiscard]] int arms() const { return static_cast<int>(geometries_.size()); }
  /// When arm i first stood at its goal [s]; below 0: not yet.
  [[nodiscard]] double reached(int i) const { return reached_[i]; }
  /// The least room (TickResult) that arm i has had in the first `kLookaheadTime` seconds [m].
  [[nodiscard]] double clearance_margin(int i) const { return clearance_margin_[i]; }
  [[nodiscard]] double clearance_margin_of_moving(int i) const { return clearance_margin_of_moving_[i]; }

 private:
  /// As its planner tells the others: whoever has arrived needs no room any more.
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
  std::vector<Eigen::Vector3d> accelerations_;  ///< of obstacles when the play began [m/s²]
};

}  // namespace hecaton::planner
