#pragma once
/// Whether an arm can go from one configuration straight to another while everything else stands still.

#include <span>
#include <vector>

#include "planner/collision/exact_distance.hpp"

namespace hecaton::planner::potential {

/// By conservative advancement over exact distances: no motion that it calls free has a configuration in between that
/// is not. One per thread.
class FreeMotion {
 public:
  /// `others`: joint positions of every arm of the cell; the own one's are ignored. `margin` [m]: kept from obstacles
  /// and other arms; links of the own arm only must not touch.
  FreeMotion(const CellGeometry& geometry, std::span<const world::ObstacleState> obstacles,
             std::span<const JointVector> others, double margin);

  /// Where everything is with the own arm at `q`. Valid until the next call of anything.
  [[nodiscard]] CellPoses poses(const JointVector& q);
  /// Least distance of what must not touch at `q`, less the margin where that is kept, or `most` if larger [m].
  [[nodiscard]] double room(const JointVector& q, double most);
  [[nodiscard]] bool free(const JointVector& q) { return room(q, 2.0 * kTolerance) > kTolerance; }
  /// The straight line from `from` to `to`; both within limits, continuous joints as given.
  [[nodiscard]] bool free(const JointVector& from, const JointVector& to);
  /// No point of the arm moves farther than this for a step of `dq` [m].
  [[nodiscard]] double sweep(const JointVector& dq) const { return lever_.dot(dq.cwiseAbs()); }

 private:
  static constexpr double kTolerance = 1e-4;  ///< nearer to the margin than this is not free [m]

  Arm arm_;
  ExactDistance distance_;
  std::vector<world::ObstacleState> obstacles_;
  std::vector<Kinematics> arms_;
  Kinematics own_;
  std::vector<Clearance> nearest_;
  JointVector lever_;  ///< no point of the arm moves farther for a unit of each joint [m/rad | 1]
  double margin_;
};

}  // namespace hecaton::planner::potential
