#include <algorithm>
#include <iterator>

#include "services/runtime/node_name.hpp"
#include "services/security/expiry.hpp"
#include "services/supervisor/detection/fault_detector.hpp"

// The judgement of the FaultDetector: rules 1 to 7 of docs/explanation/0003-fault-detection.md, and the holds that
// follow.

namespace hecaton::services {
namespace {

/// A node is duplicate when its heartbeats change between the same two processes this often without a pause. Late
/// heartbeats of a process that has ended change less often.
constexpr int kMinChanges = 6;

std::string milliseconds(Time time) {
  return std::to_string(std::chrono::duration_cast<std::chrono::milliseconds>(time).count()) + " ms";
}

bool silent(Presence presence) {
  return presence == Presence::kSuspected || presence == Presence::kLost;
}

msg::Severity silence_severity(Presence presence) {
  return presence == Presence::kSuspected ? msg::Severity::SEVERITY_WARNING : msg::Severity::SEVERITY_ERROR;
}

FaultObservation observe_death(const ExpectedNode& node, const ProcessExit& exit, Time silence) {
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
  judge_refusals(now);
  judge_keys(now);
  mode_.set_automatic(holds());
  hold_until_resumed();
}

// Heartbeats of the node that are overdue, at most as many as it may miss without being silent. When the whole host
// falls silent, its heartbeats are not lost by chance: 0.
int FaultDetector::overdue_heartbeats(const ExpectedNode& node) const {
  const HostIndex host = *hosts_.index(node.host);
  if (host == hosts_.own() || !liveness_.last_heard(node.name)) return 0;
  const Time silence = liveness_.silence(node.name);
  const Time period = limits_.heartbeat_period;
  const auto overdue = std::min((silence + period / 2) / period - 1, limits_.node.silence / period);
  if (overdue <= 0 || silence > limits_.host_lease || *hosts_.silence(host) >= period * 9 / 10) return 0;
  return static_cast<int>(overdue);
}

// Chance may lose several heartbeats in a row. The loss rate is estimated from the packets of all nodes.
void FaultDetector::allow_for_losses() {
  const auto longest_gap = [](double lost, Time period) {
    const int samples = PacketLossEstimator::longest_gap(lost);
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
    const int own = overdue_heartbeats(node);  // says nothing about the path
    const PacketLossEstimator::Overdue others{late[node.host] - own, all - own};
    // An agent is judged after a lease: that is long enough for the losses that have been counted.
    const double lost = losses_.lost(node.host, agent ? PacketLossEstimator::Overdue{} : others);
    const Time allowed = longest_gap(lost, limits_.heartbeat_period);
    liveness_.allow(node.name, allowed);
    if (agent) hosts_.allow(*hosts_.index(node.host), allowed);
    if (!find(node.name)->has_stream) continue;
    const Time period = node.role == msg::NodeKind::NODE_WORLD ? limits_.world_period : limits_.arm_period;
    liveness_.allow(stream_name(node.name), longest_gap(lost, period));
  }
}

// Rule 7, return. A node has returned from an absence of its host once it has been heard for `sure_return`.
void FaultDetector::note_returns() {
  for (const ExpectedNode& node : nodes_) {
    const auto away = hosts_.away(*hosts_.index(node.host));
    const auto steady = away ? liveness_.steady_since(node.name) : std::nullopt;
    if (!steady) continue;
    const Time heard_for = *liveness_.last_heard(node.name) - std::max(*steady, *away);
    if (heard_for >= limits_.sure_return) records_.find(node.name)->second.returned_from = away;
  }
}

void FaultDetector::raise(const std::string& key, const FaultObservation& observation, Time now) {
  // A better explanation of a fault that a person has resumed since needs no second resume.
  const FaultRecord* known = faults_.open(key);
  const bool waited = known && limits_.waits(known->kind);
  if (!faults_.raise(key, observation, now) || waited) return;
  const FaultRecord* record = faults_.open(key);
  raised_.emplace(record->opening_term, record->number);
}

// Rules 3 to 5: the state of each host is one fault; its nodes get none.
void FaultDetector::judge_hosts(Time now) {
  for (const ExpectedNode& agent : nodes_) {
    if (agent.role != msg::NodeKind::NODE_AGENT) continue;
    const HostIndex host = *hosts_.index(agent.host);
    const FaultRecord* open = faults_.open(agent.name);
    if (hosts_.state(host) != HostState::kHeard) {
      raise(agent.name, observe_host(host), now);
    } else if (open &&
               (open->kind == msg::CauseKind::CAUSE_HOST_LOST || open->kind == msg::CauseKind::CAUSE_HOST_ISOLATED)) {
      faults_.clear(agent.name, now);
    }
  }
}

FaultObservation FaultDetector::observe_host(HostIndex host) const {
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
    const std::string key = fault_key(msg::CauseKind::CAUSE_LINK_LOST, name);
    lost.insert(key);
    raise(key,
          {msg::CauseKind::CAUSE_LINK_LOST, own ? msg::Severity::SEVERITY_ERROR : msg::Severity::SEVERITY_WARNING, name,
           "link " + name + ": " + to + " has not heard " + from + " for " + milliseconds(limits_.host_lease)},
          now);
  }
  std::vector<std::string> open;
  for (const FaultRecord& record : faults_.open()) {
    if (record.kind == msg::CauseKind::CAUSE_LINK_LOST) open.push_back(fault_key(record.kind, record.subject));
  }
  for (const std::string& key : open) {
    if (!lost.contains(key)) faults_.clear(key, now);
  }
}

void FaultDetector::judge_nodes(Time now) {
  for (const ExpectedNode& node : nodes_) {
    NodeRecord& record = records_.find(node.name)->second;
    const auto exit = std::exchange(record.pending_exit, std::nullopt);
    const auto since = std::exchange(record.pending_exit_at, std::nullopt);
    auto death = exit ? std::optional(observe_death(node, *exit, record.silence_at_end)) : std::nullopt;
    if (death && since) death->since = since;
    if (death && !faults_.remembers(*death)) {
      Transient transient;
      transient.at = death->since.value_or(now);
      transient.node = node.name;
      transient.exit = *exit;
      remember_transient(std::move(transient));
      // A fault even if the successor was heard in the same instant; the next judgement then clears it.
      raise(node.name, *death, now);
      if (exit->at && is_healthy(node)) faults_.clear(node.name, now);  // long ago: it holds no arm
    } else if (const auto observation = observe_node(node)) {
      raise(node.name, *observation, now);
    } else if (is_healthy(node)) {
      faults_.clear(node.name, now);
    }
  }
}

// Independent of other faults of the node, so it has a key of its own.
void FaultDetector::judge_duplicates(Time now) {
  for (const ExpectedNode& node : nodes_) {
    NodeRecord& record = records_.find(node.name)->second;
    if (clock_.now() - record.changed_at > kDuplicate) record.changes = 0;
    const std::string key = node_fault_key(msg::CauseKind::CAUSE_DUPLICATE_NODE, node.name);
    if (record.changes < kMinChanges) {
      faults_.clear(key, now);
      continue;
    }
    const auto [one, other] = std::minmax(record.pid, record.previous_pid);
    faults_.raise(key,
                  {msg::CauseKind::CAUSE_DUPLICATE_NODE, msg::Severity::SEVERITY_ERROR, node.name,
                   node.name + ": processes " + std::to_string(one) + " and " + std::to_string(other) +
                       " are this node at one time: end one of them"},
                  now);
  }
}

// Lasts until an ArmState reports that the device works, also while the driver's process is gone.
void FaultDetector::judge_devices(Time now) {
  for (const ExpectedNode& node : nodes_) {
    if (node.role != msg::NodeKind::NODE_DRIVER) continue;
    const auto& reported = find(node.name)->device_fault;
    for (const msg::CauseKind kind : kDeviceFaults) {
      const std::string key = node_fault_key(kind, node.name);
      if (!reported || reported->kind() != kind) {
        faults_.clear(key, now);
        continue;
      }
      const bool failed = kind == msg::CauseKind::CAUSE_ARM_FAILED;
      raise(key,
            {kind, msg::Severity::SEVERITY_ERROR, node.arm,
             "arm " + node.arm + ": " + (failed ? "its device reports a failure: " : "") + reported->text()},
            now);
    }
  }
}

void FaultDetector::judge_contacts(Time now) {
  const std::string key = "contact";
  for (const FaultObservation& contact : std::exchange(contacts_.pending, {})) {
    Transient transient;
    transient.at = contact.since.value_or(now);
    transient.contact = contact;
    remember_transient(std::move(transient));
    faults_.raise(key, contact, now);
    faults_.clear(key, now);
    if (limits_.waits(msg::CauseKind::CAUSE_CONTACT))
      mode_.hold_until_resumed({},
                               make_cause(msg::CauseKind::CAUSE_HELD_BY_FAULT, contact.subject, contact.description));
  }
}

// A refused sender holds no arm: the node that refuses works on.
void FaultDetector::judge_refusals(Time now) {
  for (auto entry = refusals_.begin(); entry != refusals_.end();) {
    const bool over = clock_.now() - entry->second.heard > kRefusalLasts;
    if (over) {
      faults_.clear(entry->first, now);
    } else {
      faults_.raise(entry->first, entry->second.observation, now);
    }
    entry = over ? refusals_.erase(entry) : std::next(entry);
  }
}

// All identities of a host are made together, so they are one fault. Running processes keep the keys that they have
// read: the fault ends when the last of them runs with newer ones.
void FaultDetector::judge_keys(Time now) {
  std::map<std::string, std::optional<KeyExpiry>> hosts;  // that are heard, with the first of their keys to expire
  for (const ExpectedNode& node : nodes_) {
    const NodeRecord& record = records_.find(node.name)->second;
    if (record.heartbeat_at == Time(0) || record.stopped) continue;
    std::optional<KeyExpiry>& first = hosts[node.host];
    if (record.keys && (!first || record.keys->left < first->left)) first = record.keys;
  }
  for (const auto& [host, first] : hosts) {
    const std::string key = fault_key(msg::CauseKind::CAUSE_CERTIFICATE_EXPIRES, host);
    if (!first || first->left >= kExpiryLead) {
      faults_.clear(key, now);
      continue;
    }
    const bool expired = first->left <= Time(0);
    const msg::Severity severity = expired ? msg::Severity::SEVERITY_ERROR : msg::Severity::SEVERITY_WARNING;
    if (const FaultRecord* open = faults_.open(key); open && open->severity >= severity) continue;
    faults_.raise(
        key,
        {msg::CauseKind::CAUSE_CERTIFICATE_EXPIRES, severity, host,
         "host " + host + ": its keys " + (expired ? "have expired on " : "expire on ") + date_text(first->at) +
             "; make new ones with `hecaton keystore renew`, and restart its services"},
        now);
  }
}

std::optional<FaultObservation> FaultDetector::observe_node(const ExpectedNode& node) const {
  const NodeRecord& record = *find(node.name);
  if (record.died) return observe_death(node, *record.died, record.silence_at_end);
  if (record.stopped) return std::nullopt;
  if (record.failure) {
    const std::string& text = record.failure->text();
    const std::string own_words = text.empty() ? "it reports that it cannot do its work" : text;
    return FaultObservation{msg::CauseKind::CAUSE_NODE_FAILED, msg::Severity::SEVERITY_ERROR, node.name,
                            node.name + ": " + own_words, limits_.heartbeat_period};
  }
  const Presence presence = liveness_.presence(node.name);
  if (presence == Presence::kMissing) {
    const ExpectedNode* agent = agent_of(node.host);
    const bool explained = agent && agent->name != node.name && liveness_.presence(agent->name) == Presence::kMissing;
    if (explained) return std::nullopt;
    return FaultObservation{msg::CauseKind::CAUSE_NODE_MISSING, msg::Severity::SEVERITY_ERROR, node.name,
                            node.name + " did not appear within " + milliseconds(limits_.node.grace),
                            limits_.node.grace};
  }
  if (silent(presence)) return observe_silence(node, presence);
  return record.has_stream && presence == Presence::kAlive ? observe_stream(node) : std::nullopt;
}

// Rule 1, process. A node is silent when packets of its host have continued without its own for longer than its limit.
// So neither a broken link nor a lost host is a fault of a process. An agent may be silent for a lease, because it
// forks.
std::optional<FaultObservation> FaultDetector::observe_silence(const ExpectedNode& node, Presence presence) const {
  const bool agent = node.role == msg::NodeKind::NODE_AGENT;
  const LivenessLimits limits = liveness_.limits(node.name);
  const Time limit = presence == Presence::kLost ? limits.lost : limits.silence;
  if ((agent && presence != Presence::kLost) || is_explained(node) || !falls_behind(node, limit)) return std::nullopt;
  const Time own = agent ? limits_.host_lease : presence == Presence::kLost ? limits_.node.lost : limits_.node.silence;
  return FaultObservation{msg::CauseKind::CAUSE_NODE_SILENT,
                          agent ? msg::Severity::SEVERITY_WARNING : silence_severity(presence), node.name,
                          node.name + ": no heartbeat for more than " + milliseconds(limit) +
                              (limit > own ? ", while the network loses others" : ""),
                          liveness_.silence(node.name)};
}

// Rule 1 for the states of a driver or the world: heartbeats of the same loop have continued without them. When both
// end together the loop hangs, which is CAUSE_NODE_SILENT.
std::optional<FaultObservation> FaultDetector::observe_stream(const ExpectedNode& node) const {
  const bool world = node.role == msg::NodeKind::NODE_WORLD;
  const std::string stream = stream_name(node.name);
  const Presence presence = liveness_.presence(stream);
  const Time limit = liveness_.limits(stream).silence;
  if ((!silent(presence) && presence != Presence::kMissing) || is_explained(node)) return std::nullopt;
  const auto last = liveness_.last_heard(stream);
  if (last && *liveness_.last_heard(node.name) - *last <= limit) return std::nullopt;
  const std::string missing = world ? "no obstacle states" : "no arm state";
  return FaultObservation{world ? msg::CauseKind::CAUSE_WORLD_SILENT : msg::CauseKind::CAUSE_DRIVER_SILENT,
                          silence_severity(presence), world ? node.name : node.arm,
                          node.name + ": heartbeats, but " + missing + " for more than " + milliseconds(limit),
                          liveness_.silence(stream)};
}

bool FaultDetector::is_healthy(const ExpectedNode& node) const {
  const NodeRecord& record = *find(node.name);
  if (record.stopped) return true;
  if (record.failure) return false;
  const bool host_is_lost =
      node.role == msg::NodeKind::NODE_AGENT && hosts_.state(*hosts_.index(node.host)) != HostState::kHeard;
  return alive(node.name) && !host_is_lost &&
         (!record.has_stream || liveness_.presence(stream_name(node.name)) == Presence::kAlive);
}

// Without rows to compare with (the supervisor's own host, a host whose agent was never heard) the supervisor's clock
// decides: true.
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

// A fault of the host or of the link to it explains that its nodes are not heard.
bool FaultDetector::is_explained(const ExpectedNode& node) const {
  const HostIndex host = *hosts_.index(node.host);
  if (host == hosts_.own() || !hosts_.judged(host)) return false;
  return hosts_.isolated() || hosts_.state(host) != HostState::kHeard || hosts_.link_is_lost(host) ||
         is_returning(node);
}

bool FaultDetector::is_returning(const ExpectedNode& node) const {
  const auto away = hosts_.away(*hosts_.index(node.host));
  return away && find(node.name)->returned_from != away;
}

// A fault that waits for resume orders hold once for each arm that it holds, also if it holds the arm only later: a
// deaf host is heard at first. A resume is not ordered away again.
void FaultDetector::hold_until_resumed() {
  if (raised_.empty()) return;
  std::set<FaultKey> open;
  for (const FaultRecord& record : faults_.open()) open.emplace(record.opening_term, record.number);
  std::erase_if(raised_, [&](const FaultKey& key) { return !open.contains(key); });
  std::erase_if(ordered_, [&](const auto& order) { return !open.contains(order.first); });
  for (const ExpectedNode& node : nodes_) {
    const FaultRecord* fault = holds_arms(node) ? fault_holding(node) : nullptr;
    if (!fault || !limits_.waits(fault->kind)) continue;
    const FaultKey key{fault->opening_term, fault->number};
    const std::string arm = node.role == msg::NodeKind::NODE_WORLD ? std::string() : node.arm;
    if (raised_.contains(key) && ordered_.emplace(key, arm).second) mode_.hold_until_resumed(arm, held_by(*fault));
  }
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

// Arms work without agents, without the other supervisor and without their standby planner.
bool FaultDetector::holds_arms(const ExpectedNode& node) const {
  if (node.role == msg::NodeKind::NODE_PLANNER) return node.name == in_charge(node.arm);
  return node.role == msg::NodeKind::NODE_DRIVER || node.role == msg::NodeKind::NODE_WORLD;
}

const FaultRecord* FaultDetector::fault_holding(const ExpectedNode& node) const {
  if (const FaultRecord* fault = faults_.open(node.name)) return fault;
  for (const msg::CauseKind kind : kDeviceFaults) {
    if (const FaultRecord* fault = faults_.open(node_fault_key(kind, node.name))) return fault;
  }
  if (alive(node.name)) return nullptr;
  if (const ExpectedNode* agent = agent_of(node.host)) {
    if (const FaultRecord* fault = faults_.open(agent->name)) return fault;
  }
  if (!hosts_.own() || node.host == hosts_.name(*hosts_.own())) return nullptr;
  const std::string& own = hosts_.name(*hosts_.own());
  const std::string link = fault_key(msg::CauseKind::CAUSE_LINK_LOST, link_name(node.host, own));
  if (const FaultRecord* fault = faults_.open(link)) return fault;
  const ExpectedNode* own_agent = agent_of(own);
  return own_agent && hosts_.isolated() ? faults_.open(own_agent->name) : nullptr;
}

// A node that the supervisor does not hear may still hear the other nodes of its arm. The safe order is hold, also
// before the fault is attributed.
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
  if (is_explained(node) && !is_healthy(node)) return silent(node.name + " is not back yet");
  return std::nullopt;
}

}  // namespace hecaton::services
