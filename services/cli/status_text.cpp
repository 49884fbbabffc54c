#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <ctime>
#include <numbers>

#include "services/cli/status_output.hpp"
#include "services/command_line/terminal.hpp"
#include "services/messages/convert.hpp"
#include "services/runtime/cause.hpp"
#include "services/runtime/orders.hpp"

namespace hecaton::services::cli {
namespace {

/// "arm2/forearm – pallet, 18 mm"; empty without a binding pair.
std::string binding_text(const msg::GoalStatus& goal) {
  if (!goal.has_binding()) return {};
  return goal.binding_own() + " – " + goal.binding_other() + ", " + distance_text(goal.binding_distance());
}

/// " (tool 0.12 mm and 0.03° from the pose)" of a reached pose goal, as measured; otherwise empty.
std::string tool_text(const msg::GoalStatus& goal) {
  if (goal.state() != msg::GoalState::GOAL_REACHED || !goal.has_tool() || goal.position_error() < 0.0) return {};
  const bool oriented = goal.tool().free_rotation() != msg::FreeRotation::FREE_ALL;
  const std::string angle = decimal_text(goal.orientation_error() * 180.0 / std::numbers::pi, 2) + "°";
  return " (tool " + decimal_text(goal.position_error() * 1e3, 2) + " mm " +
         (oriented ? "and " + angle + " from the pose)" : "from the position)");
}

/// "14:03:59" of the wall clock, local time.
std::string clock_text(long long unix_ms) {
  const std::time_t seconds = unix_ms / 1000;
  std::tm local{};
  if (localtime_r(&seconds, &local) == nullptr) return "–";
  std::array<char, 16> buffer{};
  std::strftime(buffer.data(), buffer.size(), "%H:%M:%S", &local);
  return buffer.data();
}

std::string coloured(msg::Mode mode, const Palette& palette) {
  const std::string word = text(mode);
  return mode == msg::Mode::MODE_RUN    ? palette.green(word)
         : mode == msg::Mode::MODE_HOLD ? palette.yellow(word)
                                        : palette.red(word);
}

std::string coloured(msg::GoalState state, const Palette& palette) {
  std::string word = text(state);
  switch (state) {
    case msg::GoalState::GOAL_REACHED:
      return palette.green(word);
    case msg::GoalState::GOAL_BLOCKED:
      return palette.yellow(word);
    case msg::GoalState::GOAL_REJECTED:
    case msg::GoalState::GOAL_TIMED_OUT:
      return palette.red(word);
    default:
      return word;
  }
}

std::string coloured(msg::Severity severity, const Palette& palette) {
  const std::string word = text(severity);
  return severity >= msg::Severity::SEVERITY_ERROR     ? palette.red(word)
         : severity == msg::Severity::SEVERITY_WARNING ? palette.yellow(word)
                                                       : word;
}

std::string drive_text(const msg::ArmStatus& arm, const Palette& palette) {
  if (!arm.driver_alive()) return palette.red("silent");
  const std::string word = text(arm.state().mode());
  return arm.state().mode() == msg::ArmMode::ARM_FAILED ? palette.red(word) : word;
}

std::string override_text(const msg::ArmStatus& arm, const Palette& palette) {
  std::string speed = speed_text(arm.speed());
  return arm.speed() < kFullSpeed ? palette.yellow(speed) : speed;
}

std::string planner_text(const msg::ArmStatus& arm, const Palette& palette) {
  std::string text = arm.planner() + ", " + std::to_string(arm.term());
  return arm.standby().empty() ? text + palette.yellow(" (no standby)") : text;
}

std::string position_text(const msg::Pose& pose) {
  const msg::Vec3& p = pose.position();
  return decimal_text(p.x(), 3) + " " + decimal_text(p.y(), 3) + " " + decimal_text(p.z(), 3);
}

std::string process_text(const msg::ProcessEvent& process, const Palette& palette) {
  if (process.kind() == msg::ProcessEventKind::PROCESS_STARTED) return palette.green("runs");
  const std::string how = process.signal_number() != 0 ? "ended by signal " + std::to_string(process.signal_number())
                                                       : "exited with " + std::to_string(process.exit_code());
  return process.wanted() ? how : palette.red(how);
}

}  // namespace

std::string reason_text(const msg::GoalStatus& goal) {
  if (goal.state() == msg::GoalState::GOAL_REACHED) return {};
  std::string why = goal.cause().text();
  const std::string binding = binding_text(goal);
  const bool known = why.find(binding) != std::string::npos;
  if (!known) why += why.empty() ? binding : " (" + binding + ")";
  if (goal.blocked_duration() > 0.0)
    why += (why.empty() ? "obstructed for " : ", for ") + duration_text(goal.blocked_duration());
  if (!goal.recovery_action().empty() && !is_final(goal.state()))
    why += (why.empty() ? "" : "; ") + goal.recovery_action();
  if (why.empty() && goal.state() == msg::GoalState::GOAL_BLOCKED) return "its planner has reported no reason";
  return why;
}

std::string goal_text(const msg::GoalStatus& goal) {
  const std::string why = reason_text(goal);
  return text(goal.state()) + (why.empty() ? "" : ": " + why) + tool_text(goal);
}

std::string waiting_text(const msg::ArmStatus& arm) {
  if (!is_none(arm.waiting_for())) return arm.waiting_for().text();
  if (!arm.has_goal() || is_final(arm.goal().state())) return {};
  return reason_text(arm.goal());
}

std::string contact_text(const msg::ContactReport& report, const Palette& palette) {
  const std::string contacts = std::to_string(report.contacts()) + (report.contacts() == 1 ? " contact" : " contacts");
  std::string out = report.contacts() == 0 ? palette.green(contacts) : palette.red(contacts);
  if (!report.has_smallest()) return out + ", no pair checked yet";
  const msg::Separation& smallest = report.smallest();
  return out + ", smallest separation " + distance_text(smallest.distance()) + " (" + smallest.a() + " – " +
         smallest.b() + ")";
}

double fault_duration(const msg::Fault& fault) {
  if (fault.cleared()) return 1e-9 * static_cast<double>(fault.cleared_ns() - fault.since_ns());
  if (fault.stamp_ns() >= fault.since_ns()) return 1e-9 * static_cast<double>(fault.stamp_ns() - fault.since_ns());
  // Without a stamp only the wall clock remains, which should be the same on all hosts of a cell.
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  const auto now_ms = std::chrono::duration_cast<std::chrono::milliseconds>(now).count();
  return 1e-3 * static_cast<double>(std::max<long long>(0, now_ms - fault.since_unix_ms()));
}

std::string gripper_text(const msg::ToolState& tool) {
  std::string text = tool.width() >= 0.0 ? distance_text(tool.width()) : "";
  const auto add = [&](const std::string& words) { text += (text.empty() ? "" : ", ") + words; };
  if (tool.moving()) add("moves");
  if (!tool.holding().empty()) add("holds " + tool.holding());
  return text.empty() ? "holds nothing" : text;
}

std::string arms_text(const msg::CellStatus& status, const Palette& palette, const Tools& tools) {
  // The planner of an arm changes only in cells with standby planners.
  const bool has_standbys = !status.mode().leases().empty();
  const bool has_overrides = std::any_of(status.arms().begin(), status.arms().end(),
                                         [](const msg::ArmStatus& arm) { return arm.speed() < kFullSpeed; });
  std::vector<Table::Column> columns{{"arm"},
                                     {"mode"},
                                     {"drive"},
                                     {"goal"},
                                     {"to go", Align::kRight},
                                     {"for", Align::kRight},
                                     {"carries"},
                                     {"age", Align::kRight}};
  if (!tools.empty()) columns.push_back({"gripper"});
  if (has_overrides) columns.push_back({"speed", Align::kRight});
  if (has_standbys) columns.push_back({"planner, term"});
  columns.push_back({"waits for, or is limited by"});
  Table table(columns);
  for (const msg::ArmStatus& arm : status.arms()) {
    std::string goal = "–";
    std::string distance;
    std::string elapsed;
    if (arm.has_goal()) {
      goal = coloured(arm.goal().state(), palette);
      if (!is_final(arm.goal().state())) distance = decimal_text(arm.goal().distance_to_goal(), 3);
      if (arm.goal().elapsed() > 0.0) elapsed = duration_text(arm.goal().elapsed());
    }
    std::vector<std::string> cells{
        arm.arm(), coloured(arm.mode(), palette), drive_text(arm, palette),      goal, distance,
        elapsed,   arm.state().carried(),         duration_text(arm.state_age())};
    if (!tools.empty()) {
      const auto tool = tools.find(arm.arm());
      cells.push_back(tool == tools.end() ? "" : gripper_text(tool->second));
    }
    if (has_overrides) cells.push_back(override_text(arm, palette));
    if (has_standbys) cells.push_back(planner_text(arm, palette));
    cells.push_back(waiting_text(arm));
    table.add(cells);
  }
  return table.text(palette);
}

std::string nodes_text(const msg::CellStatus& status, const Palette& palette) {
  Table table({{"node"},
               {"host"},
               {"pid", Align::kRight},
               {"state"},
               {"tick p50", Align::kRight},
               {"p99 µs", Align::kRight},
               {"memory", Align::kRight},
               {"age", Align::kRight},
               {"oldest input"}});
  for (const msg::NodeStatus& node : status.nodes()) {
    const msg::Heartbeat& heartbeat = node.heartbeat();
    std::string state = node.alive() ? text(heartbeat.state()) : palette.red("silent");
    if (node.alive() && heartbeat.state() == msg::NodeState::NODE_DEGRADED) {
      state = palette.yellow(state.append(": ").append(heartbeat.cause().text()));
    }
    if (node.alive() && heartbeat.state() == msg::NodeState::NODE_FAILED)
      state = palette.red(state.append(": ").append(heartbeat.cause().text()));
    std::string input = heartbeat.oldest_input();
    if (!input.empty()) input.append(", ").append(duration_text(heartbeat.oldest_input_age()));
    table.add({heartbeat.node(), heartbeat.host(), std::to_string(heartbeat.pid()), state,
               decimal_text(heartbeat.tick_p50_us(), 0), decimal_text(heartbeat.tick_p99_us(), 0),
               bytes_text(static_cast<double>(heartbeat.rss_bytes())), duration_text(node.age()), input});
  }
  return table.text(palette);
}

std::string hosts_text(const msg::CellStatus& status, const Palette& palette) {
  Table table({{"host"},
               {"agent"},
               {"age", Align::kRight},
               {"process"},
               {"pid", Align::kRight},
               {"state"},
               {"restarts", Align::kRight}});
  for (const msg::HostStatus& host : status.hosts()) {
    const std::string agent = host.agent_alive() ? palette.green("alive") : palette.red("silent");
    bool first = true;
    for (const msg::ProcessEvent& process : host.processes()) {
      table.add({first ? host.host() : "", first ? agent : "", first ? duration_text(host.age()) : "", process.name(),
                 std::to_string(process.pid()), process_text(process, palette), std::to_string(process.restarts())});
      first = false;
    }
    if (first) table.add({host.host(), agent, duration_text(host.age())});
  }
  return table.text(palette);
}

std::string faults_text(const msg::CellStatus& status, const Palette& palette) {
  if (status.faults().empty()) return palette.green("no faults") + "\n";
  Table table({{"since"},
               {"severity"},
               {"kind"},
               {"subject"},
               {"detected within", Align::kRight},
               {"lasts", Align::kRight},
               {"description"}});
  for (const msg::Fault& fault : status.faults()) {
    const std::string lasted = duration_text(fault_duration(fault));
    table.add({clock_text(fault.since_unix_ms()),
               fault.cleared() ? palette.dim("cleared") : coloured(fault.severity(), palette),
               std::string(cause_name(fault.cause().kind())), fault.cause().subject(),
               fault.detection_latency_bound() < 0.0 ? "–" : duration_text(fault.detection_latency_bound()),
               fault.cleared() ? palette.dim(lasted) : lasted, fault.cause().text()});
  }
  return table.text(palette);
}

std::string obstacles_text(const msg::CellStatus& status, const Palette& palette) {
  if (status.obstacles().empty()) return "no obstacles\n";
  Table table(
      {{"obstacle"}, {"shape"}, {"motion"}, {"at x y z [m]"}, {"speed", Align::kRight}, {"age", Align::kRight}});
  for (const msg::ObstacleStatus& obstacle : status.obstacles()) {
    const msg::Vec3& v = obstacle.velocity().linear();
    table.add({obstacle.name(), obstacle.shape(),
               obstacle.attached_to().empty() ? obstacle.motion() : "carried by " + obstacle.attached_to(),
               position_text(obstacle.X_WO()), decimal_text(std::hypot(v.x(), v.y(), v.z()), 2) + " m/s",
               duration_text(obstacle.age())});
  }
  return table.text(palette);
}

std::string speed_text(double speed) {
  std::string number = decimal_text(100.0 * speed, 2);
  if (number.find('.') != std::string::npos) {
    number.erase(number.find_last_not_of('0') + 1);
    if (number.back() == '.') number.pop_back();
  }
  return number + " %";
}

std::string mode_text(const msg::CellStatus& status, const Palette& palette) {
  std::string out = palette.bold("cell " + status.cell()) + ": " + coloured(status.mode().mode(), palette);
  std::string speeds;
  if (status.mode().speed() < kFullSpeed) speeds = speed_text(status.mode().speed());
  for (const msg::ArmSpeed& own : status.mode().speeds()) {
    speeds += (speeds.empty() ? "" : ", ") + own.arm() + " " + speed_text(own.speed());
  }
  if (!speeds.empty()) out += ", " + palette.yellow("speed " + speeds);
  const auto add_arms = [&](const char* word, const std::vector<std::string>& arms) {
    if (arms.empty()) return;
    out += std::string(", ") + word;
    for (const std::string& arm : arms) out += " " + arm;
  };
  add_arms("held", arms_on(status.mode(), msg::Mode::MODE_HOLD));
  add_arms("stopped", arms_on(status.mode(), msg::Mode::MODE_STOP));
  std::vector<std::string> lost;
  for (const msg::LostArm& arm : status.mode().lost_arms()) lost.push_back(arm.arm());
  add_arms("lost and avoided", lost);
  if (const std::string why = causes_text(status.mode()); !why.empty()) out += " (" + why + ")";
  return out + "\n";
}

std::string status_text(const msg::CellStatus& status, const Palette& palette, const Tools& tools) {
  std::string out = mode_text(status, palette);
  out += status.supervisor() + " up " + duration_text(status.uptime()) +
         (status.standby().empty() ? "" : ", standby " + status.standby()) + "; contact monitor: " +
         (status.has_contact_report() ? contact_text(status.contact_report(), palette) : "no report yet") + "\n\n";
  out += arms_text(status, palette, tools) + "\n" + nodes_text(status, palette) + "\n" + faults_text(status, palette);
  return out;
}

}  // namespace hecaton::services::cli
