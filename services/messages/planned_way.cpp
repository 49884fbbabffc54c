#include "services/messages/planned_way.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>

#include "planner/local/goal_objective.hpp"
#include "planner/model/kinematics.hpp"
#include "services/messages/convert.hpp"

namespace hecaton::messages {
namespace {

using planner::JointVector;

constexpr double kStep = 0.08;  ///< of the joint that moves most, between two positions of the tool [rad | m]
constexpr int kMostSteps = 40;  ///< of a way

}  // namespace

std::vector<JointVector> points_of(const std::vector<double>& values, int joints) {
  std::vector<JointVector> points;
  const auto size = static_cast<std::size_t>(joints);
  for (std::size_t at = 0; at + size <= values.size(); at += size) {
    const auto q = joints_from_message(std::span(values).subspan(at, size), "PlannedMotion", joints);
    if (!q) return {};
    points.push_back(*q);
  }
  return points;
}

world::Pose tool_at(const planner::Arm& arm, const JointVector& q) {
  planner::Kinematics kinematics;
  planner::forward_kinematics(*arm.model, arm.X_WB, q, kinematics);
  return kinematics.X_WT;
}

std::vector<Eigen::Vector3d> tool_way(const planner::Arm& arm, JointVector q, const std::vector<JointVector>& points) {
  if (points.empty()) return {};
  std::vector<JointVector> moves;
  double length = 0.0;
  for (JointVector from = q; const JointVector& to : points) {
    moves.push_back(planner::joint_difference(arm.limits, from, to));
    length += moves.back().cwiseAbs().maxCoeff();
    from = to;
  }
  const double step = std::max(kStep, length / kMostSteps);
  std::vector<Eigen::Vector3d> way{tool_at(arm, q).translation()};
  for (const JointVector& move : moves) {
    const int steps = std::max(1, static_cast<int>(std::lround(move.cwiseAbs().maxCoeff() / step)));
    for (int i = 1; i <= steps; ++i) {
      way.emplace_back(tool_at(arm, q + move * (static_cast<double>(i) / steps)).translation());
    }
    q += move;
  }
  return way;
}

}  // namespace hecaton::messages
