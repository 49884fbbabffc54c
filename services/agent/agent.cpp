#include "services/agent/agent.hpp"

#include <algorithm>
#include <filesystem>
#include <stdexcept>
#include <utility>

#include <poll.h>

#include "services/runtime/cause.hpp"
#include "services/runtime/join.hpp"
#include "services/runtime/log.hpp"
#include "services/runtime/node_name.hpp"
#include "services/runtime/periodic_loop.hpp"
#include "services/runtime/process_info.hpp"
#include "services/runtime/run_folder.hpp"

namespace hecaton::services {
namespace {

/// A service may need this many watchdog times until its loop begins: it reads the cell, perhaps with large meshes,
/// while all other services of the machine do the same.
constexpr int kStartTimeFactor = 6;

std::string level_name(LogLevel level) {
  switch (level) {
    case LogLevel::kDebug:
      return "debug";
    case LogLevel::kWarning:
      return "warning";
    case LogLevel::kError:
      return "error";
    case LogLevel::kInfo:
      break;
  }
  return "info";
}

/// Copies the cell's files: a restarted service must not read files that a person edits meanwhile.
std::filesystem::path keep_sources(const planner::SourceFiles& sources, const std::filesystem::path& folder) {
  try {
    sources.keep(folder);
    return folder;
  } catch (const std::filesystem::filesystem_error& error) {
    throw std::runtime_error("the cell's files cannot be copied to " + folder.string() + ": " + error.code().message());
  }
}

/// In the order of planned_hosts().
std::vector<RunFolder> run_folders(const config::CellFile& file, const ServiceOptions& options, bool clean) {
  const std::string origin = run_origin(file.sources);
  const int domain = choose_domain(options, file.network.domain);
  std::vector<RunFolder> folders;
  for (const std::string& host : planned_hosts(file, options.host)) {
    const RunFolder& folder = folders.emplace_back(RunName{file.cell.name, domain, host}, origin, clean);
    if (folder.resumed()) log_info("run resumed", {{"folder", folder.path().string()}});
    if (folder.discarded()) {
      log_warning("checkpoints discarded: they belong to other cell files or to another version",
                  {{"folder", folder.path().string()}});
    }
  }
  return folders;
}

std::vector<PlannedService> planned(const config::CellFile& file, const ServiceOptions& options,
                                    const std::vector<RunFolder>& folders, const std::filesystem::path& sources) {
  std::vector<PlannedService> services = plan_services(file, options.host);
  const std::vector<std::string> hosts = planned_hosts(file, options.host);
  const std::string domain = std::to_string(choose_domain(options, file.network.domain));
  for (PlannedService& service : services) {
    service.arguments.insert(service.arguments.end(), {"--domain", domain, "--log-level", level_name(options.log_level),
                                                       "--sources", sources.string()});
    const auto host = std::find(hosts.begin(), hosts.end(), service.host) - hosts.begin();
    const auto& folder = folders[static_cast<std::size_t>(host)].path();
    service.arguments.insert(service.arguments.end(), {"--checkpoint", (folder / service.name).string()});
  }
  return services;
}

ProcessManagerOptions process_manager_options(const config::CellFile& file, const AgentOptions& agent) {
  ProcessManagerOptions options{
      agent.programs, agent.logs, {}, file.supervision.watchdog, kStartTimeFactor * file.supervision.watchdog};
  options.exit_notifiers = true;
  options.memory_limit = file.supervision.memory_limit;
  if (!agent.restart) {
    options.restart.attempts = 0;
    options.watchdog = std::chrono::nanoseconds(0);
  }
  return options;
}

std::string participant_name(const config::CellFile& file, const std::string& host) {
  return agent_node(planned_hosts(file, host).front());
}

}  // namespace

Agent::Agent(const config::CellFile& file, const ServiceOptions& options, const AgentOptions& agent,
             ShutdownSignal& shutdown)
    : period_(file.supervision.heartbeat_period),
      shutdown_(shutdown),
      folders_(run_folders(file, options, agent.clean)),
      participant_(make_participant(file, options, Role::kAgent, participant_name(file, options.host), &mailbox_)),
      events_(participant_),
      // Twenty rows a lease are enough for fault detection, and cost a cell with long leases little.
      reachability_(participant_, planned_hosts(file, options.host),
                    std::max(period_, file.supervision.host_lease / 20), bus::Clock::now()),
      processes_(planned(file, options, folders_, keep_sources(file.sources, folders_.front().path() / "sources")),
                 process_manager_options(file, agent)) {
  for (const std::string& host : planned_hosts(file, options.host)) {
    heartbeats_.emplace_back(participant_, NodeIdentity{agent_node(host), msg::NodeKind::NODE_AGENT, {}, host},
                             heartbeat_timing(file, options));
  }
  shutdown_.wake(&mailbox_);
}

Agent::~Agent() {
  shutdown_.wake(nullptr);
}

void Agent::run() {
  auto deadline = bus::Clock::now();
  auto kill_at = bus::Clock::time_point::max();
  for (RunFolder& folder : folders_) folder.keep();
  turn();  // starts all services
  systemd_.ready();
  while (!(ending_ && processes_.all_ended())) {
    const auto now = bus::Clock::now();
    if (shutdown_.requested() && !ending_) {
      ending_ = true;
      log_info("agent ends its services");
      systemd_.stopping();
      processes_.terminate_all();
      kill_at = now + kEndTimeout;
    }
    if (now >= kill_at) {
      log_warning("services did not end in time and are killed",
                  {{"limit_s", std::chrono::duration<double>(kEndTimeout).count()}});
      processes_.kill_all();
      kill_at = bus::Clock::time_point::max();
    }
    if (now >= deadline) {
      const NextDeadline next = next_deadline(deadline, now, period_);
      loop_.record_lateness(now - deadline, next.skipped);
      deadline = next.at;
      publish_heartbeat(now);
      touch_folders(now);
    }
    turn();
    systemd_.loop_turns(now);
    loop_.record_tick(bus::Clock::now() - now);
    wait(std::min({deadline, kill_at, processes_.next_start().value_or(deadline)}));
  }
  for (RunFolder& folder : folders_) folder.end();
  // Readers get the last events before the writer is gone. A reader that is gone causes no longer delay.
  static_cast<void>(events_.wait_acknowledged(std::chrono::milliseconds(200)));
  log_info("agent ends");
}

void Agent::wait(bus::Clock::time_point until) {
  descriptors_.clear();
  descriptors_.push_back({mailbox_.fd(), POLLIN, 0});
  processes_.append_descriptors(descriptors_);
  const auto left = std::max(until - bus::Clock::now(), bus::Clock::duration::zero());
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(left);
  const timespec timeout{seconds.count(), std::chrono::nanoseconds(left - seconds).count()};
  if (ppoll(descriptors_.data(), descriptors_.size(), &timeout, nullptr) <= 0) return;
  if ((descriptors_.front().revents & POLLIN) == 0) return;
  static_cast<void>(mailbox_.wait(bus::Clock::duration::zero()));
  static_cast<void>(mailbox_.take_events());
}

void Agent::turn() {
  for (const ProcessEvent& event : processes_.turn(bus::Clock::now())) publish(event);
}

void Agent::publish(const ProcessEvent& event) {
  const PlannedService& service = *event.service;
  if (event.kind == ProcessEvent::Kind::kKilled) {
    log_error(event.killed == KillReason::kHung ? "service hangs and is killed"
                                                : "service uses too much memory and is killed",
              {{"service", service.name}, {"reason", event.reason}});
    return;
  }
  if (event.kind == ProcessEvent::Kind::kNotStarted || event.kind == ProcessEvent::Kind::kGivenUp) {
    log_error("service does not run", {{"service", service.name}, {"reason", event.reason}});
    return;
  }
  const bool exited = event.kind == ProcessEvent::Kind::kExited;
  msg::ProcessEvent message;
  message.process(service.host + "/" + service.name);
  message.host(service.host);
  message.name(service.name);
  message.node(service.node);
  message.pid(event.pid);
  message.kind(exited ? msg::ProcessEventKind::PROCESS_EXITED : msg::ProcessEventKind::PROCESS_STARTED);
  message.wanted(event.wanted);
  message.exit_code(exited ? event.end.exit_code : 0);
  message.signal_number(exited ? event.end.signal_number : 0);
  message.restarts(event.restarts);
  message.sequence_number(++sequence_);
  message.stamp_ns(stamp_now());
  if (exited && event.killed != KillReason::kNone) {
    const auto kind =
        event.killed == KillReason::kHung ? msg::CauseKind::CAUSE_NODE_SILENT : msg::CauseKind::CAUSE_PROCESS_DIED;
    message.cause(make_cause(kind, service.node, event.reason));
  }
  static_cast<void>(events_.write(message));  // the bus logs a refusal
  if (!exited) {
    log_info("service started", {{"service", service.name}, {"pid", event.pid}, {"restarts", event.restarts}});
  } else if (event.wanted) {
    log_info("service ended", {{"service", service.name}, {"pid", event.pid}});
  } else {
    log_warning("service died", {{"service", service.name},
                                 {"pid", event.pid},
                                 {"exit_code", event.end.exit_code},
                                 {"signal", event.end.signal_number},
                                 {"reason", event.reason}});
  }
}

void Agent::publish_heartbeat(bus::Clock::time_point now) {
  HealthReport report;
  report.newest_event = sequence_;
  if (!processes_.healthy()) {
    report.state = msg::NodeState::NODE_DEGRADED;
    report.cause = make_cause(msg::CauseKind::CAUSE_PROCESS_DIED, {}, processes_.problem());
  }
  if (ending_) report.state = msg::NodeState::NODE_STOPPING;
  for (HeartbeatPublisher& heartbeat : heartbeats_) heartbeat.publish(now, report, loop_);
  reachability_.report(now);
}

void Agent::touch_folders(bus::Clock::time_point now) {
  if (now < touched_ + std::chrono::minutes(1)) return;
  touched_ = now;
  for (const RunFolder& folder : folders_) folder.touch();
}

}  // namespace hecaton::services
