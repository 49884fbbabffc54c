#pragma once
/// Forward kinematics and geometric Jacobians of a serial arm.

#include <array>

#include "planner/model/robot_model.hpp"

namespace hecaton::planner {

/// The most links (fixed ones included) of one arm.
inline constexpr int kMaxLinks = 48;

/// Poses of all links and axes of all joints of one arm in one configuration. Plain storage, reused every tick.
struct Kinematics {
  int links = 0;
  int joints = 0;
  std::array<Pose, kMaxLinks> X_WL;                  ///< link frames in W
  std::array<Eigen::Vector3d, kMaxJoints> axis_W;    ///< unit joint axes in W
  std::array<Eigen::Vector3d, kMaxJoints> origin_W;  ///< a point on each joint axis in W [m]
  std::array<bool, kMaxJoints> prismatic{};
  Pose X_WT = Pose::Identity();  ///< tool frame
  /// What joint j's rate does to the point that is at p_W: it moves with ω × p_W + v, v that of W's origin. A component
  /// after the other, so that a Jacobian's row is computed for several joints at once.
  std::array<std::array<double, kMaxJoints>, 3> angular_W{};  ///< ω, per joint [1]
  std::array<std::array<double, kMaxJoints>, 3> linear_W{};   ///< v, per joint [m/rad | 1]
};

/// Fills `out` for the base at X_WB and joints q (size model.joints()). Does not check limits; does not allocate.
void forward_kinematics(const RobotModel& model, const Pose& X_WB, const JointVector& q, Kinematics& out);

/// For each link the number of leading joints that move it: joints 0 … n−1 are its ancestors. −> column count that is
/// not zero in point_jacobian.
[[nodiscard]] int joints_before(const RobotModel& model, int link);

/// J: 3 × n. Velocity in W of the point of `link` that is now at p_W, per joint rate. Columns of joints beyond the link
/// are zero.
void point_jacobian(const RobotModel& model, const Kinematics& kinematics, int link, const Eigen::Vector3d& p_W,
                    PointJacobian& J);

/// n^T J of the above without forming J: how fast the point moves along n_W per joint rate. Size n.
void directional_jacobian(const RobotModel& model, const Kinematics& kinematics, int link, const Eigen::Vector3d& p_W,
                          const Eigen::Vector3d& n_W, JointVector& row);

/// J: 6 × n, rows [ω; v], of the tool frame T in W.
void tool_jacobian(const RobotModel& model, const Kinematics& kinematics, FrameJacobian& J);

}  // namespace hecaton::planner
