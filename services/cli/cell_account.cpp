#include "services/cli/cell_account.hpp"

#include <algorithm>
#include <chrono>
#include <fstream>
#include <sstream>
#include <string>

#include <unistd.h>

#include "services/command_line/quantities.hpp"
#include "services/command_line/table.hpp"
#include "services/messages/convert.hpp"

namespace hecaton::services::cli {
namespace {

constexpr std::uint64_t kWindow = 512;  // ticks; windows of one planner that were taken are this far apart

/// A world that goes on where another died may begin this much before the other's last report [s].
constexpr double kRecalled = 1.0;

double now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
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

void RefereeAccount::update(const msg::RefereeReport& report) {
  if (report.time() < time_ - kRecalled || report.contacts() < contacts_) {
    before_ += contacts_;
    contacts_ = 0;
  }
  time_ = report.time();
  contacts_ = report.contacts();
  if (!report.judged()) return;
  const auto separation = messages::from_message(report.smallest(), "RefereeReport: smallest");
  if (separation && (!smallest_ || separation->distance < smallest_->distance)) smallest_ = *separation;
}

void TickAccount::update(const msg::CellStatus& status) {
  for (const msg::NodeStatus& node : status.nodes()) {
    const msg::Heartbeat& beat = node.heartbeat();
    if (beat.kind() != msg::NodeKind::NODE_PLANNER || beat.ticks() == 0) continue;
    max_ = std::max(max_, beat.tick_max_us());
    std::uint64_t& taken = ticks_[beat.node()];
    if (beat.ticks() < taken) taken = 0;  // it was restarted
    if (beat.ticks() < taken + kWindow) continue;
    taken = beat.ticks();
    p50_.push_back(beat.tick_p50_us());
    p99_.push_back(beat.tick_p99_us());
  }
}

std::optional<Quantiles> TickAccount::typical() const {
  if (p50_.empty()) return std::nullopt;
  const auto median = [](std::vector<double> values) {
    std::sort(values.begin(), values.end());
    return quantile(values, 0.5);
  };
  return Quantiles{median(p50_), median(p99_), max_};
}

std::optional<Quantiles> TickAccount::worst() const {
  if (p50_.empty()) return std::nullopt;
  return Quantiles{*std::max_element(p50_.begin(), p50_.end()), *std::max_element(p99_.begin(), p99_.end()), max_};
}

void UsageAccount::begin(const msg::CellStatus& status) {
  for (const msg::NodeStatus& node : status.nodes()) {
    const auto usage = process_usage(static_cast<pid_t>(node.heartbeat().pid()));
    if (usage) starts_[node.heartbeat().pid()] = {now(), *usage};
  }
}

Json UsageAccount::end(const msg::CellStatus& status) const {
  Json processes = Json::array();
  for (const msg::NodeStatus& node : status.nodes()) {
    const msg::Heartbeat& beat = node.heartbeat();
    const auto usage = process_usage(static_cast<pid_t>(beat.pid()));
    if (!usage) continue;
    Json process{{"node", beat.node()}, {"pid", beat.pid()}, {"cpu_percent", nullptr}};
    if (const auto start = starts_.find(beat.pid()); start != starts_.end()) {
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

}  // namespace hecaton::services::cli
