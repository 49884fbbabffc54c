#include "services/cli/cell_monitors.hpp"

#include <algorithm>
#include <chrono>
#include <fstream>
#include <sstream>
#include <string>
#include <utility>

#include <unistd.h>

#include "services/command_line/terminal.hpp"
#include "services/messages/convert.hpp"
#include "services/runtime/node_name.hpp"

namespace hecaton::services::cli {
namespace {

constexpr std::uint64_t kWindow = 512;  // ticks of a heartbeat's quantiles: windows do not overlap

/// A restarted world that resumes from a checkpoint may be this much before the last report [s].
constexpr double kCheckpointAge = 1.0;

double now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

bool is_supervisor(const std::string& node) {
  return node == supervisor_node() || node.starts_with(standby_node(supervisor_node(), {}));
}

std::string title(const std::string& node) {
  return node.empty() || node == supervisor_node() ? "the supervisor" : node;
}

/// Of the supervisor that answers; 0 before it has received its own heartbeat.
std::int32_t pid_of(const msg::CellStatus& status) {
  const auto& nodes = status.nodes();
  const auto own = std::find_if(nodes.begin(), nodes.end(), [&](const msg::NodeStatus& node) {
    return node.heartbeat().node() == status.supervisor();
  });
  return own == nodes.end() ? 0 : own->heartbeat().pid();
}

}  // namespace

std::optional<ProcessUsage> process_usage(pid_t pid) {
  const std::string folder = "/proc/" + std::to_string(pid);
  std::ifstream stat(folder + "/stat");
  std::string line;
  if (!std::getline(stat, line)) return std::nullopt;
  const std::size_t name_end = line.rfind(')');  // the name may hold blanks and parentheses
  if (name_end == std::string::npos) return std::nullopt;
  std::istringstream fields(line.substr(name_end + 1));
  // proc(5): after the name come state (3) … utime (14) and stime (15), in clock ticks.
  std::string skipped;
  for (int field = 3; field < 14; ++field) fields >> skipped;
  double user = 0.0;
  double system = 0.0;
  fields >> user >> system;
  ProcessUsage usage;
  usage.cpu_time = (user + system) / static_cast<double>(sysconf(_SC_CLK_TCK));

  std::ifstream status(folder + "/status");
  while (std::getline(status, line)) {
    std::istringstream entry(line);
    std::string key;
    std::uint64_t kilobytes = 0;
    entry >> key >> kilobytes;
    if (key == "VmRSS:") usage.rss_bytes = kilobytes * 1024;
    if (key == "VmHWM:") usage.peak_rss_bytes = kilobytes * 1024;
  }
  return usage;
}

void ContactTotals::update(const msg::ContactReport& report) {
  if (report.time() < time_ - kCheckpointAge || report.contacts() < contacts_) {
    before_ += contacts_;
    contacts_ = 0;
  }
  time_ = report.time();
  contacts_ = report.contacts();
  if (!report.has_smallest()) return;
  const auto separation = messages::from_message(report.smallest(), "ContactReport: smallest");
  if (separation && (!smallest_ || separation->distance < smallest_->distance)) smallest_ = *separation;
}

void TickStatistics::update(const msg::CellStatus& status) {
  for (const msg::NodeStatus& node : status.nodes()) {
    const msg::Heartbeat& heartbeat = node.heartbeat();
    if (heartbeat.kind() != msg::NodeKind::NODE_PLANNER || heartbeat.ticks() == 0) continue;
    max_ = std::max(max_, heartbeat.tick_max_us());
    std::uint64_t& taken = ticks_[heartbeat.node()];
    if (heartbeat.ticks() < taken) taken = 0;  // the planner was restarted
    if (heartbeat.ticks() < taken + kWindow) continue;
    taken = heartbeat.ticks();
    p50_.push_back(heartbeat.tick_p50_us());
    p99_.push_back(heartbeat.tick_p99_us());
  }
}

std::optional<Quantiles> TickStatistics::typical() const {
  if (p50_.empty()) return std::nullopt;
  const auto median = [](std::vector<double> values) {
    std::sort(values.begin(), values.end());
    return quantile(values, 0.5);
  };
  return Quantiles{median(p50_), median(p99_), max_};
}

std::optional<Quantiles> TickStatistics::worst() const {
  if (p50_.empty()) return std::nullopt;
  return Quantiles{*std::max_element(p50_.begin(), p50_.end()), *std::max_element(p99_.begin(), p99_.end()), max_};
}

void UsageMonitor::begin(const msg::CellStatus& status) {
  for (const msg::NodeStatus& node : status.nodes()) {
    const auto usage = process_usage(static_cast<pid_t>(node.heartbeat().pid()));
    if (usage) starts_[node.heartbeat().pid()] = {now(), *usage};
  }
}

Json UsageMonitor::end(const msg::CellStatus& status) const {
  Json processes = Json::array();
  for (const msg::NodeStatus& node : status.nodes()) {
    const msg::Heartbeat& heartbeat = node.heartbeat();
    const auto usage = process_usage(static_cast<pid_t>(heartbeat.pid()));
    if (!usage) continue;
    Json process{{"node", heartbeat.node()}, {"pid", heartbeat.pid()}, {"cpu_percent", nullptr}};
    if (const auto start = starts_.find(heartbeat.pid()); start != starts_.end()) {
      const double wall = std::max(now() - start->second.wall, 1e-3);
      process["cpu_percent"] = 100.0 * (usage->cpu_time - start->second.usage.cpu_time) / wall;
    }
    process["rss_bytes"] = usage->rss_bytes;
    process["peak_rss_bytes"] = usage->peak_rss_bytes;
    processes.push_back(std::move(process));
  }
  return processes;
}

std::string usage_text(const Json& processes, const Palette& palette) {
  Table table({{"process"},
               {"pid", Align::kRight},
               {"cpu", Align::kRight},
               {"memory", Align::kRight},
               {"peak", Align::kRight}});
  for (const Json& process : processes) {
    const Json& cpu = process.at("cpu_percent");
    table.add({process.at("node").get<std::string>(), std::to_string(process.at("pid").get<long long>()),
               cpu.is_null() ? "–" : decimal_text(cpu.get<double>(), 1) + " %",
               bytes_text(process.at("rss_bytes").get<double>()),
               bytes_text(process.at("peak_rss_bytes").get<double>())});
  }
  return table.text(palette);
}

std::string SupervisorTracker::on_process_event(const msg::ProcessEvent& event, bus::Clock::time_point now) {
  const bool died = event.kind() == msg::ProcessEventKind::PROCESS_EXITED && !event.wanted();
  if (!died || leader_.empty() || !is_supervisor(event.node())) return {};
  if (event.node() == standby_) standby_.clear();
  const bool led = event.node() == leader_ && (pid_ == 0 || pid_ == event.pid());
  // The leader reports the death of its standby as a fault.
  if (!led && !death_) return {};
  if (led) death_ = Death{event.pid(), now};
  return title(event.node()) + " died (process " + std::to_string(event.pid()) +
         (event.signal_number() != 0 ? ", signal " + std::to_string(event.signal_number())
                                     : ", exit code " + std::to_string(event.exit_code())) +
         "): arms continue, " +
         (standby_.empty() ? "faults and orders wait for its restart" : title(standby_) + " takes over");
}

std::string SupervisorTracker::on_status(const msg::CellStatus* status, bus::Clock::time_point now) {
  if (status == nullptr) {
    if (death_ || std::exchange(silent_, true)) return {};
    return title(leader_) + " does not answer: arms continue, faults and orders wait for it" +
           (standby_.empty() ? "" : " or " + title(standby_));
  }
  if (is_of_dead_leader(*status, now)) return {};
  const std::string before = std::exchange(leader_, status->supervisor());
  const std::int32_t pid = pid_of(*status);
  const bool another = !before.empty() && leader_ != before;
  const bool died = std::exchange(death_, std::nullopt).has_value();
  // The successor may answer before the event of the death arrives.
  const bool successor = !another && (died || (pid_ != 0 && pid != 0 && pid != pid_));
  if (pid != 0 || another || successor) pid_ = pid;
  standby_ = status->standby();
  const bool was_silent = std::exchange(silent_, false);
  if (another) return title(leader_) + " leads, in place of " + title(before);
  if (successor) return title(leader_) + " was restarted";
  return was_silent ? title(leader_) + " answers again" : "";
}

// The dead leader's last answer may arrive after its death. Its successor has another pid, or its uptime is less than
// the time since the death.
bool SupervisorTracker::is_of_dead_leader(const msg::CellStatus& status, bus::Clock::time_point now) const {
  if (!death_ || status.supervisor() != leader_) return false;
  const std::int32_t pid = pid_of(status);
  const bool may_be = pid == 0 || pid == death_->pid;
  return may_be && status.uptime() > std::chrono::duration<double>(now - death_->at).count();
}

std::vector<std::string> SupervisorMonitor::update(const msg::CellStatus* status) {
  std::vector<std::string> lines;
  const auto add = [&](std::string line) {
    if (!line.empty()) lines.push_back(std::move(line));
  };
  for (const auto& sample : processes_.take()) {
    if (!sample.disposed) add(tracker_.on_process_event(sample.value, sample.received));
  }
  add(tracker_.on_status(status, bus::Clock::now()));
  return lines;
}

}  // namespace hecaton::services::cli
