#include "services/messages/names.hpp"

#include <array>
#include <cstdio>

namespace hecaton::msg {

// No switch has a default, so that the compiler reports new values without a word.
std::string text(Mode mode) {
  switch (mode) {
    case Mode::MODE_RUN:
      return "run";
    case Mode::MODE_HOLD:
      return "hold";
    case Mode::MODE_STOP:
      return "stop";
  }
  return "unknown";
}

std::string text(ArmMode mode) {
  switch (mode) {
    case ArmMode::ARM_STARTING:
      return "starting";
    case ArmMode::ARM_RUNNING:
      return "running";
    case ArmMode::ARM_BRAKING:
      return "braking";
    case ArmMode::ARM_STOPPED:
      return "stopped";
    case ArmMode::ARM_FAILED:
      return "failed";
    case ArmMode::ARM_OBSERVED:
      return "observed";
  }
  return "unknown";
}

std::string text(DeviceOrder order) {
  switch (order) {
    case DeviceOrder::DEVICE_POWER_ON:
      return "on";
    case DeviceOrder::DEVICE_POWER_OFF:
      return "off";
    case DeviceOrder::DEVICE_UNLOCK:
      return "unlock";
    case DeviceOrder::DEVICE_OBSERVE:
      return "observe";
    case DeviceOrder::DEVICE_COMMAND:
      return "command";
    case DeviceOrder::DEVICE_OPEN_TOOL:
      return "open";
    case DeviceOrder::DEVICE_CLOSE_TOOL:
      return "close";
    case DeviceOrder::DEVICE_SET_SIGNAL:
      return "set signal";
    case DeviceOrder::DEVICE_PLACE_JOINT:
      return "place joint";
  }
  return "unknown";
}

std::string text(GoalState state) {
  switch (state) {
    case GoalState::GOAL_ACCEPTED:
      return "accepted";
    case GoalState::GOAL_ACTIVE:
      return "active";
    case GoalState::GOAL_REACHED:
      return "reached";
    case GoalState::GOAL_BLOCKED:
      return "blocked";
    case GoalState::GOAL_REJECTED:
      return "rejected";
    case GoalState::GOAL_CANCELLED:
      return "cancelled";
    case GoalState::GOAL_REPLACED:
      return "replaced";
    case GoalState::GOAL_TIMED_OUT:
      return "timed_out";
  }
  return "unknown";
}

std::string text(NodeKind kind) {
  switch (kind) {
    case NodeKind::NODE_PLANNER:
      return "planner";
    case NodeKind::NODE_DRIVER:
      return "driver";
    case NodeKind::NODE_WORLD:
      return "world";
    case NodeKind::NODE_SUPERVISOR:
      return "supervisor";
    case NodeKind::NODE_AGENT:
      return "agent";
    case NodeKind::NODE_CLIENT:
      return "client";
    case NodeKind::NODE_OTHER:
      return "other";
  }
  return "unknown";
}

std::string text(NodeState state) {
  switch (state) {
    case NodeState::NODE_STARTING:
      return "starting";
    case NodeState::NODE_RUNNING:
      return "running";
    case NodeState::NODE_DEGRADED:
      return "degraded";
    case NodeState::NODE_STANDBY:
      return "standby";
    case NodeState::NODE_STOPPING:
      return "stopping";
    case NodeState::NODE_FAILED:
      return "failed";
  }
  return "unknown";
}

std::string text(Severity severity) {
  switch (severity) {
    case Severity::SEVERITY_INFO:
      return "info";
    case Severity::SEVERITY_WARNING:
      return "warning";
    case Severity::SEVERITY_ERROR:
      return "error";
    case Severity::SEVERITY_CRITICAL:
      return "critical";
  }
  return "unknown";
}

std::string text(ContactKind kind) {
  switch (kind) {
    case ContactKind::CONTACT_ARM_ARM:
      return "arm-arm";
    case ContactKind::CONTACT_ARM_OBSTACLE:
      return "arm-obstacle";
    case ContactKind::CONTACT_ARM_SELF:
      return "arm-self";
  }
  return "unknown";
}

std::string text(MotionKind kind) {
  switch (kind) {
    case MotionKind::MOTION_STATIC:
      return "static";
    case MotionKind::MOTION_WAYPOINTS:
      return "waypoints";
    case MotionKind::MOTION_CIRCLE:
      return "circle";
    case MotionKind::MOTION_SINE:
      return "sine";
    case MotionKind::MOTION_CONVEYOR:
      return "conveyor";
    case MotionKind::MOTION_DYNAMIC:
      return "dynamic";
  }
  return "unknown";
}

std::string text(const PlacedShape& shape) {
  const auto& size = shape.dimensions();
  std::array<char, 128> text{};
  switch (shape.kind()) {
    case ShapeKind::SHAPE_BOX:
      std::snprintf(text.data(), text.size(), "box %g × %g × %g m", 2 * size.x(), 2 * size.y(), 2 * size.z());
      break;
    case ShapeKind::SHAPE_SPHERE:
      std::snprintf(text.data(), text.size(), "sphere ⌀ %g m", 2 * size.x());
      break;
    case ShapeKind::SHAPE_CAPSULE:
      std::snprintf(text.data(), text.size(), "capsule ⌀ %g m, length %g m", 2 * size.x(), 2 * (size.x() + size.y()));
      break;
    case ShapeKind::SHAPE_CYLINDER:
      std::snprintf(text.data(), text.size(), "cylinder ⌀ %g m, height %g m", 2 * size.x(), 2 * size.y());
      break;
    case ShapeKind::SHAPE_CONVEX:
      std::snprintf(text.data(), text.size(), "convex, %zu vertices", shape.vertices().size());
      break;
    case ShapeKind::SHAPE_POINTS:
      std::snprintf(text.data(), text.size(), "%zu points, radius %g m", shape.points().size() / 3, size.x());
      break;
    default:
      return "unknown";
  }
  return text.data();
}

}  // namespace hecaton::msg
