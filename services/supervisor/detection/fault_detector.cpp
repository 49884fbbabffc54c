#include "services/supervisor/detection/fault_detector.hpp"

#include <algorithm>
#include <cstring>

#include "services/runtime/node_name.hpp"

namespace hecaton::services {
namespace {

/// Between a node and a fault that it may have beside its other one.
constexpr char kBeside = '#';
/// Two processes that both send heartbeats within this exist at one time.
constexpr Time kDuplicate = std::chrono::seconds(1);
/// Late samples of a process that has ended may come between the first of its successor, but not so often.
constexpr int kLateSamples = 6;
/// What came and went is kept for longer than any takeover takes.
constexpr Time kPassing = std::chrono::seconds(5);
/// By so much two supervisors may differ about when something was.
constexpr Time kSameTime = std::chrono::seconds(1);

std::string milliseconds(Time time) {
  return std::to_string(std::chrono::duration_cast<std::chrono::milliseconds>(time).count()) + " ms";
}

std::vector<std::string> hosts_of(const std::vector<ExpectedNode>& nodes) {
  std::set<std::string> hosts;
  for (const ExpectedNode& node : nodes) hosts.insert(node.host);
  return {hosts.begin(), hosts.end()};
}

/// Of its states, beside its heartbeats.
std::string stream_name(std::string_view node) {
  return std::string(node) + " stream";
}

bool silent(Presence presence) {
  return presence == Presence::kSuspected || presence == Presence::kLost;
}

msg::Severity silence_severity(Presence presence) {
  return presence == Presence::kSuspected ? msg::Severity::SEVERITY_WARNING : msg::Severity::SEVERITY_ERROR;
}

FaultSight death_sight(const ExpectedNode& node, const ProcessExit& exit, Time silence) {
  const auto within = exit.at ? std::nullopt : std::optional(silence);
  return {msg::CauseKind::CAUSE_PROCESS_DIED,
          msg::Severity::SEVERITY_ERROR,
          node.name,
          node.name + ": " + end_text(exit),
          within,
          exit.at};
}

/// "north-pc<->west-pc": the same for both directions.
std::string link_name(const std::string& one, const std::string& other) {
  return std::min(one, other) + "<->" + std::max(one, other);
}

}  // namespace

HostLimits DetectionLimits::hosts() const {
  HostLimits hosts;
  hosts.lease = host_lease;
  hosts.link_deadline = host_lease * 3 / 5;
  hosts.recent_row = host_lease / 4;
  // A node beats a little before its host falls silent, and a little after it is heard again.
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

std::string cause_of(msg::CauseKind kind, const std::string& node) {
  const bool beside = kind == msg::CauseKind::CAUSE_DUPLICATE_NODE ||
                      kind == msg::CauseKind::CAUSE_PERSISTENCE_FAILED || kind == msg::CauseKind::CAUSE_ARM_FAILED;
  return beside ? node + kBeside + std::string(cause_name(kind)) : node;
}

std::string cause_of_subject(msg::CauseKind kind, const std::string& subject) {
  switch (kind) {
    case msg::CauseKind::CAUSE_DRIVER_SILENT:
    case msg::CauseKind::CAUSE_ARM_FAILED:
      return cause_of(kind, driver_node(subject));
    case msg::CauseKind::CAUSE_HOST_LOST:
    case msg::CauseKind::CAUSE_HOST_ISOLATED:
      return agent_node(subject);
    case msg::CauseKind::CAUSE_LINK_LOST:
      return "link " + subject;
    default:
      return cause_of(kind, subject);
  }
}

std::string end_text(const ProcessExit& exit) {
  const std::string process = "process " + std::to_string(exit.pid);
  if (!is_none(exit.cause)) return "its agent ended " + process + ": " + exit.cause.text();
  if (exit.signal_number == 0) return process + " ended with exit code " + std::to_string(exit.exit_code);
  const char* name = strsignal(exit.signal_number);
  return process + " was ended by signal " + std::to_string(exit.signal_number) +
         (name ? " (" + std::string(name) + ")" : std::string());
}

FaultDetector::FaultDetector(std::vector<ExpectedNode> nodes, std::vector<std::string> arms,
                             const DetectionLimits& limits, Time now, const std::string& host)
    : limits_(limits),
      nodes_(std::move(nodes)),
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
    State& state = states_[node.name];
    state.has_stream = node.role == msg::NodeKind::NODE_DRIVER || node.role == msg::NodeKind::NODE_WORLD;
    if (!state.has_stream) continue;
    LivenessLimits stream = limits_.node;
    stream.silence = node.role == msg::NodeKind::NODE_DRIVER ? limits_.arm_stream : limits_.world_stream;
    stream.lost = std::max(stream.lost, stream.silence);
    liveness_.expect(stream_name(node.name), stream);
    losses_.expect(stream_name(node.name), node.host);
  }
}

