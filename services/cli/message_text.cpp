#include "services/cli/message_text.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <ctime>

#include "services/cli/quantities.hpp"

namespace hecaton::services::cli {

// No default in any switch: the compiler then tells which new value has no word yet.
std::string text(msg::Mode mode) {
  switch (mode) {
    case msg::Mode::MODE_RUN:
      return "run";
    case msg::Mode::MODE_HOLD:
      return "hold";
    case msg::Mode::MODE_STOP:
      return "stop";
  }
  return "unknown";
}

std::string text(msg::ArmMode mode) {
  switch (mode) {
    case msg::ArmMode::ARM_STARTING:
      return "starting";
    case msg::ArmMode::ARM_RUNNING:
      return "running";
    case msg::ArmMode::ARM_BRAKING:
      return "braking";
    case msg::ArmMode::ARM_STOPPED:
      return "stopped";
    case msg::ArmMode::ARM_FAILED:
      return "failed";
  }
  return "unknown";
}

std::string text(msg::GoalState state) {
  switch (state) {
    case msg::GoalState::GOAL_ACCEPTED:
      return "accepted";
    case msg::GoalState::GOAL_ACTIVE:
      return "active";
    case msg::GoalState::GOAL_REACHED:
      return "reached";
    case msg::GoalState::GOAL_BLOCKED:
      return "blocked";
    case msg::GoalState::GOAL_REJECTED:
      return "rejected";
    case msg::GoalState::GOAL_CANCELLED:
      return "cancelled";
    case msg::GoalState::GOAL_REPLACED:
      return "replaced";
    case msg::GoalState::GOAL_TIMED_OUT:
      return "timed_out";
  }
  return "unknown";
}

std::string text(msg::NodeKind kind) {
  switch (kind) {
    case msg::NodeKind::NODE_PLANNER:
      return "planner";
    case msg::NodeKind::NODE_DRIVER:
      return "driver";
    case msg::NodeKind::NODE_WORLD:
      return "world";
    case msg::NodeKind::NODE_SUPERVISOR:
      return "supervisor";
    case msg::NodeKind::NODE_AGENT:
      return "agent";
    case msg::NodeKind::NODE_CLIENT:
      return "client";
    case msg::NodeKind::NODE_OTHER:
      return "other";
  }
  return "unknown";
}

std::string text(msg::NodeState state) {
  switch (state) {
    case msg::NodeState::NODE_STARTING:
      return "starting";
    case msg::NodeState::NODE_RUNNING:
      return "running";
    case msg::NodeState::NODE_DEGRADED:
      return "degraded";
    case msg::NodeState::NODE_STANDBY:
      return "standby";
    case msg::NodeState::NODE_STOPPING:
      return "stopping";
    case msg::NodeState::NODE_FAILED:
      return "failed";
  }
  return "unknown";
}

std::string text(msg::Severity severity) {
  switch (severity) {
    case msg::Severity::SEVERITY_INFO:
      return "info";
    case msg::Severity::SEVERITY_WARNING:
      return "warning";
    case msg::Severity::SEVERITY_ERROR:
      return "error";
    case msg::Severity::SEVERITY_CRITICAL:
      return "critical";
  }
  return "unknown";
}

std::string text(msg::ContactKind kind) {
  switch (kind) {
    case msg::ContactKind::CONTACT_ARM_ARM:
      return "arm-arm";
    case msg::ContactKind::CONTACT_ARM_OBSTACLE:
      return "arm-obstacle";
    case msg::ContactKind::CONTACT_ARM_SELF:
      return "arm-self";
  }
  return "unknown";
}

bool is_final(msg::GoalState state) {
  switch (state) {
    case msg::GoalState::GOAL_ACCEPTED:
    case msg::GoalState::GOAL_ACTIVE:
    case msg::GoalState::GOAL_BLOCKED:
      return false;
    case msg::GoalState::GOAL_REACHED:
    case msg::GoalState::GOAL_REJECTED:
    case msg::GoalState::GOAL_CANCELLED:
    case msg::GoalState::GOAL_REPLACED:
    case msg::GoalState::GOAL_TIMED_OUT:
      return true;
  }
  return false;
}

std::string binding_text(const msg::GoalStatus& goal) {
  if (!goal.has_binding()) return {};
  return goal.binding_own() + " – " + goal.binding_other() + ", " + distance_text(goal.binding_distance());
}

std::string why_text(const msg::GoalStatus& goal) {
  if (goal.state() == msg::GoalState::GOAL_REACHED) return {};
  std::string why = goal.cause().text();
  const std::string binding = binding_text(goal);
  const bool told = why.find(binding) != std::string::npos;
  if (!told) why += why.empty() ? binding : " (" + binding + ")";
  if (goal.blocked_duration() > 0.0) why += (why.empty() ? "held back for " : ", for ") + duration_text(goal.blocked_duration());
  if (!goal.recovery_action().empty() && !is_final(goal.state())) why += (why.empty() ? "" : "; ") + goal.recovery_action();
  return why;
}

std::string goal_text(const msg::GoalStatus& goal) {
  const std::string why = why_text(goal);
  return text(goal.state()) + (why.empty() ? "" : ": " + why);
}

std::string waiting_text(const msg::ArmStatus& arm) {
  if (!arm.waiting_for().empty()) return arm.waiting_for();
  if (!arm.has_goal() || is_final(arm.goal().state())) return {};
  return why_text(arm.goal());
}

std::string referee_text(const msg::RefereeReport& report, const Palette& palette) {
  const std::string contacts = std::to_string(report.contacts()) + (report.contacts() == 1 ? " contact" : " contacts");
  std::string out = report.contacts() == 0 ? palette.green(contacts) : palette.red(contacts);
  if (!report.judged()) return out + ", nothing judged yet";
  const msg::Separation& smallest = report.smallest();
  return out + ", smallest separation " + distance_text(smallest.distance()) + " (" + smallest.a() + " – " +
         smallest.b() + ")";
}

double fault_duration(const msg::Fault& fault) {
  if (fault.cleared()) return 1e-9 * static_cast<double>(fault.cleared_ns() - fault.since_ns());
  if (fault.stamp_ns() >= fault.since_ns()) return 1e-9 * static_cast<double>(fault.stamp_ns() - fault.since_ns());
  // Told without a stamp: only the wall clock, which all hosts of a cell should share, remains.
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  const auto now_ms = std::chrono::duration_cast<std::chrono::milliseconds>(now).count();
  return 1e-3 * static_cast<double>(std::max<long long>(0, now_ms - fault.since_unix_ms()));
}

std::string clock_text(long long unix_ms) {
  const std::time_t seconds = unix_ms / 1000;
  std::tm local{};
  if (localtime_r(&seconds, &local) == nullptr) return "–";
  std::array<char, 16> buffer{};
  std::strftime(buffer.data(), buffer.size(), "%H:%M:%S", &local);
  return buffer.data();
}

}  // namespace hecaton::services::cli
