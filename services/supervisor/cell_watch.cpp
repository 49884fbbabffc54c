#include "services/supervisor/cell_watch.hpp"

#include <algorithm>
#include <cstring>
#include <set>
#include <utility>

#include "services/runtime/node_name.hpp"

namespace hecaton::services {
namespace {

std::string milliseconds(Time time) {
  return std::to_string(std::chrono::duration_cast<std::chrono::milliseconds>(time).count()) + " ms";
}

/// Between a node and what may be wrong with it beside its not being well.
constexpr char kBeside = '#';
/// Two processes that both beat within this are there at one time.
constexpr Time kTwins = std::chrono::seconds(1);
/// Longer than anybody needs to take over, and than clocks of hosts differ: what came and went is kept so long.
constexpr Time kPassing = std::chrono::seconds(5);
/// By so much two supervisors may differ about when something was.
constexpr Time kSameTime = std::chrono::seconds(1);
/// So often the beats of one come after those of another only when both are alive.
constexpr int kStragglers = 6;

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

}  // namespace

std::string cause_of(msg::CauseKind kind, const std::string& node) {
  const bool beside = kind == msg::CauseKind::CAUSE_DUPLICATE_NODE || kind == msg::CauseKind::CAUSE_PERSISTENCE_FAILED;
  return beside ? node + kBeside + std::string(cause_name(kind)) : node;
}

std::string end_text(const ProcessExit& exit) {
  const std::string process = "process " + std::to_string(exit.pid);
  if (!is_none(exit.cause)) return "its agent ended " + process + ": " + exit.cause.text();
  if (exit.signal_number == 0) return process + " ended with exit code " + std::to_string(exit.exit_code);
  const char* name = strsignal(exit.signal_number);
  return process + " was ended by signal " + std::to_string(exit.signal_number) +
         (name ? " (" + std::string(name) + ")" : std::string());
}

CellWatch::CellWatch(std::vector<ExpectedNode> nodes, std::vector<std::string> arms, const WatchLimits& limits,
                     Time now, std::string host)
    : limits_(limits),
      nodes_(std::move(nodes)),
      clock_(limits.loop_period, limits.loop_limit, now),
      liveness_(clock_),
      hosts_(nodes_, limits_, clock_, liveness_, host),
      reception_(clock_, std::move(host)),
      mode_(std::move(arms)) {
  for (const ExpectedNode& node : nodes_) {
    LivenessLimits own = limits_.node;
    if (node.role == msg::NodeKind::NODE_AGENT) own.lost = limits_.host_lease;
    liveness_.expect(node.name, own);
    reception_.expect(node.name, node.host);
    State& state = states_[node.name];
    state.has_stream = node.role == msg::NodeKind::NODE_DRIVER || node.role == msg::NodeKind::NODE_WORLD;
    if (!state.has_stream) continue;
    LivenessLimits stream = limits_.node;
    stream.silence = node.role == msg::NodeKind::NODE_DRIVER ? limits_.arm_stream : limits_.world_stream;
    stream.lost = std::max(stream.lost, stream.silence);
    liveness_.expect(stream_name(node.name), stream);
    reception_.expect(stream_name(node.name), node.host);
  }
}

void CellWatch::advance(Time now) {
  stalled_ = clock_.advance(now);
}

void CellWatch::heard(std::string_view node, const Beat& beat) {
  const auto found = states_.find(node);
  if (found == states_.end()) return;
  State& state = found->second;
  reception_.arrived(node, beat.pid, beat.number);
  if (beat.heard.term > 0) hosts_.heard_mode(expected(node)->host, beat.heard);
  const std::int64_t pid = beat.pid;
  const bool late = (state.died && state.died->pid == pid) || (state.stopped && state.pid == pid);
  if (late) return;  // written before its process ended
  note_process(state, pid);
  const bool replaced = state.pid != 0 && state.pid != pid && !state.died && !state.stopped;
  if (replaced) state.untold_pid = state.pid;
  state.died.reset();
  state.stopped = false;
  state.pid = pid;
  state.failure = beat.failure;
  liveness_.heard(node, beat.at);
}

void CellWatch::stream_heard(std::string_view node, Time at, std::uint64_t number) {
  const State* state = find(node);
  if (!state || !state->has_stream || state->died || state->stopped) return;
  // No sign of life of a process that has not introduced itself: it may be what an earlier one left on the wire.
  if (liveness_.last_heard(node)) liveness_.heard(node, at);
  const std::string stream = stream_name(node);
  liveness_.heard(stream, at);
  reception_.arrived(stream, state->pid, number);
}

void CellWatch::process_started(std::string_view node, std::int64_t pid) {
  const auto found = states_.find(node);
  if (found == states_.end()) return;
  State& state = found->second;
  if (state.pid == pid) return;  // its heartbeat came first
  state = {pid, std::nullopt, false, state.has_stream, std::nullopt, state.unjudged, state.silence_at_end};
  liveness_.restarted(node);
  if (state.has_stream) liveness_.restarted(stream_name(node));
}

void CellWatch::process_exited(std::string_view node, const ProcessExit& exit, bool news) {
  const auto found = states_.find(node);
  if (found == states_.end()) return;
  State& state = found->second;
  const bool replaced = state.pid != 0 && state.pid != exit.pid && !state.died;
  if (replaced && liveness_.presence(node) == Presence::kAlive) {
    // History: its successor is here. Where the agent could not be heard when it ended, nobody has told it yet.
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

void CellWatch::contacts(std::uint64_t count, const std::string& subject, const std::string& seen) {
  const bool first = !std::exchange(contacts_known_, true);
  if (first && faults_.knows(msg::CauseKind::CAUSE_CONTACT)) contacts_ = count;
  if (count > contacts_)
    untold_contacts_.push_back({msg::CauseKind::CAUSE_CONTACT, msg::Severity::SEVERITY_CRITICAL, subject, seen});
  contacts_ = count;
}

void CellWatch::adopt(const std::string& cause, const FaultRecord& record, Time now) {
  faults_.adopt(cause, record, now);
  const bool judged = record.kind != msg::CauseKind::CAUSE_PERSISTENCE_FAILED &&
                      expects(std::string_view(cause).substr(0, cause.find(kBeside)));
  if (!judged) faults_.clear(cause, now);
}

// The last beats of a process that has ended may come between the first of its successor, but not again and again.
void CellWatch::note_process(State& state, std::int64_t pid) const {
  const Time now = clock_.now();
  if (now - state.beat_at > kTwins) state.returns = 0;
  if (state.pid != 0 && state.pid != pid) {
    state.returns = state.former_pid == pid ? state.returns + 1 : 0;
    state.former_pid = state.pid;
    state.returned_at = now;
  }
  state.beat_at = now;
}

// Beside what else may be wrong with the node, so a cause of its own.
void CellWatch::judge_twins(Time now) {
  for (const ExpectedNode& node : nodes_) {
    State& state = states_.find(node.name)->second;
    if (clock_.now() - state.returned_at > kTwins) state.returns = 0;
    const std::string cause = cause_of(msg::CauseKind::CAUSE_DUPLICATE_NODE, node.name);
    if (state.returns < kStragglers) {
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

void CellWatch::judge_contacts(Time now) {
  const std::string cause = "contact";  // of no node
  for (const FaultSight& contact : std::exchange(untold_contacts_, {})) {
    Passing passing;
    passing.at = contact.since.value_or(now);
    passing.contact = contact;
    note_passing(std::move(passing));
    faults_.raise(cause, contact, now);
    faults_.clear(cause, now);
    if (limits_.waits_for_resume.contains(msg::CauseKind::CAUSE_CONTACT))
      mode_.hold_until_resumed({}, make_cause(msg::CauseKind::CAUSE_HELD_BY_FAULT, contact.subject, contact.seen));
  }
}

void CellWatch::succeed(std::string_view predecessor, Time silence) {
  const ExpectedNode* before = expected(predecessor);
  const ExpectedNode* its_agent = before ? hosts_.agent_of(before->host) : nullptr;
  const FaultRecord* its_own = its_agent ? faults_.open(its_agent->name) : nullptr;
  // It was cut off, too, and heard no more than we did.
  if (its_own && its_own->severity >= msg::Severity::SEVERITY_ERROR) return;
  for (const ExpectedNode& node : nodes_) {
    const State& state = *find(node.name);
    const ExpectedNode* agent = hosts_.agent_of(node.host);
    const bool told = state.died || state.stopped || faults_.open(node.name) || !agent || faults_.open(agent->name);
    // What is explained it may have explained, too.
    if (told || node.host == hosts_.own() || !liveness_.last_heard(node.name) || hosts_.explain(node)) continue;
    const Time limit = node.role == msg::NodeKind::NODE_AGENT ? limits_.host_lease : limits_.node.silence;
    const Time latest = limit + limits_.node.silence;  // of its own word, for it may have stood still
    if (liveness_.silence(node.name) > silence + latest) hosts_.meet_anew(node.host);
  }
}

void CellWatch::begin_to_lead(std::uint64_t term) {
  std::set<std::string> lost;
  for (const ExpectedNode& node : nodes_) {
    if (node.role == msg::NodeKind::NODE_AGENT && faults_.open(node.name)) lost.insert(node.host);
  }
  hosts_.begin_to_lead(term, std::move(lost));
}

void CellWatch::note_passing(Passing passing) {
  while (!passing_.empty() && passing_.front().at < passing.at - kPassing) passing_.pop_front();
  passing_.push_back(std::move(passing));
}

// Deaths that the list has are left out when they are judged.
void CellWatch::judge_again(Time since) {
  for (const Passing& passing : passing_) {
    if (passing.at < since) continue;
    if (passing.node.empty()) {
      if (faults_.knows(passing.contact, passing.at - kSameTime)) continue;
      untold_contacts_.push_back(passing.contact);
      untold_contacts_.back().since = passing.at;
    } else {
      State& state = states_.find(passing.node)->second;
      state.unjudged = passing.exit;
      state.unjudged_since = passing.at;
    }
  }
}

void CellWatch::judge(Time now) {
  allow_for_losses();  // cell_losses.cpp
  liveness_.judge(stalled_);
  const bool was_cut_off = hosts_.cut_off();
  // Who is not heard knows no better than who told it of our host.
  const auto may_be_lost = [&](const ExpectedNode& node) {
    return node.name == agent_node(hosts_.own()) && hosts_.unheard();
  };
  hosts_.judge();
  // What else may be wrong with our agent is judged afresh.
  if (was_cut_off && !hosts_.cut_off()) faults_.clear(hosts_.agent_of(hosts_.own())->name, now);
  std::set<const FaultRecord*> fresh;
  const auto raise = [&](const ExpectedNode& node, const FaultSight& sight) {
    // Who has resumed since need not say so again when the same is explained better.
    const FaultRecord* known = faults_.open(node.name);
    const bool waited = known && limits_.waits_for_resume.contains(known->kind);
    if (faults_.raise(node.name, sight, now) && !waited) fresh.insert(faults_.open(node.name));
  };
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
      // Told even when its successor was heard of in the same instant; over with the next judgement then. What an
      // earlier supervisor has told already is history.
      raise(node, *death);
      if (exit->at && sound(node)) faults_.clear(node.name, now);  // of long ago: nobody is held for it
    } else if (const auto seen = sight(node)) {
      raise(node, *seen);
    } else if (sound(node) && !may_be_lost(node)) {
      faults_.clear(node.name, now);
    }
  }
  judge_twins(now);
  judge_contacts(now);
  mode_.set_automatic(holds());
  for (const ExpectedNode& node : nodes_) {
    const FaultRecord* fault = holds_arms(node) ? fault_holding(node) : nullptr;
    if (!fault || !fresh.contains(fault) || !limits_.waits_for_resume.contains(fault->kind)) continue;
    mode_.hold_until_resumed(node.role == msg::NodeKind::NODE_WORLD ? std::string() : node.arm, held_by(*fault));
  }
}

std::string CellWatch::stream_name(std::string_view node) {
  return std::string(node) + " stream";
}

const ExpectedNode* CellWatch::expected(std::string_view node) const {
  const auto is_it = [&](const ExpectedNode& one) { return one.name == node; };
  const auto found = std::find_if(nodes_.begin(), nodes_.end(), is_it);
  return found == nodes_.end() ? nullptr : &*found;
}

const CellWatch::State* CellWatch::find(std::string_view node) const {
  const auto found = states_.find(node);
  return found == states_.end() ? nullptr : &found->second;
}

Presence CellWatch::presence_of(const ExpectedNode& node) const {
  return liveness_.presence(node.name);
}

bool CellWatch::alive(std::string_view node) const {
  const State* state = find(node);
  return state && !state->died && !state->stopped && liveness_.presence(node) == Presence::kAlive;
}

bool CellWatch::ended(std::string_view node) const {
  const State* state = find(node);
  return state && (state->died || state->stopped || liveness_.presence(node) == Presence::kMissing);
}

std::optional<Time> CellWatch::silence(std::string_view node) const {
  if (!find(node) || !liveness_.last_heard(node)) return std::nullopt;
  return liveness_.silence(node);
}

std::string CellWatch::in_charge(std::string_view arm) const {
  const auto found = in_charge_.find(arm);
  return found == in_charge_.end() || found->second.empty() ? planner_node(arm) : found->second;
}

// No reason is left to complain of it.
bool CellWatch::sound(const ExpectedNode& node) const {
  const State& state = *find(node.name);
  if (state.stopped) return true;
  if (state.failure) return false;
  return alive(node.name) && (!state.has_stream || liveness_.presence(stream_name(node.name)) == Presence::kAlive);
}

msg::Cause CellWatch::awaited(std::string_view node) const {
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

Loss CellWatch::loss_of(std::string_view arm) const {
  const std::string driver = driver_node(std::string(arm));
  const ExpectedNode* node = expected(driver);
  if (!node) return Loss::kNone;
  const State& state = *find(driver);
  if (state.died || state.stopped) return Loss::kEnded;
  const ExpectedNode* agent = hosts_.agent_of(node->host);
  const bool lost = agent && faults_.open(agent->name) && hosts_.silent_for(node->host, limits_.host_lease);
  return lost && hosts_.most_are_heard() ? Loss::kHostSilent : Loss::kNone;
}

std::optional<FaultSight> CellWatch::sight(const ExpectedNode& node) const {
  const State& state = *find(node.name);
  if (state.died) return death_sight(node, *state.died, state.silence_at_end);
  if (state.stopped) return std::nullopt;
  if (state.failure) {
    return FaultSight{msg::CauseKind::CAUSE_NODE_FAILED, msg::Severity::SEVERITY_ERROR, node.name,
                      node.name + ": " + state.failure->text(), limits_.heartbeat_period};
  }
  if (node.role == msg::NodeKind::NODE_AGENT && node.host == hosts_.own() && hosts_.cut_off())
    return own_host_sight(node);
  const Presence presence = presence_of(node);
  if (presence == Presence::kMissing) {
    const ExpectedNode* agent = hosts_.agent_of(node.host);
    const bool explained = agent && agent->name != node.name && presence_of(*agent) == Presence::kMissing;
    if (explained) return std::nullopt;
    return FaultSight{msg::CauseKind::CAUSE_NODE_MISSING, msg::Severity::SEVERITY_ERROR, node.name,
                      node.name + " did not appear within " + milliseconds(limits_.node.grace), limits_.node.grace};
  }
  if (silent(presence)) return silence_sight(node, presence);
  return state.has_stream && presence == Presence::kAlive ? stream_sight(node) : std::nullopt;
}

// The same fault as a supervisor on another host tells.
FaultSight CellWatch::own_host_sight(const ExpectedNode& agent) const {
  return {
      msg::CauseKind::CAUSE_HOST_LOST, msg::Severity::SEVERITY_ERROR, agent.host,
      "host " + agent.host + ": no agent of another host heard there for more than " + milliseconds(limits_.host_lease),
      hosts_.alone_for()};
}

std::optional<FaultSight> CellWatch::silence_sight(const ExpectedNode& node, Presence presence) const {
  const LivenessLimits limits = liveness_.limits(node.name);
  const Time limit = presence == Presence::kLost ? limits.lost : limits.silence;
  if (hosts_.put_down_to_us(node)) return std::nullopt;
  if (node.role == msg::NodeKind::NODE_AGENT) {
    if (presence != Presence::kLost) return std::nullopt;
    const bool all = hosts_.silent(node.host);
    return FaultSight{msg::CauseKind::CAUSE_HOST_LOST,
                      all ? msg::Severity::SEVERITY_ERROR : msg::Severity::SEVERITY_WARNING, node.host,
                      (all ? "host " + node.host + ": nothing heard of it or its nodes for more than "
                           : node.name + ": no heartbeat, while nodes of its host are heard, for more than ") +
                          milliseconds(limit),
                      liveness_.silence(node.name)};
  }
  if (hosts_.explain(node)) return std::nullopt;
  const Time own = presence == Presence::kLost ? limits_.node.lost : limits_.node.silence;
  return FaultSight{msg::CauseKind::CAUSE_NODE_SILENT, silence_severity(presence), node.name,
                    node.name + ": no heartbeat for more than " + milliseconds(limit) +
                        (limit > own ? ", while the network loses others" : ""),
                    liveness_.silence(node.name)};
}

std::optional<FaultSight> CellWatch::stream_sight(const ExpectedNode& node) const {
  const bool world = node.role == msg::NodeKind::NODE_WORLD;
  const std::string stream = stream_name(node.name);
  const Presence presence = liveness_.presence(stream);
  const Time limit = liveness_.limits(stream).silence;
  if ((!silent(presence) && presence != Presence::kMissing) || hosts_.put_down_to_us(node)) return std::nullopt;
  // When both fall silent together the loop hangs, which is another fault: wait until the heartbeat outlives the
  // stream.
  const auto last = liveness_.last_heard(stream);
  if (last && *liveness_.last_heard(node.name) - *last <= limit) return std::nullopt;
  const std::string missing = world ? "no obstacle states" : "no arm state";
  return FaultSight{world ? msg::CauseKind::CAUSE_WORLD_SILENT : msg::CauseKind::CAUSE_DRIVER_SILENT,
                    silence_severity(presence), world ? node.name : node.arm,
                    node.name + ": heartbeats, but " + missing + " for more than " + milliseconds(limit),
                    liveness_.silence(stream)};
}

}  // namespace hecaton::services