void FaultDetector::advance(Time now) {
  stalled_ = clock_.advance(now);
}

void FaultDetector::heard(std::string_view node, const Heartbeat& heartbeat) {
  const ExpectedNode* known = expected(node);
  if (!known) return;
  State& state = states_.find(node)->second;
  hosts_.heard(*hosts_.index(known->host), clock_.at(heartbeat.at), known->role == msg::NodeKind::NODE_AGENT);
  losses_.arrived(node, heartbeat.pid, heartbeat.number);
  const std::int64_t pid = heartbeat.pid;
  const bool late = (state.died && state.died->pid == pid) || (state.stopped && state.pid == pid);
  if (late) return;  // written before its process ended
  note_process(state, pid);
  const bool replaced = state.pid != 0 && state.pid != pid && !state.died && !state.stopped;
  if (replaced) state.untold_pid = state.pid;
  state.died.reset();
  state.stopped = false;
  state.pid = pid;
  state.failure = heartbeat.failure;
  liveness_.heard(node, heartbeat.at);
}

void FaultDetector::stream_heard(std::string_view node, Time at, std::uint64_t number) {
  const State* state = find(node);
  if (!state || !state->has_stream || state->died || state->stopped) return;
  // No sign of life of a process that has sent no heartbeat: an earlier one may have left it on the wire.
  if (liveness_.last_heard(node)) {
    liveness_.heard(node, at);
    hosts_.heard(*hosts_.index(expected(node)->host), clock_.at(at), false);
  }
  const std::string stream = stream_name(node);
  liveness_.heard(stream, at);
  losses_.arrived(stream, state->pid, number);
}

void FaultDetector::row_heard(std::string_view host, const std::vector<HostAge>& ages, Time at) {
  const auto index = hosts_.index(host);
  const ExpectedNode* agent = agent_of(host);
  if (!index || !agent) return;
  hosts_.row(*index, ages, clock_.at(at));
  if (liveness_.last_heard(agent->name)) liveness_.heard(agent->name, at);
}

void FaultDetector::device_heard(std::string_view arm, std::optional<std::string> failure) {
  const auto found = states_.find(driver_node(arm));
  if (found != states_.end()) found->second.device_failure = std::move(failure);
}

void FaultDetector::process_started(std::string_view node, std::int64_t pid) {
  const auto found = states_.find(node);
  if (found == states_.end()) return;
  State& state = found->second;
  if (state.pid == pid) return;  // its heartbeat came first
  State started;
  started.pid = pid;
  started.has_stream = state.has_stream;
  started.unjudged = state.unjudged;
  started.silence_at_end = state.silence_at_end;
  started.device_failure = std::move(state.device_failure);
  state = std::move(started);
  liveness_.restarted(node);
  if (state.has_stream) liveness_.restarted(stream_name(node));
}

