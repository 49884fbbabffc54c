#include "services/arm_driver/devices/universal_robots/calibration.hpp"

#include <algorithm>
#include <cmath>
#include <string_view>

#include <Eigen/Geometry>

#include "planner/model/kinematics.hpp"

namespace hecaton::device::universal_robots {
namespace {

using Eigen::Vector3d;

/// The axis of a joint.
struct AxisLine {
  Vector3d point, direction;
};
using AxisLines = std::array<AxisLine, 6>;
using Posture = std::array<double, 6>;

/// Stretched, upright, and bent in different ways: each length and each angle moves the flange in some of them. The
/// first one is the zero position.
constexpr std::array<Posture, 6> kPostures{{{},
                                            {0.0, -1.57, 0.0, -1.57, 0.0, 0.0},
                                            {0.6, -1.57, 1.57, -1.57, -1.57, 0.0},
                                            {-1.2, -0.8, -1.6, 0.9, 1.3, 0.0},
                                            {2.0, -2.2, -0.4, 2.4, -0.7, 0.0},
                                            {-2.5, -0.3, 0.5, -2.0, 2.4, 0.0}}};

AxisLines axes_of(const DhParameters& robot, const Posture& q) {
  AxisLines axes;
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  for (std::size_t joint = 0; joint < axes.size(); ++joint) {
    axes[joint] = {X.translation(), X.linear().col(2)};
    X.rotate(Eigen::AngleAxisd(robot.theta[joint] + q[joint], Vector3d::UnitZ()));
    X.translate(Vector3d(robot.a[joint], 0.0, robot.d[joint]));
    X.rotate(Eigen::AngleAxisd(robot.alpha[joint], Vector3d::UnitX()));
  }
  return axes;
}

AxisLines axes_of(const planner::RobotModel& model, const Posture& q, planner::Kinematics& kinematics) {
  planner::JointVector positions(6);
  std::copy(q.begin(), q.end(), positions.data());
  planner::forward_kinematics(model, planner::Pose::Identity(), positions, kinematics);
  AxisLines axes;
  for (std::size_t joint = 0; joint < axes.size(); ++joint) {
    axes[joint] = {kinematics.origin_W[joint], kinematics.axis_W[joint]};
  }
  return axes;
}

/// The point of `line` that is nearest to `other`.
Vector3d foot(const AxisLine& line, const AxisLine& other) {
  const Vector3d between = other.point - line.point;
  const double cosine = line.direction.dot(other.direction);
  const double sine_squared = 1.0 - cosine * cosine;
  double along = line.direction.dot(between);
  constexpr double kParallel = 1e-6;
  if (sine_squared > kParallel) along = (along - cosine * other.direction.dot(between)) / sine_squared;
  return line.point + along * line.direction;
}

/// The frame at the shoulder of a robot whose axes are these in the zero position: z is the first axis, and x is as
/// near to the second one as it can be.
Eigen::Isometry3d shoulder(const AxisLines& axes) {
  const Vector3d z = axes[0].direction;
  Vector3d x = axes[1].direction - z * z.dot(axes[1].direction);
  constexpr double kParallel = 1e-3;
  x = x.norm() > kParallel ? x.normalized() : z.unitOrthogonal();
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.linear().col(0) = x;
  X.linear().col(1) = z.cross(x);
  X.linear().col(2) = z;
  X.translation() = foot(axes[0], axes[1]);
  return X;
}

Vector3d flange(const Eigen::Isometry3d& X_S, const AxisLines& axes, double from_wrist) {
  return X_S.inverse(Eigen::Isometry) * (foot(axes[5], axes[4]) + from_wrist * axes[5].direction);
}

/// The origin of the link whose name ends so, if `moved_by` axes move it and it is on `axis`.
std::optional<Vector3d> frame_on_axis(const planner::RobotModel& model, const planner::Kinematics& kinematics,
                                      std::string_view name, int moved_by, const AxisLine& axis) {
  constexpr double kOnAxis = 0.002;  // a calibration moves a frame from the axis by less [m]
  for (std::size_t link = 0; link < model.links.size(); ++link) {
    if (!model.links[link].name.ends_with(name)) continue;
    if (planner::axes_before(model, static_cast<int>(link)) != moved_by) continue;
    const Vector3d origin = kinematics.X_WL[link].translation();
    if ((origin - axis.point).cross(axis.direction).norm() <= kOnAxis) return origin;
  }
  return std::nullopt;
}

}  // namespace

std::optional<double> flange_difference(const DhParameters& robot, const planner::RobotModel& model) {
  if (model.joints() != 6 || model.has_followers) return std::nullopt;
  planner::Kinematics kinematics;
  const Eigen::Isometry3d X_robot = shoulder(axes_of(robot, kPostures[0]));
  const Eigen::Isometry3d X_model = shoulder(axes_of(model, kPostures[0], kinematics));
  if (std::any_of(kinematics.prismatic.begin(), kinematics.prismatic.begin() + 6, [](bool slides) { return slides; })) {
    return std::nullopt;
  }
  double largest = 0.0;
  for (const Posture& q : kPostures) {
    const Vector3d of_robot = flange(X_robot, axes_of(robot, q), robot.d[5]);
    const Vector3d of_model = flange(X_model, axes_of(model, q, kinematics), robot.d[5]);
    largest = std::max(largest, (of_robot - of_model).norm());
  }
  return largest;
}

std::optional<double> length_difference(const DhParameters& robot, const planner::RobotModel& model, double most) {
  planner::Kinematics kinematics;
  const AxisLines axes = axes_of(model, kPostures[0], kinematics);
  std::optional<double> largest;
  const auto compare = [&](std::string_view name, int moved_by, const AxisLine& axis, const Vector3d& from,
                           double length) {
    const auto frame = frame_on_axis(model, kinematics, name, moved_by, axis);
    if (!frame) return;
    const double difference = std::abs(std::abs(axis.direction.dot(*frame - from)) - std::abs(length));
    if (difference <= most) largest = std::max(largest.value_or(0.0), difference);
  };
  compare("base_link", 0, axes[0], foot(axes[0], axes[1]), robot.d[0]);
  compare("tool0", 6, axes[5], foot(axes[5], axes[4]), robot.d[5]);
  return largest;
}

}  // namespace hecaton::device::universal_robots
