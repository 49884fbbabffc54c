#include "services/ros2_messages/cell_messages.hpp"

#include <algorithm>
#include <cstdio>
#include <utility>

#include "planner/model/outside_joints.hpp"
#include "services/messages/convert.hpp"
#include "services/messages/names.hpp"
#include "services/messages/planned_way.hpp"
#include "services/ros2_messages/cell_description.hpp"
#include "services/ros2_messages/time.hpp"
#include "services/runtime/cause.hpp"

namespace hecaton::ros2 {
namespace {

/// A driver sends its state at least every second; an older one says nothing about the arm.
constexpr std::chrono::seconds kStateLimit{1};

constexpr double kWayWidth = 0.006;   // [m]
constexpr double kPairWidth = 0.008;  // [m]
constexpr double kAxisLength = 0.12;  // [m]
constexpr double kTextAbove = 0.10;   // [m]
constexpr ColorRGBA kObstacleColor{0.55F, 0.6F, 0.7F, 0.9F};
constexpr ColorRGBA kGoalColor{0.2F, 0.8F, 0.3F, 1.0F};
constexpr ColorRGBA kBlockedColor{1.0F, 0.6F, 0.1F, 1.0F};
constexpr ColorRGBA kPlanColor{0.2F, 0.6F, 1.0F, 1.0F};
constexpr ColorRGBA kPairColor{1.0F, 0.2F, 0.2F, 1.0F};

constexpr const char* kTool = "tool";  // frame of the tool, unless a link has this name
constexpr const char* kPrefix = "hecaton: ";

std::string decimals(double value, const char* format = "%.3f") {
  std::array<char, 64> text{};
  const int size = std::snprintf(text.data(), text.size(), format, value);
  return {text.data(), static_cast<std::size_t>(size)};
}

/// The goal on which the arm is under way; null: none.
const msg::GoalStatus* active_goal(const ArmSnapshot& arm) {
  if (arm.goal == nullptr || is_final(arm.goal->state())) return nullptr;
  return arm.goal;
}

TransformStamped transform(const Time& stamp, const std::string& parent, const std::string& child,
                           const world::Pose& pose) {
  return {{stamp, parent}, child, transform_of(pose)};
}

std::uint8_t level_of(const NodeDiagnosis& node) {
  if (!node.alive) return level::kStale;
  if (node.state == msg::NodeState::NODE_FAILED) return level::kError;
  return node.state == msg::NodeState::NODE_DEGRADED ? level::kWarn : level::kOk;
}

std::uint8_t level_of(const FaultDiagnosis& fault) {
  if (fault.cleared || fault.severity == msg::Severity::SEVERITY_INFO) return level::kOk;
  return fault.severity == msg::Severity::SEVERITY_WARNING ? level::kWarn : level::kError;
}

}  // namespace

bool is_shown(const ArmSnapshot& arm, bus::Clock::time_point now) {
  return arm.kinematics != nullptr && now - arm.state->received <= kStateLimit;
}

JointState joint_state(const ArmSnapshot& arm) {
  const msg::ArmState& state = arm.state->value;
  JointState joints{{arm.stamp, ""}, arm.arm->model->joint_names, state.q(), state.qd(), {}};
  const auto& outside = arm.arm->model->outside;
  if (!outside || state.outside().size() != outside->joints.size()) return joints;
  for (std::size_t i = 0; i < outside->joints.size(); ++i) {
    joints.name.push_back(outside->joints[i].name);
    joints.position.push_back(state.outside()[i]);
    joints.velocity.push_back(0.0);
  }
  return joints;
}

JointState joint_states(const CellView& view, bus::Clock::time_point now) {
  JointState all;
  bus::Clock::time_point newest{};
  for (std::size_t i = 0; i < view.size(); ++i) {
    const ArmSnapshot arm = view.arm(i);
    if (!is_shown(arm, now)) continue;
    newest = std::max(newest, arm.state->received);
    const JointState own = joint_state(arm);
    for (const std::string& joint : own.name) all.name.push_back(prefixed(arm.arm->name, joint));
    all.position.insert(all.position.end(), own.position.begin(), own.position.end());
    all.velocity.insert(all.velocity.end(), own.velocity.begin(), own.velocity.end());
  }
  if (!all.name.empty()) all.header.stamp = view.time_at(newest);
  return all;
}

TFMessage moving_transforms(const CellView& view, bus::Clock::time_point now) {
  TFMessage moving;
  for (std::size_t i = 0; i < view.size(); ++i) {
    const ArmSnapshot arm = view.arm(i);
    if (!is_shown(arm, now)) continue;
    const auto& links = arm.arm->model->links;
    for (const LinkFrame& frame : link_frames(*arm.arm->model)) {
      if (!frame.moves) continue;
      moving.transforms.push_back(transform(
          arm.stamp, prefixed(arm.arm->name, links[frame.parent].name), prefixed(arm.arm->name, links[frame.link].name),
          arm.kinematics->X_WL[frame.parent].inverse() * arm.kinematics->X_WL[frame.link]));
    }
  }
  return moving;
}

TFMessage fixed_transforms(const planner::Cell& cell, const Time& stamp) {
  TFMessage fixed;
  for (const planner::PlannedArm& planned : cell.arms) {
    const planner::Arm& arm = planned.arm;
    const auto& links = arm.model->links;
    fixed.transforms.push_back(transform(stamp, kWorldFrame, prefixed(arm.name, links[0].name), arm.X_WB));
    planner::Kinematics at_zero;
    planner::place_links(*arm.model, arm.X_WB, planner::JointVector::Zero(arm.model->joints()), at_zero);
    for (const LinkFrame& frame : link_frames(*arm.model)) {
      if (frame.moves) continue;
      fixed.transforms.push_back(transform(stamp, prefixed(arm.name, links[frame.parent].name),
                                           prefixed(arm.name, links[frame.link].name),
                                           at_zero.X_WL[frame.parent].inverse() * at_zero.X_WL[frame.link]));
    }
    const bool named_tool =
        std::any_of(links.begin(), links.end(), [](const auto& link) { return link.name == kTool; });
    if (named_tool) continue;
    fixed.transforms.push_back(transform(stamp, prefixed(arm.name, links[arm.model->tool_link].name),
                                         prefixed(arm.name, kTool), arm.model->X_LT));
  }
  return fixed;
}

void CellMarkers::update(CellView& view, const std::vector<OrderedPath>& ordered, const Time& stamp) {
  view.place_obstacles();
  for (MarkerLayer& layer : layers_) layer.begin(stamp);
  for (const auto& [name, obstacle] : view.obstacles()) {
    layers_[kObstacles].add_body(name, obstacle.shapes, obstacle.X_WO, kObstacleColor);
  }
  for (std::size_t i = 0; i < view.size(); ++i) {
    mark_goal(view.arm(i));
    mark_binding(view, view.arm(i));
    mark_plan(view.arm(i));
  }
  mark_orders(ordered);
  for (MarkerLayer& layer : layers_) layer.end();
}

void CellMarkers::mark_goal(const ArmSnapshot& arm) {
  const msg::GoalStatus* goal = active_goal(arm);
  if (goal == nullptr || static_cast<int>(goal->q_goal().size()) != arm.arm->model->joints()) return;
  const planner::JointVector q = Eigen::Map<const Eigen::VectorXd>(goal->q_goal().data(), std::ssize(goal->q_goal()));
  if (!q.allFinite()) return;
  const world::Pose tool = messages::tool_at(*arm.arm, q);
  const bool blocked = goal->state() == msg::GoalState::GOAL_BLOCKED;
  MarkerLayer& layer = layers_[kGoals];
  layer.add_axes(arm.arm->name, tool, kAxisLength);
  layer.add_text(arm.arm->name, arm.arm->name + (blocked ? ": blocked" : ""),
                 tool.translation() + kTextAbove * Eigen::Vector3d::UnitZ(), blocked ? kBlockedColor : kGoalColor);
}

void CellMarkers::mark_binding(const CellView& view, const ArmSnapshot& arm) {
  const msg::GoalStatus* goal = active_goal(arm);
  if (goal == nullptr || !goal->has_binding()) return;
  const auto own = view.position_of(goal->binding_own());
  const auto other = view.position_of(goal->binding_other());
  if (!own || !other) return;
  MarkerLayer& layer = layers_[kPairs];
  layer.add_line(arm.arm->name, {*own, *other}, kPairWidth, kPairColor);
  layer.add_text(arm.arm->name, decimals(1e3 * goal->binding_distance(), "%.0f mm"),
                 0.5 * (*own + *other) + 0.5 * kTextAbove * Eigen::Vector3d::UnitZ(), kPairColor);
}

// Of a planner that has died the driver tells: it stops the arm.
void CellMarkers::mark_plan(const ArmSnapshot& arm) {
  if (arm.state == nullptr || arm.motion == nullptr) return;
  if (arm.state->value.mode() != msg::ArmMode::ARM_RUNNING) return;
  const int joints = arm.arm->model->joints();
  const auto q = messages::joints_from_message(arm.state->value.q(), arm.arm->name.c_str(), joints);
  if (!q) return;
  layers_[kPlans].add_line(arm.arm->name,
                           messages::tool_way(*arm.arm, *q, messages::points_of(arm.motion->way(), joints)), kWayWidth,
                           kPlanColor);
}

void CellMarkers::mark_orders(const std::vector<OrderedPath>& ordered) {
  for (const OrderedPath& path : ordered) {
    for (const planner::PlannedArm& planned : cell_.arms) {
      if (planned.arm.name != path.arm) continue;
      std::vector<Eigen::Vector3d> way;
      for (const planner::JointVector& q : path.points) {
        way.push_back(messages::tool_at(planned.arm, q).translation());
      }
      layers_[kPlans].add_line(path.arm, way, kWayWidth, kGoalColor);
    }
  }
}

DiagnosticStatus status_of(const ArmSnapshot& arm, bus::Clock::time_point now) {
  DiagnosticStatus status =
      diagnostic(level::kStale, "arm " + arm.arm->name, "no state received", arm.arm->model->name);
  if (arm.state == nullptr) return status;
  const msg::ArmState& state = arm.state->value;
  const std::string mode = text(state.mode());
  status.values.push_back({"mode", mode});
  status.values.push_back({"carried", state.carried()});
  const double age = std::chrono::duration<double>(now - arm.state->received).count();
  status.values.push_back({"state_age", decimals(age) + " s"});
  if (now - arm.state->received > kStateLimit) {
    status.message = "the last state is " + decimals(age, "%.0f s") + " old";
    return status;
  }
  const bool as_meant = state.mode() == msg::ArmMode::ARM_RUNNING || state.mode() == msg::ArmMode::ARM_OBSERVED;
  status.level = as_meant ? level::kOk : state.mode() == msg::ArmMode::ARM_FAILED ? level::kError : level::kWarn;
  status.message = state.cause().text().empty() ? mode : state.cause().text();
  if (arm.goal == nullptr) return status;
  const msg::GoalStatus& goal = *arm.goal;
  status.values.push_back({"goal", goal.goal()});
  status.values.push_back({"goal_state", text(goal.state())});
  status.values.push_back({"distance_to_goal", decimals(goal.distance_to_goal())});
  status.values.push_back({"blocked_duration", decimals(goal.blocked_duration(), "%.1f s")});
  status.values.push_back({"cause", std::string(services::cause_name(goal.cause().kind()))});
  if (goal.has_binding()) {
    status.values.push_back({"binding_pair", goal.binding_own() + " – " + goal.binding_other()});
    status.values.push_back({"binding_distance", decimals(goal.binding_distance()) + " m"});
  }
  const bool failed = goal.state() == msg::GoalState::GOAL_BLOCKED || goal.state() == msg::GoalState::GOAL_REJECTED ||
                      goal.state() == msg::GoalState::GOAL_TIMED_OUT;
  if (status.level == level::kOk && failed) {
    status.level = level::kWarn;
    status.message = goal.cause().text();
  }
  return status;
}

DiagnosticStatus diagnostic(std::uint8_t grade, const std::string& name, std::string message, std::string hardware) {
  return {grade, kPrefix + name, std::move(message), std::move(hardware), {}};
}

DiagnosticStatus diagnostic(const NodeDiagnosis& node) {
  DiagnosticStatus entry =
      diagnostic(level_of(node), node.name, node.cause.empty() ? text(node.state) : node.cause, node.host);
  entry.values = {{"state", text(node.state)}, {"heartbeat_age", decimals(std::max(0.0, node.age)) + " s"}};
  return entry;
}

DiagnosticStatus diagnostic(const FaultDiagnosis& fault) {
  DiagnosticStatus entry = diagnostic(level_of(fault), "fault " + fault.id, fault.text, fault.subject);
  entry.values = {{"kind", fault.kind}, {"cleared", fault.cleared ? "true" : "false"}};
  return entry;
}

}  // namespace hecaton::ros2