void FaultDetector::process_exited(std::string_view node, const ProcessExit& exit, bool news) {
  const auto found = states_.find(node);
  if (found == states_.end()) return;
  State& state = found->second;
  const bool replaced = state.pid != 0 && state.pid != exit.pid && !state.died;
  if (replaced && liveness_.presence(node) == Presence::kAlive) {
    // History: its successor is here. Where the agent was not heard when it ended, it has not been told yet.
    const bool untold = news && !exit.wanted && std::exchange(state.untold_pid, 0) == exit.pid;
    if (untold) state.unjudged = exit;
    return;
  }
  state.pid = exit.pid;
  state.stopped = exit.wanted;
  state.died = exit.wanted ? std::nullopt : std::optional(exit);
  state.unjudged = news ? state.died : std::nullopt;
  state.silence_at_end = liveness_.silence(node);
  liveness_.restarted(node);
  if (state.has_stream) liveness_.restarted(stream_name(node));
}

void FaultDetector::contacts(std::uint64_t count, const std::string& subject, const std::string& seen) {
  const bool first = !std::exchange(contacts_.known, true);
  if (first && faults_.knows(msg::CauseKind::CAUSE_CONTACT)) contacts_.count = count;
  if (count > contacts_.count) {
    contacts_.untold.push_back({msg::CauseKind::CAUSE_CONTACT, msg::Severity::SEVERITY_CRITICAL, subject, seen});
  }
  contacts_.count = count;
}

void FaultDetector::adopt(const std::string& cause, const FaultRecord& record, Time now) {
  faults_.adopt(cause, record, now);
  const bool judged = record.kind == msg::CauseKind::CAUSE_LINK_LOST ||
                      (record.kind != msg::CauseKind::CAUSE_PERSISTENCE_FAILED &&
                       expects(std::string_view(cause).substr(0, cause.find(kBeside))));
  if (!judged) faults_.clear(cause, now);
}

void FaultDetector::note_process(State& state, std::int64_t pid) const {
  const Time now = clock_.now();
  if (now - state.heartbeat_at > kDuplicate) state.returns = 0;
  if (state.pid != 0 && state.pid != pid) {
    state.returns = state.former_pid == pid ? state.returns + 1 : 0;
    state.former_pid = state.pid;
    state.returned_at = now;
  }
  state.heartbeat_at = now;
}

void FaultDetector::note_passing(Passing passing) {
  while (!passing_.empty() && passing_.front().at < passing.at - kPassing) passing_.pop_front();
  passing_.push_back(std::move(passing));
}

// Deaths that the list has are left out when they are judged.
void FaultDetector::judge_again(Time since) {
  for (const Passing& passing : passing_) {
    if (passing.at < since) continue;
    if (passing.node.empty()) {
      if (faults_.knows(passing.contact, passing.at - kSameTime)) continue;
      contacts_.untold.push_back(passing.contact);
      contacts_.untold.back().since = passing.at;
    } else {
      State& state = states_.find(passing.node)->second;
      state.unjudged = passing.exit;
      state.unjudged_since = passing.at;
    }
  }
}

void FaultDetector::judge(Time now) {
  allow_for_losses();
  liveness_.judge(stalled_);
  hosts_.judge(stalled_ ? clock_.last_stall() : Time(0));
  note_returns();
  judge_hosts(now);
  judge_links(now);
  judge_nodes(now);
  judge_duplicates(now);
  judge_devices(now);
  judge_contacts(now);
  mode_.set_automatic(holds());
  hold_until_resumed();
}

// At most as many as a node may be late without being silent. When a host is lost, all of its heartbeats are late.
int FaultDetector::overdue_heartbeats(const ExpectedNode& node) const {
  const HostIndex host = *hosts_.index(node.host);
  if (host == hosts_.own() || !liveness_.last_heard(node.name)) return 0;
  const Time silence = liveness_.silence(node.name);
  const Time period = limits_.heartbeat_period;
  const auto overdue = std::min((silence + period / 2) / period - 1, limits_.node.silence / period);
  if (overdue <= 0 || silence > limits_.host_lease || *hosts_.silence(host) >= period * 9 / 10) return 0;
  return static_cast<int>(overdue);
}

