#pragma once
/// Joint-space vectors of fixed capacity (no allocation) and the limits of an arm's joints.

#include <Eigen/Core>

namespace hecaton::planner {

/// The most actuated joints of one arm. Fixed capacity keeps every joint vector on the stack.
inline constexpr int kMaxJoints = 16;

/// One value per actuated joint, base to tip: [rad] for revolute and continuous joints, [m] for prismatic ones.
using JointVector = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kMaxJoints, 1>;

/// 3 × n, in W: the velocity of a point per joint rate [m/rad | 1].
using PointJacobian = Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::ColMajor, 3, kMaxJoints>;

/// 6 × n, rows [ω; v], in W: the velocity of a frame per joint rate.
using FrameJacobian = Eigen::Matrix<double, 6, Eigen::Dynamic, Eigen::ColMajor, 6, kMaxJoints>;

/// Joint values outside a limit by at most this are rounding errors of texts and of single precision [rad | m].
inline constexpr double kLimitRounding = 1e-6;

/// Limits of the actuated joints, all of the arm's size. A continuous joint has ±infinity as its positions.
struct JointLimits {
  JointVector lower;         ///< [rad | m]
  JointVector upper;         ///< [rad | m], > lower
  JointVector velocity;      ///< [rad/s | m/s], > 0, either direction
  JointVector acceleration;  ///< [rad/s² | m/s²], > 0, for acceleration and deceleration
};

/// Accelerations for an arm that has none in its description: every joint reaches its velocity limit in this time [s].
inline constexpr double kAssumedRunUp = 0.25;
/// The acceleration of each joint by that rule [rad/s² | m/s²].
[[nodiscard]] inline JointVector assumed_acceleration(const JointVector& velocity) {
  return velocity / kAssumedRunUp;
}

}  // namespace hecaton::planner
