#include "planner/model/tool_goal.hpp"

#include <cmath>

namespace hecaton::planner {
namespace {

/// Shortest rotation vector in W that turns the unit vector `from` into `to`.
Eigen::Vector3d direction_error(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  const Eigen::Vector3d cross = from.cross(to);
  const double sine = cross.norm();
  const double angle = std::atan2(sine, from.dot(to));
  if (sine > 1e-9) return angle / sine * cross;
  return angle < 1.0 ? cross : Eigen::Vector3d(angle * from.unitOrthogonal());
}

}  // namespace

Eigen::Vector3d rotation_error(FreeRotation free_rotation, const Eigen::Matrix3d& from, const Eigen::Matrix3d& to) {
  switch (free_rotation) {
    case FreeRotation::kRoll:
      return direction_error(from.col(0), to.col(0));
    case FreeRotation::kPitch:
      return direction_error(from.col(1), to.col(1));
    case FreeRotation::kYaw:
      return direction_error(from.col(2), to.col(2));
    case FreeRotation::kAll:
      return Eigen::Vector3d::Zero();
    case FreeRotation::kNone:
      break;
  }
  const Eigen::AngleAxisd turn(Eigen::Matrix3d(to * from.transpose()));
  return turn.angle() * turn.axis();
}

ToolError tool_error(const ToolGoal& goal, const Pose& X_WT) {
  return {(goal.X_WT.translation() - X_WT.translation()).norm(),
          rotation_error(goal.free_rotation, X_WT.linear(), goal.X_WT.linear()).norm()};
}

}  // namespace hecaton::planner