// A node may be silent for as long as chance loses its packets, estimated from the packets of all nodes.
void FaultDetector::allow_for_losses() {
  const auto longest_row = [](double lost, Time period) {
    const int samples = PacketLossEstimator::longest_row(lost);
    return samples == 0 ? Time(0) : (samples + 1) * period + period / 2;
  };
  std::map<std::string_view, int> late;  // by host
  int all = 0;
  for (const ExpectedNode& node : nodes_) {
    const int overdue = overdue_heartbeats(node);
    late[node.host] += overdue;
    all += overdue;
  }
  for (const ExpectedNode& node : nodes_) {
    const bool agent = node.role == msg::NodeKind::NODE_AGENT;
    const int own = overdue_heartbeats(node);  // tells nothing of the way
    const PacketLossEstimator::Late others{late[node.host] - own, all - own};
    // A lease is long enough to go by the losses that are known.
    const double lost = losses_.lost(node.host, agent ? PacketLossEstimator::Late{} : others);
    const Time allowed = longest_row(lost, limits_.heartbeat_period);
    liveness_.allow(node.name, allowed);
    if (agent) hosts_.allow(*hosts_.index(node.host), allowed);
    if (!find(node.name)->has_stream) continue;
    const Time period = node.role == msg::NodeKind::NODE_WORLD ? limits_.world_period : limits_.arm_period;
    liveness_.allow(stream_name(node.name), longest_row(lost, period));
  }
}

// Rule 7, return. A node has returned from the absence of its host once it has been heard for `sure_return`.
void FaultDetector::note_returns() {
  for (const ExpectedNode& node : nodes_) {
    const auto away = hosts_.away(*hosts_.index(node.host));
    const auto steady = away ? liveness_.steady_since(node.name) : std::nullopt;
    if (!steady) continue;
    const Time heard_for = *liveness_.last_heard(node.name) - std::max(*steady, *away);
    if (heard_for >= limits_.sure_return) states_.find(node.name)->second.back = away;
  }
}

void FaultDetector::raise(const std::string& cause, const FaultSight& sight, Time now) {
  // A person who has resumed since need not do so again when the same fault is explained better.
  const FaultRecord* known = faults_.open(cause);
  const bool waited = known && limits_.waits(known->kind);
  if (!faults_.raise(cause, sight, now) || waited) return;
  const FaultRecord* record = faults_.open(cause);
  raised_.emplace(record->life, record->number);
}

// Rules 3 to 5: the state of each host is one fault, and its nodes are not blamed.
void FaultDetector::judge_hosts(Time now) {
  for (const ExpectedNode& agent : nodes_) {
    if (agent.role != msg::NodeKind::NODE_AGENT) continue;
    const HostIndex host = *hosts_.index(agent.host);
    const FaultRecord* open = faults_.open(agent.name);
    if (hosts_.state(host) != HostState::kHeard) {
      raise(agent.name, host_sight(host), now);
    } else if (open &&
               (open->kind == msg::CauseKind::CAUSE_HOST_LOST || open->kind == msg::CauseKind::CAUSE_HOST_ISOLATED)) {
      faults_.clear(agent.name, now);
    }
  }
}

FaultSight FaultDetector::host_sight(HostIndex host) const {
  const std::string& name = hosts_.name(host);
  const std::string lease = milliseconds(limits_.host_lease);
  if (hosts_.state(host) == HostState::kLost) {
    return {msg::CauseKind::CAUSE_HOST_LOST, msg::Severity::SEVERITY_ERROR, name,
            "host " + name + ": no host has heard it for " + lease, hosts_.silence(host)};
  }
  const bool own = host == hosts_.own();
  return {
      msg::CauseKind::CAUSE_HOST_ISOLATED, msg::Severity::SEVERITY_ERROR, name,
      "host " + name +
          (own ? ": it hears no other host, or no other host hears it, for " : ": it has heard no other host for ") +
          lease};
}

