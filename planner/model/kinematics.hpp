#pragma once
/// Forward kinematics and geometric Jacobians of a serial arm.

#include <array>

#include "planner/model/robot_model.hpp"

namespace hecaton::planner {

/// The most links (fixed ones included) of one arm.
inline constexpr int kMaxLinks = 48;

/// Poses of all links and axes of all joints of one arm in one configuration. Plain storage, reused every tick. Each
/// moving link has an axis, base to tip. Without followers axis i is that of joint i.
struct Kinematics {
  int links = 0;
  int joints = 0;
  std::array<Pose, kMaxLinks> X_WL;                  ///< link frames in W
  std::array<Eigen::Vector3d, kMaxJoints> axis_W;    ///< unit axes in W
  std::array<Eigen::Vector3d, kMaxJoints> origin_W;  ///< a point on each axis in W [m]
  std::array<bool, kMaxJoints> prismatic{};          ///< by axis
  Pose X_WT = Pose::Identity();                      ///< tool frame
  /// Per unit rate of an axis, the point at p_W moves with ω × p_W + v, where v belongs to W's origin. One component
  /// after the other, so that a row of a Jacobian is computed for several axes at once.
  std::array<std::array<double, kMaxJoints>, 3> angular_W{};  ///< ω, per axis [1]
  std::array<std::array<double, kMaxJoints>, 3> linear_W{};   ///< v, per axis [m/rad | 1]
};

/// Fills `out` for the base at X_WB and joint positions q (size model.joints()). Does not check limits, does not
/// allocate.
void forward_kinematics(const RobotModel& model, const Pose& X_WB, const JointVector& q, Kinematics& out);

/// The part of forward_kinematics that fills links, joints and X_WL: for collision geometry without Jacobians.
void place_links(const RobotModel& model, const Pose& X_WB, const JointVector& q, Kinematics& out);

/// The number of axes that move `link`: axes 0 … n − 1. It numbers the rigid bodies from the base.
[[nodiscard]] int axes_before(const RobotModel& model, int link);

/// The nearest link towards the root, or `link` itself, that has an axis; −1: none.
[[nodiscard]] int moved_link(const RobotModel& model, int link);

/// Rates of the axes for joint rates of these magnitudes [rad/s | m/s]. Axes beyond the arm's get 0.
void axis_speeds(const RobotModel& model, const JointVector& speed, std::array<double, kMaxJoints>& out);

/// J: 3 × n, the velocity in W of the point of `link` that is now at p_W, per joint rate. Columns of joints beyond the
/// link are zero.
void point_jacobian(const RobotModel& model, const Kinematics& kinematics, int link, const Eigen::Vector3d& p_W,
                    PointJacobian& J);

/// The row nᵀ J of the above without forming J: the point's velocity along n_W per joint rate.
void directional_jacobian(const RobotModel& model, const Kinematics& kinematics, int link, const Eigen::Vector3d& p_W,
                          const Eigen::Vector3d& n_W, JointVector& row);

/// J: 6 × n, rows [ω; v], of the tool frame T in W.
void tool_jacobian(const RobotModel& model, const Kinematics& kinematics, FrameJacobian& J);

}  // namespace hecaton::planner
