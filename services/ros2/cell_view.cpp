#include "services/ros2/cell_view.hpp"

#include <utility>

#include "services/client/connection.hpp"
#include "services/messages/convert.hpp"

namespace hecaton::ros2 {

CellView::CellView(const config::CellFile& file, bus::Participant& participant, bus::Mailbox& mailbox)
    : states_(participant, &mailbox),
      goals_(participant, &mailbox),
      shapes_(participant, &mailbox),
      obstacle_states_(participant, &mailbox),
      plans_(participant, &mailbox) {
  for (const planner::PlannedArm& planned : file.cell.arms) {
    index_.emplace(planned.arm.name, arms_.size());
    arms_.emplace_back().arm = &planned.arm;
  }
}

void CellView::update() {
  take_states();
  take_goals();
  take_obstacles();
}

void CellView::take_states() {
  for (auto& sample : states_.take()) {
    const auto found = index_.find(sample.value.arm());
    if (sample.disposed || found == index_.end()) continue;
    Known& known = arms_[found->second];
    const auto q = messages::joints_from_message(sample.value.q(), "ArmState", known.arm->model->joints());
    known.placed = static_cast<bool>(q);
    if (q) planner::forward_kinematics(*known.arm->model, known.arm->X_WB, *q, known.kinematics);
    known.state = std::move(sample);
  }
}

void CellView::take_goals() {
  for (auto& sample : goals_.take()) {
    const auto found = index_.find(sample.value.arm());
    if (sample.disposed || found == index_.end()) continue;
    auto& goal = arms_[found->second].goal;
    if (sample.value.state() == msg::GoalState::GOAL_REPLACED) continue;
    if (!goal || client::is_later(sample.value, *goal)) goal = std::move(sample.value);
  }
}

void CellView::take_obstacles() {
  for (const auto& sample : shapes_.take()) {
    if (sample.disposed) {
      known_shapes_.erase(sample.key);
      continue;
    }
    const auto obstacle = messages::from_message(sample.value.obstacle());
    if (obstacle) known_shapes_[sample.value.name()] = obstacle->shapes;
  }
  auto arrived = obstacle_states_.take();
  if (!arrived.empty()) newest_ = std::move(arrived.back().value);
}

void CellView::place_obstacles() {
  obstacles_.clear();
  for (const msg::ObstacleState& state : newest_.states()) {
    const auto shapes = known_shapes_.find(state.name());
    const auto pose = messages::from_message(state.X_WO(), state.name());
    if (shapes != known_shapes_.end() && pose) obstacles_[state.name()] = {shapes->second, *pose};
  }
}

ArmSnapshot CellView::arm(std::size_t index) const {
  const Known& known = arms_[index];
  return {known.arm, known.state ? &*known.state : nullptr, known.goal ? &*known.goal : nullptr,
          known.placed ? &known.kinematics : nullptr};
}

std::vector<msg::CoupledPlan> CellView::coupled_plans() {
  std::vector<msg::CoupledPlan> plans;
  for (const auto& [arm, sample] : plans_.latest()) {
    if (!sample.value.arms().empty()) plans.push_back(sample.value);
  }
  return plans;
}

std::optional<Eigen::Vector3d> CellView::position_of(const std::string& body) const {
  if (const auto obstacle = obstacles_.find(body); obstacle != obstacles_.end()) {
    return obstacle->second.X_WO.translation();
  }
  const auto slash = body.find('/');
  const auto found = index_.find(std::string_view(body).substr(0, slash));
  if (slash == std::string::npos || found == index_.end() || !arms_[found->second].placed) return std::nullopt;
  const Known& known = arms_[found->second];
  const auto& links = known.arm->model->links;
  for (std::size_t i = 0; i < links.size(); ++i) {
    if (body.compare(slash + 1, std::string::npos, links[i].name) == 0) return known.kinematics.X_WL[i].translation();
  }
  return std::nullopt;
}

world::Pose CellView::tool_at(const planner::Arm& arm, const planner::JointVector& q) {
  planner::Kinematics kinematics;
  planner::forward_kinematics(*arm.model, arm.X_WB, q, kinematics);
  return kinematics.X_WT;
}

}  // namespace hecaton::ros2