// Rules 2 and 6.
void FaultDetector::judge_links(Time now) {
  std::set<std::string> lost;
  for (const HostMonitor::Link& link : hosts_.lost_links()) {
    const std::string& from = hosts_.name(link.subject);
    const std::string& to = hosts_.name(link.observer);
    const bool own = link.subject == hosts_.own() || link.observer == hosts_.own();
    const std::string name = link_name(from, to);
    const std::string cause = cause_of_subject(msg::CauseKind::CAUSE_LINK_LOST, name);
    lost.insert(cause);
    raise(cause,
          {msg::CauseKind::CAUSE_LINK_LOST, own ? msg::Severity::SEVERITY_ERROR : msg::Severity::SEVERITY_WARNING, name,
           "link " + name + ": " + to + " has not heard " + from + " for " + milliseconds(limits_.host_lease)},
          now);
  }
  std::vector<std::string> over;
  for (const FaultRecord& record : faults_.open()) {
    if (record.kind == msg::CauseKind::CAUSE_LINK_LOST) over.push_back(cause_of_subject(record.kind, record.subject));
  }
  for (const std::string& cause : over) {
    if (!lost.contains(cause)) faults_.clear(cause, now);
  }
}

void FaultDetector::judge_nodes(Time now) {
  for (const ExpectedNode& node : nodes_) {
    State& state = states_.find(node.name)->second;
    const auto exit = std::exchange(state.unjudged, std::nullopt);
    const auto since = std::exchange(state.unjudged_since, std::nullopt);
    auto death = exit ? std::optional(death_sight(node, *exit, state.silence_at_end)) : std::nullopt;
    if (death && since) death->since = since;
    if (death && !faults_.knows(*death)) {
      Passing passing;
      passing.at = death->since.value_or(now);
      passing.node = node.name;
      passing.exit = *exit;
      note_passing(std::move(passing));
      // Told even when its successor was heard in the same instant; the next judgement ends it then.
      raise(node.name, *death, now);
      if (exit->at && sound(node)) faults_.clear(node.name, now);  // of long ago: it holds no arm
    } else if (const auto seen = sight(node)) {
      raise(node.name, *seen, now);
    } else if (sound(node)) {
      faults_.clear(node.name, now);
    }
  }
}

// Beside what else may be wrong with the node, so a cause of its own.
void FaultDetector::judge_duplicates(Time now) {
  for (const ExpectedNode& node : nodes_) {
    State& state = states_.find(node.name)->second;
    if (clock_.now() - state.returned_at > kDuplicate) state.returns = 0;
    const std::string cause = cause_of(msg::CauseKind::CAUSE_DUPLICATE_NODE, node.name);
    if (state.returns < kLateSamples) {
      faults_.clear(cause, now);
      continue;
    }
    const auto [one, other] = std::minmax(state.pid, state.former_pid);
    faults_.raise(cause,
                  {msg::CauseKind::CAUSE_DUPLICATE_NODE, msg::Severity::SEVERITY_ERROR, node.name,
                   node.name + ": processes " + std::to_string(one) + " and " + std::to_string(other) +
                       " are this node at one time: end one of them"},
                  now);
  }
}

// It lasts until an ArmState says otherwise, also while the driver's process is gone.
void FaultDetector::judge_devices(Time now) {
  for (const ExpectedNode& node : nodes_) {
    if (node.role != msg::NodeKind::NODE_DRIVER) continue;
    const auto& failure = find(node.name)->device_failure;
    const std::string cause = cause_of(msg::CauseKind::CAUSE_ARM_FAILED, node.name);
    if (!failure) {
      faults_.clear(cause, now);
      continue;
    }
    raise(cause,
          {msg::CauseKind::CAUSE_ARM_FAILED, msg::Severity::SEVERITY_ERROR, node.arm,
           "arm " + node.arm + ": its device reports a failure" + (failure->empty() ? "" : ": " + *failure)},
          now);
  }
}

