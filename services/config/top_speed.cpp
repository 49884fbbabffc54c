#include "services/config/top_speed.hpp"

#include <algorithm>
#include <numbers>

#include "planner/local/random.hpp"
#include "planner/model/kinematics.hpp"

namespace hecaton::config {
namespace {

constexpr int kSamples = 300;
constexpr int kSweeps = 4;

// max ‖J q̇‖ over the box |q̇ⱼ| ≤ vⱼ lies in a corner: ascend from corner to corner along the direction reached so far.
double fastest(const Eigen::Matrix3Xd& J, const planner::JointVector& velocity, const Eigen::Vector3d& first) {
  Eigen::Vector3d direction = first;
  double speed = 0.0;
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    Eigen::Vector3d v = Eigen::Vector3d::Zero();
    for (int joint = 0; joint < velocity.size(); ++joint) {
      v += J.col(joint) * (J.col(joint).dot(direction) < 0.0 ? -velocity[joint] : velocity[joint]);
    }
    speed = v.norm();
    if (speed <= 0.0) break;
    direction = v / speed;
  }
  return speed;
}

}  // namespace

double top_tool_speed(const planner::Arm& arm) {
  const planner::RobotModel& model = *arm.model;
  planner::Random random(1);
  planner::Kinematics kinematics;
  planner::FrameJacobian J;
  planner::JointVector q(model.joints());
  double top = 0.0;
  for (int sample = 0; sample < kSamples; ++sample) {
    for (int joint = 0; joint < model.joints(); ++joint) {
      q[joint] = random.uniform(std::max(arm.limits.lower[joint], -std::numbers::pi),
                                std::min(arm.limits.upper[joint], std::numbers::pi));
    }
    planner::forward_kinematics(model, arm.X_WB, q, kinematics);
    planner::tool_jacobian(model, kinematics, J);
    const Eigen::Matrix3Xd linear = J.bottomRows<3>();
    for (int axis = 0; axis < 3; ++axis) {
      top = std::max(top, fastest(linear, arm.limits.velocity, Eigen::Vector3d::Unit(axis)));
    }
  }
  return top;
}

}  // namespace hecaton::config
