#include "services/arm_driver/devices/ros2_control/commands.hpp"

#include <algorithm>

#include "planner/trajectory/stop_profile.hpp"
#include "services/ros2_messages/time.hpp"

namespace hecaton::device::ros2_control {
namespace {

/// Points of a trajectory must be this far apart at least [s].
constexpr double kShortest = 1e-3;

std::vector<double> values(const JointVector& vector) {
  return {vector.begin(), vector.end()};
}

ros2::JointTrajectoryPoint point(const JointState& state, double at) {
  ros2::JointTrajectoryPoint result;
  result.positions = values(state.q);
  result.velocities = values(state.qd);
  result.time_from_start = ros2::ros_duration(at);
  return result;
}

}  // namespace

ros2::Float64MultiArray values_of(const JointVector& joints) {
  ros2::Float64MultiArray message;
  message.data = values(joints);
  return message;
}

ros2::JointTrajectory stopping_trajectory(const std::vector<std::string>& joints, const JointState& set_point,
                                          double lookahead, const JointLimits& limits) {
  ros2::JointTrajectory message;
  message.joint_names = joints;
  message.points.push_back(point(set_point, lookahead));
  // The cubic polynomial between the points is the stop profile: q + q̇ (t − t²/2T).
  if (const double stop = planner::stop_time(limits, set_point.qd); stop > 0.0) {
    JointState rest = set_point;
    rest.q = planner::rest_position(limits, set_point.q, set_point.qd).cwiseMax(limits.lower).cwiseMin(limits.upper);
    rest.qd.setZero();
    message.points.push_back(point(rest, lookahead + std::max(stop, kShortest)));
  }
  return message;
}

}  // namespace hecaton::device::ros2_control
