#pragma once
/// Rigid transforms and velocities. `X_AB` maps points of frame B into frame A: p_A = X_AB * p_B.
/// W is the cell's world frame (z up, metres).

#include <cmath>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace hecaton::world {

/// A rigid transform.
using Pose = Eigen::Isometry3d;

/// Velocity of a rigid body: of its frame's origin, expressed in W.
struct Twist {
  Eigen::Vector3d linear = Eigen::Vector3d::Zero();   ///< [m/s]
  Eigen::Vector3d angular = Eigen::Vector3d::Zero();  ///< [rad/s]

  /// Velocity [m/s] of the body's point that is now at p_W, for a body whose origin is at origin_W.
  [[nodiscard]] Eigen::Vector3d at(const Eigen::Vector3d& p_W, const Eigen::Vector3d& origin_W) const {
    return linear + angular.cross(p_W - origin_W);
  }
};

/// Pose from a translation [m] and roll, pitch, yaw [rad] about fixed x, y, z (the URDF convention).
inline Pose pose_from_xyz_rpy(const Eigen::Vector3d& xyz, const Eigen::Vector3d& rpy) {
  Pose pose = Pose::Identity();
  pose.translation() = xyz;
  pose.linear() =
      (Eigen::AngleAxisd(rpy.z(), Eigen::Vector3d::UnitZ()) * Eigen::AngleAxisd(rpy.y(), Eigen::Vector3d::UnitY()) *
       Eigen::AngleAxisd(rpy.x(), Eigen::Vector3d::UnitX()))
          .toRotationMatrix();
  return pose;
}

/// Roll, pitch, yaw [rad] of a rotation: the inverse of pose_from_xyz_rpy. Pitch is within ±π/2; at ±π/2, where roll
/// and yaw have one axis, roll is 0.
inline Eigen::Vector3d rpy_of(const Eigen::Matrix3d& R) {
  // R = Rz(yaw) · Ry(pitch) · Rx(roll): its last row is (−sin pitch, cos pitch sin roll, cos pitch cos roll).
  const double cosine = std::hypot(R(2, 1), R(2, 2));
  const double pitch = std::atan2(-R(2, 0), cosine);
  if (cosine > 1e-9) return {std::atan2(R(2, 1), R(2, 2)), pitch, std::atan2(R(1, 0), R(0, 0))};
  return {0.0, pitch, std::atan2(-R(0, 1), R(1, 1))};
}

/// The pose of a body that moves with `twist` for `seconds` from `pose` (rotation about its own origin).
inline Pose extrapolate(const Pose& pose, const Twist& twist, double seconds) {
  Pose next = pose;
  next.translation() += twist.linear * seconds;
  const Eigen::Vector3d rotation = twist.angular * seconds;
  const double angle = rotation.norm();
  if (angle > 1e-12) {
    next.linear() = Eigen::AngleAxisd(angle, rotation / angle).toRotationMatrix() * pose.linear();
  }
  return next;
}

/// The constant velocity that leads from one pose to another in `seconds` > 0, by the shorter rotation: the inverse of
/// extrapolate().
inline Twist twist_between(const Pose& from, const Pose& to, double seconds) {
  const Eigen::AngleAxisd turn(Eigen::Matrix3d(to.linear() * from.linear().transpose()));
  return {(to.translation() - from.translation()) / seconds, turn.axis() * (turn.angle() / seconds)};
}

}  // namespace hecaton::world
