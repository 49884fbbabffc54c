#include "services/ros2/cell_publisher.hpp"

#include <algorithm>
#include <array>
#include <cstdio>

#include "services/client/convert.hpp"
#include "services/messages/names.hpp"
#include "services/ros2/cell_description.hpp"
#include "services/runtime/cause.hpp"

namespace hecaton::ros2 {
namespace {

// Levels of diagnostic_msgs/msg/DiagnosticStatus.
constexpr std::uint8_t kOk = 0;
constexpr std::uint8_t kWarn = 1;
constexpr std::uint8_t kError = 2;
constexpr std::uint8_t kStale = 3;

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
constexpr const char* kObstacles = "obstacles";
constexpr const char* kGoals = "goals";
constexpr const char* kPlans = "plans";
constexpr const char* kPairs = "binding_pairs";

std::string decimals(double value, const char* format = "%.3f") {
  std::array<char, 64> text{};
  const int size = std::snprintf(text.data(), text.size(), format, value);
  return {text.data(), static_cast<std::size_t>(size)};
}

bool all_simulated(const config::CellFile& file) {
  return std::all_of(file.devices.begin(), file.devices.end(),
                     [](const config::DeviceOptions& device) { return device.type == "simulated"; });
}

/// The goal on which the arm is under way; null: none.
const msg::GoalStatus* active_goal(const ArmSnapshot& arm) {
  if (arm.goal == nullptr || is_final(static_cast<GoalState>(arm.goal->state()))) return nullptr;
  return arm.goal;
}

TransformStamped transform(const Time& stamp, const std::string& parent, const std::string& child,
                           const world::Pose& pose) {
  return {{stamp, parent}, child, transform_of(pose)};
}

DiagnosticStatus diagnostic(std::uint8_t level, std::string name, std::string message, std::string hardware) {
  return {level, std::move(name), std::move(message), std::move(hardware), {}};
}

std::uint8_t level_of(const NodeStatus& node) {
  if (!node.alive) return kStale;
  if (node.state == NodeState::kFailed) return kError;
  return node.state == NodeState::kDegraded ? kWarn : kOk;
}

std::uint8_t level_of(const Fault& fault) {
  if (fault.cleared || fault.severity == Severity::kInfo) return kOk;
  return fault.severity == Severity::kWarning ? kWarn : kError;
}

}  // namespace

CellPublisher::ArmTopics::ArmTopics(const planner::Arm& of, bus::Participant& participant, const std::string& ns)
    : arm(&of),
      frames(link_frames(*of.model)),
      description(participant, ns + "/" + of.name + "/robot_description", type::kString, Delivery::kLatched),
      states(participant, ns + "/" + of.name + "/joint_states", type::kJointState),
      status(participant, ns + "/" + of.name + "/status", type::kDiagnosticStatus) {
  for (const std::string& joint : of.model->joint_names) joints.push_back(prefixed(of.name, joint));
}

CellPublisher::CellPublisher(const config::CellFile& file, bus::Participant& participant)
    : file_(file),
      simulated_(all_simulated(file)),
      description_(participant, file.ros2->ns + "/robot_description", type::kString, Delivery::kLatched),
      joint_states_(participant, file.ros2->ns + "/joint_states", type::kJointState),
      transforms_(participant, "/tf", type::kTransforms, Delivery::kTransforms),
      fixed_transforms_(participant, "/tf_static", type::kTransforms, Delivery::kLatched),
      clock_(participant, "/clock", type::kClock, Delivery::kClock),
      diagnostics_(participant, "/diagnostics", type::kDiagnostics) {
  for (const char* name : {kObstacles, kGoals, kPlans, kPairs}) {
    markers_.try_emplace(name, participant, file.ros2->ns + "/hecaton/" + name);
  }
  for (const planner::PlannedArm& planned : file.cell.arms) {
    arms_.push_back(std::make_unique<ArmTopics>(planned.arm, participant, file.ros2->ns));
  }
}

void CellPublisher::publish_descriptions() {
  const Time stamp = ros_time(std::chrono::system_clock::now());
  description_.publish({cell_urdf(file_.cell)});
  TFMessage fixed;
  for (const auto& topics : arms_) {
    const planner::Arm& arm = *topics->arm;
    topics->description.publish({arm_urdf(arm)});
    const auto& links = arm.model->links;
    fixed.transforms.push_back(transform(stamp, kWorldFrame, prefixed(arm.name, links[0].name), arm.X_WB));
    planner::Kinematics at_zero;
    planner::place_links(*arm.model, arm.X_WB, planner::JointVector::Zero(arm.model->joints()), at_zero);
    for (const LinkFrame& frame : topics->frames) {
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
  fixed_transforms_.publish(fixed);
}

void CellPublisher::publish_states(const CellView& view, Clock::time_point now) {
  if (simulated_) clock_.publish({ros_time(now)});
  JointState all;
  Clock::time_point newest{};
  TFMessage moving;
  for (std::size_t i = 0; i < view.size(); ++i) {
    const ArmSnapshot arm = view.arm(i);
    if (arm.kinematics == nullptr || now - arm.state->received > kStateLimit) continue;
    ArmTopics& topics = *arms_[i];
    const auto& q = arm.state->value.q();
    const auto& qd = arm.state->value.qd();
    newest = std::max(newest, arm.state->received);
    const Time stamp = ros_time(arm.state->received);
    all.name.insert(all.name.end(), topics.joints.begin(), topics.joints.end());
    all.position.insert(all.position.end(), q.begin(), q.end());
    all.velocity.insert(all.velocity.end(), qd.begin(), qd.end());
    if (topics.states.wanted()) topics.states.publish({{stamp, ""}, arm.arm->model->joint_names, q, qd, {}});
    if (!transforms_.wanted()) continue;
    const auto& links = arm.arm->model->links;
    for (const LinkFrame& frame : topics.frames) {
      if (!frame.moves) continue;
      moving.transforms.push_back(transform(
          stamp, prefixed(arm.arm->name, links[frame.parent].name), prefixed(arm.arm->name, links[frame.link].name),
          arm.kinematics->X_WL[frame.parent].inverse() * arm.kinematics->X_WL[frame.link]));
    }
  }
  if (all.name.empty()) return;
  all.header.stamp = ros_time(newest);
  if (joint_states_.wanted()) joint_states_.publish(all);
  if (!moving.transforms.empty()) transforms_.publish(moving);
}

void CellPublisher::publish_arm_status(const CellView& view, Clock::time_point now) {
  for (std::size_t i = 0; i < view.size(); ++i) {
    if (arms_[i]->status.wanted()) arms_[i]->status.publish(status_of(view.arm(i), now));
  }
}

void CellPublisher::publish_markers(CellView& view, const std::vector<OrderedPath>& ordered) {
  const Time stamp = ros_time(std::chrono::system_clock::now());
  view.place_obstacles();
  for (auto& [name, topic] : markers_) topic.layer.begin(stamp);
  for (const auto& [name, obstacle] : view.obstacles()) {
    markers_.at(kObstacles).layer.add_body(name, obstacle.shapes, obstacle.X_WO, kObstacleColor);
  }
  for (std::size_t i = 0; i < view.size(); ++i) {
    mark_goal(view.arm(i));
    mark_binding(view, view.arm(i));
  }
  mark_plans(view, ordered);
  for (auto& [name, topic] : markers_) {
    const MarkerArray& message = topic.layer.end();
    if (topic.publisher.wanted()) topic.publisher.publish(message);
  }
}

void CellPublisher::mark_goal(const ArmSnapshot& arm) {
  const msg::GoalStatus* goal = active_goal(arm);
  if (goal == nullptr || static_cast<int>(goal->q_goal().size()) != arm.arm->model->joints()) return;
  const planner::JointVector q = Eigen::Map<const Eigen::VectorXd>(goal->q_goal().data(), std::ssize(goal->q_goal()));
  if (!q.allFinite()) return;
  const world::Pose tool = CellView::tool_at(*arm.arm, q);
  const bool blocked = goal->state() == msg::GoalState::GOAL_BLOCKED;
  MarkerLayer& layer = markers_.at(kGoals).layer;
  layer.add_axes(arm.arm->name, tool, kAxisLength);
  layer.add_text(arm.arm->name, arm.arm->name + (blocked ? ": blocked" : ""),
                 tool.translation() + kTextAbove * Eigen::Vector3d::UnitZ(), blocked ? kBlockedColor : kGoalColor);
}

void CellPublisher::mark_binding(const CellView& view, const ArmSnapshot& arm) {
  const msg::GoalStatus* goal = active_goal(arm);
  if (goal == nullptr || !goal->has_binding()) return;
  const auto own = view.position_of(goal->binding_own());
  const auto other = view.position_of(goal->binding_other());
  if (!own || !other) return;
  MarkerLayer& layer = markers_.at(kPairs).layer;
  layer.add_line(arm.arm->name, {*own, *other}, kPairWidth, kPairColor);
  layer.add_text(arm.arm->name, decimals(1e3 * goal->binding_distance(), "%.0f mm"),
                 0.5 * (*own + *other) + 0.5 * kTextAbove * Eigen::Vector3d::UnitZ(), kPairColor);
}

void CellPublisher::mark_plans(CellView& view, const std::vector<OrderedPath>& ordered) {
  MarkerLayer& layer = markers_.at(kPlans).layer;
  const auto arm_named = [&](const std::string& name) -> const planner::Arm* {
    for (const planner::PlannedArm& planned : file_.cell.arms) {
      if (planned.arm.name == name) return &planned.arm;
    }
    return nullptr;
  };
  for (const OrderedPath& path : ordered) {
    const planner::Arm* arm = arm_named(path.arm);
    std::vector<Eigen::Vector3d> way;
    for (const planner::JointVector& q : path.points) way.push_back(CellView::tool_at(*arm, q).translation());
    layer.add_line(path.arm, way, kWayWidth, kGoalColor);
  }
  for (const msg::CoupledPlan& plan : view.coupled_plans()) {
    std::size_t joints = 0;
    std::vector<const planner::Arm*> arms;
    for (const std::string& name : plan.arms()) {
      arms.push_back(arm_named(name));
      if (arms.back() == nullptr) return;
      joints += static_cast<std::size_t>(arms.back()->model->joints());
    }
    if (plan.q().size() != joints * plan.points()) continue;
    std::vector<std::vector<Eigen::Vector3d>> ways(arms.size());
    const double* next = plan.q().data();
    for (std::uint32_t point = 0; point < plan.points(); ++point) {
      for (std::size_t i = 0; i < arms.size(); ++i) {
        const int n = arms[i]->model->joints();
        const planner::JointVector q = Eigen::Map<const Eigen::VectorXd>(next, n);
        ways[i].push_back(CellView::tool_at(*arms[i], q).translation());
        next += n;
      }
    }
    for (std::size_t i = 0; i < arms.size(); ++i) layer.add_line(arms[i]->name, ways[i], kWayWidth, kPlanColor);
  }
}

void CellPublisher::publish_diagnostics(const CellStatus* status, const std::string& problem,
                                        const std::optional<SceneReport>& scenes) {
  DiagnosticArray message;
  message.header.stamp = ros_time(std::chrono::system_clock::now());
  const std::string prefix = "hecaton: ";
  if (status == nullptr) {
    message.status.push_back(diagnostic(kStale, prefix + "cell", problem, file_.cell.name));
  } else {
    const bool run = status->mode == CellMode::kRun;
    message.status.push_back(
        diagnostic(run ? kOk : kWarn, prefix + "cell", run ? "running" : status->cause.text, status->cell));
    for (const NodeStatus& node : status->nodes) {
      const std::string text = node.cause ? node.cause.text : std::string(name_of(node.state));
      DiagnosticStatus& entry =
          message.status.emplace_back(diagnostic(level_of(node), prefix + node.name, text, node.host));
      entry.values = {{"state", std::string(name_of(node.state))},
                      {"heartbeat_age", decimals(std::max(0.0, node.age.count())) + " s"}};
    }
    for (const Fault& fault : status->faults) {
      DiagnosticStatus& entry = message.status.emplace_back(
          diagnostic(level_of(fault), prefix + "fault " + fault.id, fault.cause.text, fault.cause.subject));
      entry.values = {{"kind", std::string(name_of(fault.cause.kind))}, {"cleared", fault.cleared ? "true" : "false"}};
    }
  }
  if (scenes) {
    const bool whole = scenes->refusal.empty();
    DiagnosticStatus& entry = message.status.emplace_back(diagnostic(
        whole ? kOk : kWarn, prefix + "planning scene", whole ? "applied" : scenes->refusal, file_.cell.name));
    entry.values = {{"applied", std::to_string(scenes->applied)}, {"refused", std::to_string(scenes->refused)}};
  }
  diagnostics_.publish(message);
}

std::vector<bus::EndpointId> CellPublisher::writers() const {
  std::vector<bus::EndpointId> ids{description_.id(),      joint_states_.id(), transforms_.id(),
                                   fixed_transforms_.id(), clock_.id(),        diagnostics_.id()};
  for (const auto& [name, topic] : markers_) ids.push_back(topic.publisher.id());
  for (const auto& topics : arms_) {
    ids.insert(ids.end(), {topics->description.id(), topics->states.id(), topics->status.id()});
  }
  return ids;
}

DiagnosticStatus status_of(const ArmSnapshot& arm, bus::Clock::time_point now) {
  DiagnosticStatus status =
      diagnostic(kStale, "hecaton: arm " + arm.arm->name, "no state received", arm.arm->model->name);
  if (arm.state == nullptr) return status;
  const msg::ArmState& state = arm.state->value;
  const auto mode = static_cast<ArmMode>(state.mode());
  status.values.push_back({"mode", std::string(name_of(mode))});
  status.values.push_back({"carried", state.carried()});
  const double age = std::chrono::duration<double>(now - arm.state->received).count();
  status.values.push_back({"state_age", decimals(age) + " s"});
  if (now - arm.state->received > kStateLimit) {
    status.message = "the last state is " + decimals(age, "%.0f s") + " old";
    return status;
  }
  status.level = mode == ArmMode::kRunning ? kOk : mode == ArmMode::kFailed ? kError : kWarn;
  status.message = state.cause().text().empty() ? std::string(name_of(mode)) : state.cause().text();
  if (arm.goal == nullptr) return status;
  const Progress goal = client::to_public(*arm.goal);
  status.values.push_back({"goal", goal.goal});
  status.values.push_back({"goal_state", std::string(name_of(goal.state))});
  status.values.push_back({"distance_to_goal", decimals(goal.distance)});
  status.values.push_back({"blocked_duration", decimals(goal.blocked_duration.count(), "%.1f s")});
  status.values.push_back({"cause", std::string(name_of(goal.cause.kind))});
  if (goal.binding) {
    status.values.push_back({"binding_pair", goal.binding->own + " – " + goal.binding->other});
    status.values.push_back({"binding_distance", decimals(goal.binding->distance) + " m"});
  }
  if (status.level == kOk && goal.state == GoalState::kBlocked) {
    status.level = kWarn;
    status.message = goal.cause.text;
  }
  return status;
}

}  // namespace hecaton::ros2
