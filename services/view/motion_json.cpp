#include "services/view/motion_json.hpp"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <vector>

#include "services/messages/convert.hpp"
#include "services/messages/planned_way.hpp"

namespace hecaton::services::view {
namespace {

using planner::JointVector;

Json line(const planner::Arm& arm, const JointVector& q, const std::vector<JointVector>& points) {
  Json line = Json::array();
  for (const Eigen::Vector3d& p : messages::tool_way(arm, q, points)) {
    line.push_back({rounded(p.x(), 1e4), rounded(p.y(), 1e4), rounded(p.z(), 1e4)});
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
        json["way"] = line(arm, *q, messages::points_of(motion->value.way(), joints));
        json["foreseen"] =
            line(arm, *q,
                 left_of(messages::points_of(motion->value.foreseen(), joints), age, motion->value.foreseen_period()));
      }
    }
    arms.push_back(std::move(json));
  }
  return {{"type", "motions"}, {"arms", std::move(arms)}};
}

}  // namespace hecaton::services::view