void FaultDetector::judge_contacts(Time now) {
  const std::string cause = "contact";  // of no node
  for (const FaultSight& contact : std::exchange(contacts_.untold, {})) {
    Passing passing;
    passing.at = contact.since.value_or(now);
    passing.contact = contact;
    note_passing(std::move(passing));
    faults_.raise(cause, contact, now);
    faults_.clear(cause, now);
    if (limits_.waits(msg::CauseKind::CAUSE_CONTACT))
      mode_.hold_until_resumed({}, make_cause(msg::CauseKind::CAUSE_HELD_BY_FAULT, contact.subject, contact.seen));
  }
}

// A fault gives the order once to each arm that it holds, also when it holds the arm only later: a deaf host is heard
// at first. A person who has resumed need not do so again.
void FaultDetector::hold_until_resumed() {
  if (raised_.empty()) return;
  std::set<FaultKey> open;
  for (const FaultRecord& record : faults_.open()) open.emplace(record.life, record.number);
  std::erase_if(raised_, [&](const FaultKey& key) { return !open.contains(key); });
  std::erase_if(ordered_, [&](const auto& order) { return !open.contains(order.first); });
  for (const ExpectedNode& node : nodes_) {
    const FaultRecord* fault = holds_arms(node) ? fault_holding(node) : nullptr;
    if (!fault || !limits_.waits(fault->kind)) continue;
    const FaultKey key{fault->life, fault->number};
    const std::string arm = node.role == msg::NodeKind::NODE_WORLD ? std::string() : node.arm;
    if (raised_.contains(key) && ordered_.emplace(key, arm).second) mode_.hold_until_resumed(arm, held_by(*fault));
  }
}

std::optional<FaultSight> FaultDetector::sight(const ExpectedNode& node) const {
  const State& state = *find(node.name);
  if (state.died) return death_sight(node, *state.died, state.silence_at_end);
  if (state.stopped) return std::nullopt;
  if (state.failure) {
    const std::string& text = state.failure->text();
    const std::string own_words = text.empty() ? "it reports that it cannot do its work" : text;
    return FaultSight{msg::CauseKind::CAUSE_NODE_FAILED, msg::Severity::SEVERITY_ERROR, node.name,
                      node.name + ": " + own_words, limits_.heartbeat_period};
  }
  const Presence presence = liveness_.presence(node.name);
  if (presence == Presence::kMissing) {
    const ExpectedNode* agent = agent_of(node.host);
    const bool explained = agent && agent->name != node.name && liveness_.presence(agent->name) == Presence::kMissing;
    if (explained) return std::nullopt;
    return FaultSight{msg::CauseKind::CAUSE_NODE_MISSING, msg::Severity::SEVERITY_ERROR, node.name,
                      node.name + " did not appear within " + milliseconds(limits_.node.grace), limits_.node.grace};
  }
  if (silent(presence)) return silence_sight(node, presence);
  return state.has_stream && presence == Presence::kAlive ? stream_sight(node) : std::nullopt;
}

// Rule 1, process. A node is silent when the packets of its host have gone on without its own for longer than its
// limit. So neither a broken link nor a lost host blames a process. (Agents that fork need longer: a lease.)
std::optional<FaultSight> FaultDetector::silence_sight(const ExpectedNode& node, Presence presence) const {
  const bool agent = node.role == msg::NodeKind::NODE_AGENT;
  const LivenessLimits limits = liveness_.limits(node.name);
  const Time limit = presence == Presence::kLost ? limits.lost : limits.silence;
  if ((agent && presence != Presence::kLost) || is_excused(node) || !falls_behind(node, limit)) return std::nullopt;
  const Time own = agent ? limits_.host_lease : presence == Presence::kLost ? limits_.node.lost : limits_.node.silence;
  return FaultSight{msg::CauseKind::CAUSE_NODE_SILENT,
                    agent ? msg::Severity::SEVERITY_WARNING : silence_severity(presence), node.name,
                    node.name + ": no heartbeat for more than " + milliseconds(limit) +
                        (limit > own ? ", while the network loses others" : ""),
                    liveness_.silence(node.name)};
}

