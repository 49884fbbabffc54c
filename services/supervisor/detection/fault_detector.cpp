#include "services/supervisor/detection/fault_detector.hpp"

#include <algorithm>
#include <cstring>

#include "services/runtime/node_name.hpp"

// Inputs and queries; fault_rules.cpp has the judgement.

namespace hecaton::services {
namespace {

/// Judged exits and contacts are kept for longer than a failover of the supervisor takes.
constexpr Time kTransientKept = std::chrono::seconds(5);
/// Tolerance within which two supervisors give the same contact the same time.
constexpr Time kSameTime = std::chrono::seconds(1);

std::vector<std::string> hosts_of(const std::vector<ExpectedNode>& nodes) {
  std::set<std::string> hosts;
  for (const ExpectedNode& node : nodes) hosts.insert(node.host);
  return {hosts.begin(), hosts.end()};
}

}  // namespace

std::string end_text(const ProcessExit& exit) {
  const std::string process = "process " + std::to_string(exit.pid);
  if (!is_none(exit.cause)) return "its agent ended " + process + ": " + exit.cause.text();
  if (exit.signal_number == 0) return process + " ended with exit code " + std::to_string(exit.exit_code);
  const char* name = strsignal(exit.signal_number);
  return process + " was ended by signal " + std::to_string(exit.signal_number) +
         (name ? " (" + std::string(name) + ")" : std::string());
}

HostLimits DetectionLimits::hosts() const {
  HostLimits hosts;
  hosts.lease = host_lease;
  hosts.link_deadline = host_lease * 3 / 5;
  hosts.recent_row = host_lease / 4;
  // Heartbeats of a node come a little before its host falls silent and a little after it is heard again.
  hosts.pause = std::min(node.silence, std::max(node.silence / 2, 2 * heartbeat_period));
  hosts.settling = 6 * heartbeat_period;
  hosts.recovery = node.recovery;
  hosts.rediscovery = rediscovery;
  hosts.sure_return = sure_return;
  return hosts;
}

bool DetectionLimits::waits(msg::CauseKind kind) const {
  const bool of_host = kind == msg::CauseKind::CAUSE_HOST_ISOLATED || kind == msg::CauseKind::CAUSE_LINK_LOST;
  return waits_for_resume.contains(of_host ? msg::CauseKind::CAUSE_HOST_LOST : kind);
}

FaultDetector::FaultDetector(std::vector<ExpectedNode> nodes, std::vector<std::string> arms,
                             const DetectionLimits& limits, Time now, const std::string& host)
    : limits_(limits),
      nodes_(std::move(nodes)),
      now_(now),
      clock_(limits.loop_period, limits.loop_limit, now),
      liveness_(clock_),
      hosts_(hosts_of(nodes_), host, limits.hosts(), clock_),
      losses_(clock_, host),
      mode_(std::move(arms)) {
  for (const ExpectedNode& node : nodes_) {
    LivenessLimits own = limits_.node;
    if (node.role == msg::NodeKind::NODE_AGENT) own.lost = limits_.host_lease;
    liveness_.expect(node.name, own);
    losses_.expect(node.name, node.host);
    NodeRecord& record = records_[node.name];
    record.has_stream = node.role == msg::NodeKind::NODE_DRIVER || node.role == msg::NodeKind::NODE_WORLD;
    if (!record.has_stream) continue;
    LivenessLimits stream = limits_.node;
    stream.silence = node.role == msg::NodeKind::NODE_DRIVER ? limits_.arm_stream : limits_.world_stream;
    stream.lost = std::max(stream.lost, stream.silence);
    liveness_.expect(stream_name(node.name), stream);
    losses_.expect(stream_name(node.name), node.host);
  }
}

void FaultDetector::advance(Time now) {
  now_ = now;
  stalled_ = clock_.advance(now);
}

void FaultDetector::heard(std::string_view node, const Heartbeat& heartbeat) {
  const ExpectedNode* known = expected(node);
  if (!known) return helper_heard(node, heartbeat);
  NodeRecord& record = records_.find(node)->second;
  hosts_.heard(*hosts_.index(known->host), clock_.at(heartbeat.at), known->role == msg::NodeKind::NODE_AGENT);
  losses_.arrived(node, heartbeat.pid, heartbeat.number);
  const std::int64_t pid = heartbeat.pid;
  // A report of an end that heartbeats contradict for a second is wrong, or forged.
  const bool lives = record.died && record.died->pid == pid && clock_.at(heartbeat.at) - record.died_at > kFalseEnd;
  const bool ended = (record.died && record.died->pid == pid) || (record.stopped && record.pid == pid);
  const bool late = ended && !lives;
  if (late) return;  // sent before the process ended
  note_process(record, pid);
  const bool replaced = record.pid != 0 && record.pid != pid && !record.died && !record.stopped;
  if (replaced) record.unreported_pid = record.pid;
  record.died.reset();
  record.stopped = false;
  record.pid = pid;
  if (heartbeat.speaks) {
    record.failure = heartbeat.failure;
    record.keys = heartbeat.keys;
  }
  liveness_.heard(node, heartbeat.at);
}

void FaultDetector::helper_heard(std::string_view node, const Heartbeat& heartbeat) {
  const auto known = helper_faults_.find(node);
  const bool late = known != helper_faults_.end() && known->second == heartbeat.pid;
  if (late) return;  // sent before the process ended
  if (!heartbeat.failure) return clear_helper(node);
  raise_helper(node, 0,
               {msg::CauseKind::CAUSE_NODE_FAILED, msg::Severity::SEVERITY_WARNING, std::string(node),
                std::string(node) + ": " + heartbeat.failure->text(), limits_.heartbeat_period});
}

void FaultDetector::raise_helper(std::string_view node, std::int64_t ended_pid, const FaultObservation& observation) {
  if (!helper_faults_.contains(node) && helper_faults_.size() >= kMostHelpers) return;
  helper_faults_.insert_or_assign(std::string(node), ended_pid);
  faults_.raise(std::string(node), observation, now_);
}

void FaultDetector::clear_helper(std::string_view node) {
  const auto known = helper_faults_.find(node);
  if (known == helper_faults_.end()) return;
  helper_faults_.erase(known);
  faults_.clear(std::string(node), now_);
}

void FaultDetector::stream_heard(std::string_view node, Time at, std::uint64_t number) {
  const NodeRecord* record = find(node);
  if (!record || !record->has_stream || record->died || record->stopped) return;
  // Before the first heartbeat of a process a state may be a late one of the previous process.
  if (liveness_.last_heard(node)) {
    liveness_.heard(node, at);
    hosts_.heard(*hosts_.index(expected(node)->host), clock_.at(at), false);
  }
  const std::string stream = stream_name(node);
  liveness_.heard(stream, at);
  losses_.arrived(stream, record->pid, number);
}

void FaultDetector::row_heard(std::string_view host, const std::vector<HostAge>& ages, Time at) {
  const auto index = hosts_.index(host);
  const ExpectedNode* agent = agent_of(host);
  if (!index || !agent) return;
  hosts_.row(*index, ages, clock_.at(at));
  if (liveness_.last_heard(agent->name)) liveness_.heard(agent->name, at);
}

void FaultDetector::device_heard(std::string_view arm, std::optional<msg::Cause> fault) {
  const auto found = records_.find(driver_node(arm));
  if (found != records_.end()) found->second.device_fault = std::move(fault);
}

void FaultDetector::process_started(std::string_view node, std::int64_t pid) {
  const auto found = records_.find(node);
  if (found == records_.end()) return;
  NodeRecord& record = found->second;
  if (record.pid == pid) return;  // its heartbeat arrived first
  NodeRecord started;
  started.pid = pid;
  started.has_stream = record.has_stream;
  started.pending_exit = record.pending_exit;
  started.silence_at_end = record.silence_at_end;
  started.device_fault = std::move(record.device_fault);
  record = std::move(started);
  liveness_.restarted(node);
  if (record.has_stream) liveness_.restarted(stream_name(node));
}

void FaultDetector::process_exited(std::string_view node, const ProcessExit& exit, bool news) {
  const auto found = records_.find(node);
  if (found == records_.end()) {
    const FaultRecord* open = faults_.open(std::string(node));
    const bool again = open && open->kind == msg::CauseKind::CAUSE_PROCESS_DIED && !exit.wanted;
    if (!again) clear_helper(node);
    if (exit.wanted || !news) return;
    return raise_helper(node, exit.pid,
                        {msg::CauseKind::CAUSE_PROCESS_DIED, msg::Severity::SEVERITY_WARNING, std::string(node),
                         std::string(node) + ": " + end_text(exit)});
  }
  NodeRecord& record = found->second;
  const bool replaced = record.pid != 0 && record.pid != exit.pid && !record.died;
  if (replaced && liveness_.presence(node) == Presence::kAlive) {
    // Its successor runs already. If the agent was not heard at the end, no fault has reported it yet.
    const bool unreported = news && !exit.wanted && std::exchange(record.unreported_pid, 0) == exit.pid;
    if (unreported) record.pending_exit = exit;
    return;
  }
  record.pid = exit.pid;
  record.stopped = exit.wanted;
  record.died = exit.wanted ? std::nullopt : std::optional(exit);
  record.died_at = clock_.now();
  record.pending_exit = news ? record.died : std::nullopt;
  record.silence_at_end = liveness_.silence(node);
  liveness_.restarted(node);
  if (record.has_stream) liveness_.restarted(stream_name(node));
}

void FaultDetector::contacts(std::uint64_t count, const std::string& subject, const std::string& description) {
  const bool first = !std::exchange(contacts_.known, true);
  if (first && faults_.remembers(msg::CauseKind::CAUSE_CONTACT)) contacts_.count = count;
  if (count > contacts_.count) {
    contacts_.pending.push_back(
        {msg::CauseKind::CAUSE_CONTACT, msg::Severity::SEVERITY_CRITICAL, subject, description});
  }
  contacts_.count = count;
}

void FaultDetector::refusal_heard(const std::string& node, const msg::Refusal& refusal) {
  const msg::CauseKind kind = refusal.cause().kind();
  const bool second = kind == msg::CauseKind::CAUSE_SECOND_WRITER;
  if (!second && kind != msg::CauseKind::CAUSE_INPUT_REFUSED) return;
  const std::string& subject = refusal.cause().subject();
  const std::string key = node_fault_key(kind, subject);
  const auto known = refusals_.find(key);
  if (known == refusals_.end() && refusals_.size() >= kMostRefusals) return;
  const std::string what = refusal.topic().empty() ? "datagrams" : refusal.topic();
  const std::string from =
      "GUID " + refusal.sender() + (refusal.address().empty() ? "" : ", address " + refusal.address());
  const std::string told = second ? node + " receives " + subject + " of two participants: " + refusal.cause().text()
                                  : node + " refuses " + what + " of " + subject + ": " + refusal.cause().text();
  refusals_.insert_or_assign(
      key, Refusals{{kind, second ? msg::Severity::SEVERITY_ERROR : msg::Severity::SEVERITY_WARNING, subject,
                     told + " (" + from + ", " + std::to_string(refusal.count()) + " times)"},
                    clock_.now()});
}

void FaultDetector::arm_stands(const std::string& arm, const std::optional<std::string>& why) {
  const std::string key = fault_key(msg::CauseKind::CAUSE_ARM_STANDS, arm);
  if (!why) return faults_.clear(key, now_);
  faults_.raise(key, {msg::CauseKind::CAUSE_ARM_STANDS, msg::Severity::SEVERITY_ERROR, arm, *why}, now_);
}

void FaultDetector::adopt(const std::string& key, const FaultRecord& record, Time now) {
  faults_.adopt(key, record, now);
  // Of these kinds a supervisor raises those that it observes itself.
  const bool own =
      record.kind == msg::CauseKind::CAUSE_PERSISTENCE_FAILED || record.kind == msg::CauseKind::CAUSE_CHECKPOINT_LOST ||
      record.kind == msg::CauseKind::CAUSE_INPUT_REFUSED || record.kind == msg::CauseKind::CAUSE_SECOND_WRITER;
  const bool judged = record.kind == msg::CauseKind::CAUSE_LINK_LOST || (!own && expects(node_of_fault_key(key)));
  if (!judged) faults_.clear(key, now);
}

void FaultDetector::note_process(NodeRecord& record, std::int64_t pid) const {
  const Time now = clock_.now();
  if (now - record.heartbeat_at > kDuplicate) record.changes = 0;
  if (record.pid != 0 && record.pid != pid) {
    record.changes = record.previous_pid == pid ? record.changes + 1 : 0;
    record.previous_pid = record.pid;
    record.changed_at = now;
  }
  record.heartbeat_at = now;
}

void FaultDetector::remember_transient(Transient transient) {
  while (!transients_.empty() && transients_.front().at < transient.at - kTransientKept) transients_.pop_front();
  transients_.push_back(std::move(transient));
}

// judge_nodes() leaves out exits that the list has.
void FaultDetector::judge_again(Time since) {
  for (const Transient& transient : transients_) {
    if (transient.at < since) continue;
    if (transient.node.empty()) {
      if (faults_.remembers(transient.contact, transient.at - kSameTime)) continue;
      contacts_.pending.push_back(transient.contact);
      contacts_.pending.back().since = transient.at;
    } else {
      NodeRecord& record = records_.find(transient.node)->second;
      record.pending_exit = transient.exit;
      record.pending_exit_at = transient.at;
    }
  }
}

const ExpectedNode* FaultDetector::expected(std::string_view node) const {
  const auto is_it = [&](const ExpectedNode& one) { return one.name == node; };
  const auto found = std::find_if(nodes_.begin(), nodes_.end(), is_it);
  return found == nodes_.end() ? nullptr : &*found;
}

const ExpectedNode* FaultDetector::agent_of(std::string_view host) const {
  const auto is_it = [&](const ExpectedNode& one) { return one.role == msg::NodeKind::NODE_AGENT && one.host == host; };
  const auto found = std::find_if(nodes_.begin(), nodes_.end(), is_it);
  return found == nodes_.end() ? nullptr : &*found;
}

const FaultDetector::NodeRecord* FaultDetector::find(std::string_view node) const {
  const auto found = records_.find(node);
  return found == records_.end() ? nullptr : &found->second;
}

bool FaultDetector::alive(std::string_view node) const {
  const NodeRecord* record = find(node);
  return record && !record->died && !record->stopped && liveness_.presence(node) == Presence::kAlive;
}

bool FaultDetector::ended(std::string_view node) const {
  const NodeRecord* record = find(node);
  return record && (record->died || record->stopped || liveness_.presence(node) == Presence::kMissing);
}

std::optional<Time> FaultDetector::silence(std::string_view node) const {
  if (!find(node) || !liveness_.last_heard(node)) return std::nullopt;
  return liveness_.silence(node);
}

std::string FaultDetector::in_charge(std::string_view arm) const {
  const auto found = in_charge_.find(arm);
  return found == in_charge_.end() || found->second.empty() ? planner_node(arm) : found->second;
}

bool FaultDetector::is_isolated(std::string_view node) const {
  const ExpectedNode* known = expected(node);
  return known && hosts_.state(*hosts_.index(known->host)) == HostState::kIsolated;
}

msg::Cause FaultDetector::awaited(std::string_view node) const {
  const NodeRecord* record = find(node);
  if (!record) return {};
  const std::string name(node);
  if (record->stopped) return make_cause(msg::CauseKind::CAUSE_NODE_STOPPED, name, name + " was ordered to end");
  if (const FaultRecord* fault = faults_.open(node)) return make_cause(fault->kind, fault->subject, fault->description);
  switch (liveness_.presence(node)) {
    case Presence::kWaiting:
    case Presence::kMissing:
      return make_cause(msg::CauseKind::CAUSE_NODE_MISSING, name, name + " has not appeared yet");
    case Presence::kSuspected:
    case Presence::kLost:
      return make_cause(msg::CauseKind::CAUSE_NODE_SILENT, name, name + " is silent");
    case Presence::kReturning:
    case Presence::kAlive:
      break;
  }
  if (!record->has_stream || liveness_.last_heard(stream_name(node))) return {};
  const bool world = name == world_node();
  return make_cause(world ? msg::CauseKind::CAUSE_WORLD_SILENT : msg::CauseKind::CAUSE_DRIVER_SILENT, name,
                    name + " has not sent any state yet");
}

DriverLoss FaultDetector::loss_of_driver(std::string_view arm) const {
  const ExpectedNode* driver = expected(driver_node(arm));
  if (!driver) return DriverLoss::kNone;
  const NodeRecord& record = *find(driver->name);
  if (record.died || record.stopped) return DriverLoss::kEnded;
  const HostIndex host = *hosts_.index(driver->host);
  const bool lost = hosts_.state(host) == HostState::kLost && *hosts_.silence(host) >= limits_.host_lease;
  return lost && hosts_.hears_most(limits_.node.silence) ? DriverLoss::kHostSilent : DriverLoss::kNone;
}

}  // namespace hecaton::services
