#include "services/cli/message_text.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <ctime>

#include "services/command_line/quantities.hpp"
#include "services/runtime/cause.hpp"

namespace hecaton::services::cli {

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
  if (goal.blocked_duration() > 0.0)
    why += (why.empty() ? "held back for " : ", for ") + duration_text(goal.blocked_duration());
  if (!goal.recovery_action().empty() && !is_final(goal.state()))
    why += (why.empty() ? "" : "; ") + goal.recovery_action();
  return why;
}

std::string goal_text(const msg::GoalStatus& goal) {
  const std::string why = why_text(goal);
  return text(goal.state()) + (why.empty() ? "" : ": " + why);
}

std::string waiting_text(const msg::ArmStatus& arm) {
  if (!is_none(arm.waiting_for())) return arm.waiting_for().text();
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