// Rule 1 for the states of a driver or the world: heartbeats of the same loop have gone on without them. When both end
// together the loop hangs, which is the other fault.
std::optional<FaultSight> FaultDetector::stream_sight(const ExpectedNode& node) const {
  const bool world = node.role == msg::NodeKind::NODE_WORLD;
  const std::string stream = stream_name(node.name);
  const Presence presence = liveness_.presence(stream);
  const Time limit = liveness_.limits(stream).silence;
  if ((!silent(presence) && presence != Presence::kMissing) || is_excused(node)) return std::nullopt;
  const auto last = liveness_.last_heard(stream);
  if (last && *liveness_.last_heard(node.name) - *last <= limit) return std::nullopt;
  const std::string missing = world ? "no obstacle states" : "no arm state";
  return FaultSight{world ? msg::CauseKind::CAUSE_WORLD_SILENT : msg::CauseKind::CAUSE_DRIVER_SILENT,
                    silence_severity(presence), world ? node.name : node.arm,
                    node.name + ": heartbeats, but " + missing + " for more than " + milliseconds(limit),
                    liveness_.silence(stream)};
}

// The supervisor's own host, and one whose agent was never heard, are measured on the supervisor's clock.
bool FaultDetector::falls_behind(const ExpectedNode& node, Time limit) const {
  const HostIndex host = *hosts_.index(node.host);
  if (host == hosts_.own() || !hosts_.judged(host)) return true;
  std::optional<Time> newest;  // of its other processes
  for (const ExpectedNode& other : nodes_) {
    if (other.host != node.host || other.name == node.name) continue;
    newest = std::max(newest, liveness_.last_heard(other.name));
  }
  return newest && *newest - *liveness_.last_heard(node.name) > limit &&
         *newest - hosts_.returned(host) >= limits_.hosts().settling;
}

// What is wrong with the host or with the link to it explains whatever is not heard of its nodes.
bool FaultDetector::is_excused(const ExpectedNode& node) const {
  const HostIndex host = *hosts_.index(node.host);
  if (host == hosts_.own() || !hosts_.judged(host)) return false;
  return hosts_.isolated() || hosts_.state(host) != HostState::kHeard || hosts_.link_is_lost(host) || returns(node);
}

