#include "services/view/motion_json.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include "planner/local/goal_objective.hpp"
#include "planner/model/kinematics.hpp"
#include "services/messages/convert.hpp"

namespace hecaton::services::view {
namespace {

using planner::JointVector;

constexpr double kStep = 0.08;  ///< of the joint that moves most, between two points of a line [rad | m]
constexpr int kMostSteps = 40;  ///< of a line

/// Empty: a point is not usable.
std::vector<JointVector> points_of(const std::vector<double>& values, int joints) {
  std::vector<JointVector> points;
  const auto size = static_cast<std::size_t>(joints);
  for (std::size_t at = 0; at + size <= values.size(); at += size) {
    const auto q = messages::joints_from_message(std::span(values).subspan(at, size), "PlannedMotion", joints);
    if (!q) return {};
    points.push_back(*q);
  }
  return points;
}

Json tool_at(const planner::Arm& arm, const JointVector& q) {
  planner::Kinematics kinematics;
  planner::forward_kinematics(*arm.model, arm.X_WB, q, kinematics);
  const Eigen::Vector3d p = kinematics.X_WT.translation();
  return {rounded(p.x(), 1e4), rounded(p.y(), 1e4), rounded(p.z(), 1e4)};
}

/// The tool on the straight lines between `points`, from `q` on.
Json line(const planner::Arm& arm, JointVector q, const std::vector<JointVector>& points) {
  Json line = Json::array();
  if (points.empty()) return line;
  std::vector<JointVector> moves;
  double length = 0.0;
  for (JointVector from = q; const JointVector& to : points) {
    moves.push_back(planner::joint_difference(arm.limits, from, to));
    length += moves.back().cwiseAbs().maxCoeff();
    from = to;
  }
  const double step = std::max(kStep, length / kMostSteps);
  line.push_back(tool_at(arm, q));
  for (const JointVector& move : moves) {
    const int steps = std::max(1, static_cast<int>(std::lround(move.cwiseAbs().maxCoeff() / step)));
    for (int i = 1; i <= steps; ++i) line.push_back(tool_at(arm, q + move * (static_cast<double>(i) / steps)));
    q += move;
  }
  return line;
}

/// Without what is over at that age.
std::vector<JointVector> left_of(std::vector<JointVector> points, double age, double period) {
  const double over = period > 0.0 ? std::clamp(age / period, 0.0, static_cast<double>(points.size())) : 0.0;
  points.erase(points.begin(), points.begin() + static_cast<std::ptrdiff_t>(over));
  return points;
}

}  // namespace

Json motions_json(const CellFeed& feed) {
  const CellState& cell = feed.state();
  Json arms = Json::array();
  for (const planner::PlannedArm& planned : cell.file().cell.arms) {
    const planner::Arm& arm = planned.arm;
    Json json{{"way", Json::array()}, {"foreseen", Json::array()}};
    const auto* state = cell.state(arm.name);
    const auto* motion = cell.motion(arm.name);
    const auto* heartbeat = motion == nullptr ? nullptr : cell.heartbeat(motion->value.node());
    if (state != nullptr && heartbeat != nullptr && cell.alive(*heartbeat, feed.now())) {
      const int joints = arm.model->joints();
      if (const auto q = messages::joints_from_message(state->value.q(), arm.name.c_str(), joints)) {
        const double age = std::chrono::duration<double>(motion->age(feed.now())).count();
        json["way"] = line(arm, *q, points_of(motion->value.way(), joints));
        json["foreseen"] =
            line(arm, *q, left_of(points_of(motion->value.foreseen(), joints), age, motion->value.foreseen_period()));
      }
    }
    arms.push_back(std::move(json));
  }
  return {{"type", "motions"}, {"arms", std::move(arms)}};
}

}  // namespace hecaton::services::view
