#pragma once
/// Collision checks of straight motions of one arm in a static cell.

#include <span>
#include <vector>

#include "planner/collision/exact_distance.hpp"

namespace hecaton::planner::potential {

/// Checks motions by conservative advancement over exact distances: every configuration of a motion that is reported as
/// free is free. Not thread-safe: one per thread.
class FreeMotion {
 public:
  /// `others`: joint positions of every arm of the cell; the own entry is ignored. `margin`: distance from obstacles
  /// and other arms [m]; it does not apply between links of the own arm.
  FreeMotion(const CellGeometry& geometry, std::span<const world::ObstacleState> obstacles,
             std::span<const JointVector> others, double margin);

  /// The poses of the cell with the own arm at `q`. Valid until the next call of any function.
  [[nodiscard]] CellPoses poses(const JointVector& q);
  /// The smaller of `most` and the least distance at `q` minus the margin where it applies [m].
  [[nodiscard]] double free_distance(const JointVector& q, double most);
  [[nodiscard]] bool free(const JointVector& q) { return free_distance(q, 2.0 * kTolerance) > kTolerance; }
  /// True if the straight line from `from` to `to` is free. Precondition: both ends are within limits.
  [[nodiscard]] bool free(const JointVector& from, const JointVector& to);
  /// Bound of the motion of any point of the arm for a step of `dq` [m].
  [[nodiscard]] double sweep(const JointVector& dq) const { return lever_.dot(dq.cwiseAbs()); }

 private:
  static constexpr double kTolerance = 1e-4;  ///< least excess over the margin [m]

  Arm arm_;
  ExactDistance distance_;
  std::vector<world::ObstacleState> obstacles_;
  std::vector<Kinematics> arms_;
  Kinematics own_;
  std::vector<Clearance> nearest_;
  JointVector lever_;  ///< bound of the motion of any point per unit of each joint [m/rad | 1]
  double margin_;
};

}  // namespace hecaton::planner::potential