bool FaultDetector::returns(const ExpectedNode& node) const {
  const auto away = hosts_.away(*hosts_.index(node.host));
  return away && find(node.name)->back != away;
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

const FaultDetector::State* FaultDetector::find(std::string_view node) const {
  const auto found = states_.find(node);
  return found == states_.end() ? nullptr : &found->second;
}

bool FaultDetector::alive(std::string_view node) const {
  const State* state = find(node);
  return state && !state->died && !state->stopped && liveness_.presence(node) == Presence::kAlive;
}

bool FaultDetector::ended(std::string_view node) const {
  const State* state = find(node);
  return state && (state->died || state->stopped || liveness_.presence(node) == Presence::kMissing);
}

std::optional<Time> FaultDetector::silence(std::string_view node) const {
  if (!find(node) || !liveness_.last_heard(node)) return std::nullopt;
  return liveness_.silence(node);
}

std::string FaultDetector::in_charge(std::string_view arm) const {
  const auto found = in_charge_.find(arm);
  return found == in_charge_.end() || found->second.empty() ? planner_node(arm) : found->second;
}

// No fault of the node itself is left, nor, of an agent, of its host.
bool FaultDetector::sound(const ExpectedNode& node) const {
  const State& state = *find(node.name);
  if (state.stopped) return true;
  if (state.failure) return false;
  const bool host_is_lost =
      node.role == msg::NodeKind::NODE_AGENT && hosts_.state(*hosts_.index(node.host)) != HostState::kHeard;
  return alive(node.name) && !host_is_lost &&
         (!state.has_stream || liveness_.presence(stream_name(node.name)) == Presence::kAlive);
}

bool FaultDetector::is_isolated(std::string_view node) const {
  const ExpectedNode* known = expected(node);
  return known && hosts_.state(*hosts_.index(known->host)) == HostState::kIsolated;
}

msg::Cause FaultDetector::awaited(std::string_view node) const {
  const State* state = find(node);
  if (!state) return {};
  const std::string name(node);
  if (state->stopped) return make_cause(msg::CauseKind::CAUSE_NODE_STOPPED, name, name + " was ordered to end");
  if (const FaultRecord* fault = faults_.open(node)) return make_cause(fault->kind, fault->subject, fault->seen);
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
  if (!state->has_stream || liveness_.last_heard(stream_name(node))) return {};
  const bool world = name == world_node();
  return make_cause(world ? msg::CauseKind::CAUSE_WORLD_SILENT : msg::CauseKind::CAUSE_DRIVER_SILENT, name,
                    name + " has not sent any state yet");
}

Loss FaultDetector::loss_of(std::string_view arm) const {
  const ExpectedNode* driver = expected(driver_node(arm));
  if (!driver) return Loss::kNone;
  const State& state = *find(driver->name);
  if (state.died || state.stopped) return Loss::kEnded;
  const HostIndex host = *hosts_.index(driver->host);
  const bool lost = hosts_.state(host) == HostState::kLost && *hosts_.silence(host) >= limits_.host_lease;
  return lost && hosts_.hears_most(limits_.node.silence) ? Loss::kHostSilent : Loss::kNone;
}

// The fault that makes the node unable to serve its arm; null: none.
const FaultRecord* FaultDetector::fault_holding(const ExpectedNode& node) const {
  if (const FaultRecord* fault = faults_.open(node.name)) return fault;
  if (const FaultRecord* fault = faults_.open(cause_of(msg::CauseKind::CAUSE_ARM_FAILED, node.name))) return fault;
  if (alive(node.name)) return nullptr;
  if (const ExpectedNode* agent = agent_of(node.host)) {
    if (const FaultRecord* fault = faults_.open(agent->name)) return fault;
  }
  if (!hosts_.own() || node.host == hosts_.name(*hosts_.own())) return nullptr;
  const std::string& own = hosts_.name(*hosts_.own());
  const std::string link = cause_of_subject(msg::CauseKind::CAUSE_LINK_LOST, link_name(node.host, own));
  if (const FaultRecord* fault = faults_.open(link)) return fault;
  const ExpectedNode* own_agent = agent_of(own);
  return own_agent && hosts_.isolated() ? faults_.open(own_agent->name) : nullptr;
}

// A node that is not heard may itself hear its planner or driver: the safe order is hold, also before it is known whose
// fault it is.
std::optional<msg::Cause> FaultDetector::hold_cause(const ExpectedNode& node) const {
  if (const FaultRecord* fault = fault_holding(node)) return held_by(*fault);
  if (!liveness_.last_heard(node.name)) return std::nullopt;
  const auto silent = [&](const std::string& text) {
    return make_cause(msg::CauseKind::CAUSE_NODE_SILENT, node.name, text);
  };
  const auto silence = hosts_.silence(*hosts_.index(node.host));
  if (!alive(node.name) && silence && *silence >= limits_.node.silence) {
    return silent("nothing is heard of host " + node.host);
  }
  if (is_excused(node) && !sound(node)) return silent(node.name + " is not back yet");
  return std::nullopt;
}

// Everything works without agents and without the other supervisor, an arm without its standby planner.
bool FaultDetector::holds_arms(const ExpectedNode& node) const {
  if (node.role == msg::NodeKind::NODE_PLANNER) return node.name == in_charge(node.arm);
  return node.role == msg::NodeKind::NODE_DRIVER || node.role == msg::NodeKind::NODE_WORLD;
}

AutomaticHolds FaultDetector::holds() const {
  AutomaticHolds holds;
  for (const ExpectedNode& node : nodes_) {
    if (!holds_arms(node)) continue;
    auto cause = hold_cause(node);
    if (!cause) continue;
    if (node.role != msg::NodeKind::NODE_WORLD) {
      holds.arms.try_emplace(node.arm, *std::move(cause));
    } else if (!holds.cell) {
      holds.cell = std::move(cause);
    }
  }
  return holds;
}

}  // namespace hecaton::services
