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
#include "services/runtime/run_origin.hpp"

namespace hecaton::services {
namespace {

constexpr int kStartPatience = 6;

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

/// A service that is started again must not read what somebody is editing for the next time.
std::filesystem::path keep_sources(const planner::SourceFiles& sources, const std::filesystem::path& folder) {
  try {
    sources.keep(folder);
    return folder;
  } catch (const std::filesystem::filesystem_error& error) {
    throw std::runtime_error("the cell's files cannot be kept in " + folder.string() + ": " + error.code().message());
  }
}

/// In the order of planned_hosts().
std::vector<RunFolder> run_folders(const config::CellFile& file, const ServiceOptions& options, bool anew) {
  const std::string origin = run_origin(file.sources);
  const int domain = choose_domain(options, file.network.domain);
  std::vector<RunFolder> folders;
  for (const std::string& host : planned_hosts(file, options.host)) {
    const RunFolder& folder = folders.emplace_back(RunName{file.cell.name, domain, host}, origin, anew);
    if (folder.goes_on()) log_info("goes on with what was remembered", {{"folder", folder.path().string()}});
    if (folder.forgot()) {
      log_warning("what was remembered is not used: it is of other files, or of another version",
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
    service.arguments.insert(service.arguments.end(), {"--memory", (folder / service.name).string()});
  }
  return services;
}

KeeperOptions keeper_options(const config::CellFile& file, const AgentOptions& agent) {
  // Before its loop begins it reads the cell, perhaps with large meshes, on a machine on which all others do the same.
  KeeperOptions options{
      agent.programs, agent.logs, {}, file.supervision.watchdog, kStartPatience * file.supervision.watchdog};
  options.life_lines = true;
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
      folders_(run_folders(file, options, agent.anew)),
      participant_(make_participant(file, options, participant_name(file, options.host), &mailbox_)),
      events_(participant_),
      // Twenty rows a lease are enough to judge by, and cost a cell with long leases little.
      reachability_(participant_, planned_hosts(file, options.host),
                    std::max(period_, file.supervision.host_lease / 20), bus::Clock::now()),
      keeper_(planned(file, options, folders_, keep_sources(file.sources, folders_.front().path() / "sources")),
              keeper_options(file, agent)) {
  for (const std::string& host : planned_hosts(file, options.host)) {
    pulses_.emplace_back(participant_, PulseIdentity{agent_node(host), msg::NodeKind::NODE_AGENT, {}, host},
                         pulse_timing(file, options));
  }
  shutdown_.wake(&mailbox_);
}

Agent::~Agent() {
  shutdown_.wake(nullptr);
}

void Agent::run() {
  auto deadline = bus::Clock::now();
  auto patience = bus::Clock::time_point::max();
  for (RunFolder& folder : folders_) folder.keep();
  turn();  // all are being started
  manager_.ready();
  while (!(ending_ && keeper_.all_ended())) {
    const auto now = bus::Clock::now();
    if (shutdown_.requested() && !ending_) {
      ending_ = true;
      log_info("agent ends its services");
      manager_.stopping();
      keeper_.ask_to_end();
      patience = now + kPatience;
    }
    if (now >= patience) {
      log_warning("killing the services that did not end in time");
      keeper_.kill_all();
      patience = bus::Clock::time_point::max();
    }
    if (now >= deadline) {
      const NextDeadline next = next_deadline(deadline, now, period_);
      loop_.record_lateness(now - deadline, next.skipped);
      deadline = next.at;
      beat(now);
      touch_folders(now);
    }
    turn();
    manager_.turns(now);
    loop_.record_tick(bus::Clock::now() - now);
    wait(std::min({deadline, patience, keeper_.next_start().value_or(deadline)}));
  }
  for (RunFolder& folder : folders_) folder.end();
  // Listeners hear how it ended before our writer is gone; who does not listen any more does not delay us.
  static_cast<void>(events_.wait_acknowledged(std::chrono::milliseconds(200)));
  log_info("agent ends");
}

void Agent::wait(bus::Clock::time_point until) {
  descriptors_.clear();
  descriptors_.push_back({mailbox_.fd(), POLLIN, 0});
  keeper_.append_descriptors(descriptors_);
  const auto left = std::max(until - bus::Clock::now(), bus::Clock::duration::zero());
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(left);
  const timespec timeout{seconds.count(), std::chrono::nanoseconds(left - seconds).count()};
  if (ppoll(descriptors_.data(), descriptors_.size(), &timeout, nullptr) <= 0) return;
  if ((descriptors_.front().revents & POLLIN) == 0) return;
  static_cast<void>(mailbox_.wait(bus::Clock::duration::zero()));
  static_cast<void>(mailbox_.take_events());
}

void Agent::turn() {
  for (const Incident& incident : keeper_.turn(bus::Clock::now())) tell(incident);
}

void Agent::tell(const Incident& incident) {
  const PlannedService& service = *incident.service;
  if (incident.kind == Incident::Kind::kHung) {
    log_error("service hangs and is killed", {{"service", service.name}, {"reason", incident.reason}});
    return;
  }
  if (incident.kind == Incident::Kind::kNotStarted || incident.kind == Incident::Kind::kGivenUp) {
    log_error("service does not run", {{"service", service.name}, {"reason", incident.reason}});
    return;
  }
  const bool exited = incident.kind == Incident::Kind::kExited;
  msg::ProcessEvent event;
  event.process(service.host + "/" + service.name);
  event.host(service.host);
  event.name(service.name);
  event.node(service.node);
  event.pid(incident.pid);
  event.kind(exited ? msg::ProcessEventKind::PROCESS_EXITED : msg::ProcessEventKind::PROCESS_STARTED);
  event.wanted(incident.wanted);
  event.exit_code(exited ? incident.end.exit_code : 0);
  event.signal_number(exited ? incident.end.signal_number : 0);
  event.restarts(incident.restarts);
  event.sequence_number(++sequence_);
  event.stamp_ns(stamp_now());
  if (exited && incident.hung) {
    event.cause(make_cause(msg::CauseKind::CAUSE_NODE_SILENT, service.node, incident.reason));
  }
  static_cast<void>(events_.write(event));  // the bus has logged a refusal
  if (!exited) {
    log_info("service started", {{"service", service.name}, {"pid", incident.pid}, {"restarts", incident.restarts}});
  } else if (incident.wanted) {
    log_info("service ended", {{"service", service.name}, {"pid", incident.pid}});
  } else {
    log_warning("service died", {{"service", service.name},
                                 {"pid", incident.pid},
                                 {"exit_code", incident.end.exit_code},
                                 {"signal", incident.end.signal_number},
                                 {"reason", incident.reason}});
  }
}

void Agent::beat(bus::Clock::time_point now) {
  Vital vital;
  vital.newest_event = sequence_;
  if (!keeper_.all_well()) {
    vital.state = msg::NodeState::NODE_DEGRADED;
    vital.cause = make_cause(msg::CauseKind::CAUSE_PROCESS_DIED, {}, keeper_.complaint());
  }
  if (ending_) vital.state = msg::NodeState::NODE_STOPPING;
  for (Pulse& pulse : pulses_) pulse.beat(now, vital, loop_);
  reachability_.report(now);
}

void Agent::touch_folders(bus::Clock::time_point now) {
  if (now < touched_ + std::chrono::minutes(1)) return;
  touched_ = now;
  for (const RunFolder& folder : folders_) folder.touch();
}

}  // namespace hecaton::services
