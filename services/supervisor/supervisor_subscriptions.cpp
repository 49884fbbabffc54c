#include "services/supervisor/supervisor_subscriptions.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

#include <unistd.h>

#include "services/runtime/cell_mode.hpp"
#include "services/runtime/node_name.hpp"

namespace hecaton::services {
namespace {

/// A supervisor that hears only its own host for this long assumes that the other hosts are lost, not itself.
constexpr Time kAlone = std::chrono::seconds(1);
/// A process event that arrives this long after it happened keeps its own time.
constexpr Time kLate = std::chrono::seconds(1);

/// A node that has been silent for this long may have a successor.
constexpr Time kHeld = std::chrono::milliseconds(200);
/// More than a cell has hosts.
constexpr std::size_t kMostAgents = 256;
/// More than a cell has processes.
constexpr std::size_t kMostProcesses = 4096;
/// Nodes that the cell file does not place on a host, such as clients and recorders, that the status lists.
constexpr std::size_t kMostHelpers = 256;
/// Events that wait for the first heartbeat of their agent; more than all processes of a cell have in their history.
constexpr std::size_t kMostWaiting = 4096;

// FaultDetector judges silence and compensates stalls of this process. Deadlines of the middleware would only cost
// time.
bus::ReaderOptions without_deadline() {
  bus::ReaderOptions options;
  options.deadline = std::chrono::milliseconds(0);
  return options;
}

// Gaps in sequence numbers show losses. Without conflation two processes of one node cannot hide each other.
bus::ReaderOptions every_sample() {
  bus::ReaderOptions options = without_deadline();
  options.conflate = false;
  return options;
}

template <class T>
Time arrival(const bus::Sample<T>& sample) {
  return sample.received.time_since_epoch();
}

/// After an absence of this process or of the agent, the agent's last events arrive again.
bool is_repeated(const CellSnapshot& snapshot, const bus::Sample<msg::ProcessEvent>& event) {
  const auto* known = find(snapshot.processes, event.value.process());
  return known && known->writer == event.writer && event.value.sequence_number() <= known->value.sequence_number();
}

/// When the sender's keys expire; empty: it has none.
std::optional<KeyExpiry> key_expiry(const msg::Heartbeat& heartbeat) {
  if (heartbeat.keys_expire_unix_ms() == 0) return std::nullopt;
  using WallTime = std::chrono::time_point<std::chrono::system_clock, std::chrono::milliseconds>;
  // A wire rule bounds the field to a range that is too large for nanoseconds.
  constexpr auto kFarthest = std::chrono::milliseconds(std::chrono::hours(24) * 365 * 200);
  const WallTime at(std::clamp(std::chrono::milliseconds(heartbeat.keys_expire_unix_ms()), -kFarthest, kFarthest));
  return KeyExpiry{at, at - std::chrono::system_clock::now()};
}

/// The report lists the first contacts one by one; of later ones it has only the deepest.
msg::Separation latest_contact(const msg::ContactReport& report) {
  const auto count = report.contacts();
  const bool listed = count > 0 && count <= report.events().size();
  return listed ? report.events()[count - 1] : report.smallest();
}

std::optional<msg::Cause> device_fault_in(const msg::ArmState& state) {
  const auto kind = device_fault(state.cause().kind());
  if (!kind) return std::nullopt;
  return make_cause(*kind, state.arm(), state.cause().text());
}

ProcessExit exit_of(const msg::ProcessEvent& event) {
  return {event.pid(), event.exit_code(), event.signal_number(), event.wanted(), {}, event.cause()};
}

}  // namespace

SupervisorSubscriptions::Readers::Readers(bus::Participant& participant, bus::Mailbox& urgent, bus::Mailbox& quiet)
    : requests(participant, &urgent),
      processes(participant, &urgent),
      heartbeats(participant, &quiet, every_sample()),
      rows(participant, &quiet),
      arms(participant, &quiet, every_sample()),
      goals(participant, &quiet),
      shapes(participant, &quiet),
      states(participant, &quiet, without_deadline()),
      contacts(participant, &quiet),
      modes(participant, &quiet, without_deadline()),
      faults(participant, &quiet) {}

SupervisorSubscriptions::SupervisorSubscriptions(bus::Participant& participant, Self self, bus::Mailbox& urgent,
                                                 bus::Mailbox& quiet)
    : self_(std::move(self)), readers_(participant, urgent, quiet) {}

void SupervisorSubscriptions::receive(const bus::EndpointId& self, const Consumers& to) {
  receive_modes(self, to);
  receive_process_events(to);
  receive_heartbeats(to);
  receive_rows(to);
  receive_arm_states(to);
  receive_world(to);
}

Time SupervisorSubscriptions::newest_arrival() const {
  return newest_.own_host - newest_.other_hosts > kAlone ? newest_.own_host : newest_.other_hosts;
}

void SupervisorSubscriptions::receive_modes(const bus::EndpointId& self, const Consumers& to) {
  for (const auto& sample : readers_.modes.take()) {
    const msg::CellMode& mode = sample.value;
    if (sample.disposed || sample.writer.same_participant(self)) continue;
    newest_.other_hosts = std::max(newest_.other_hosts, arrival(sample));
    to.leadership.observe_leader(mode.term(), arrival(sample));
    if (to.leadership.owns(mode.term())) continue;  // no leader's: its orders do not count
    if (leader_.mode && mode.term() < leader_.mode->term()) continue;
    for (const msg::ArmLease& lease : mode.leases()) to.failover.update(lease.arm(), lease_of(lease));
    leader_.node = mode.node();
    leader_.mode = mode;
    leader_.at = arrival(sample);
  }
  receive_faults(self);
  if (to.leadership.role() == Leadership::Role::kLeading) adopt_faults(to.detector, read_clocks());
}

void SupervisorSubscriptions::receive_faults(const bus::EndpointId& self) {
  for (const auto& sample : readers_.faults.take()) {
    if (sample.writer.same_participant(self)) continue;
    if (sample.disposed) {
      faults_.latest.erase(sample.key);
    } else if (faults_.latest.update(sample.value)) {
      ++faults_.revision;
      faults_.unadopted.insert(sample.value.id());
    }
  }
}

void SupervisorSubscriptions::adopt_faults(FaultDetector& detector, const Clocks& clocks) {
  for (const std::string& id : std::exchange(faults_.unadopted, {})) {
    const auto fault = faults_.latest.all().find(id);
    if (fault == faults_.latest.all().end()) continue;
    if (const auto keyed = fault_record_of(fault->second, clocks)) {
      detector.adopt(keyed->key, keyed->record, clocks.now);
    }
  }
}

msg::ModeNumber SupervisorSubscriptions::acknowledged_mode() const {
  return leader_.mode ? number_of(*leader_.mode) : msg::ModeNumber();
}

void SupervisorSubscriptions::receive_heartbeats(const Consumers& to) {
  for (const auto& sample : readers_.heartbeats.take()) {
    const msg::Heartbeat& heartbeat = sample.value;
    if (sample.disposed) {
      if (!to.detector.expects(sample.key)) to.snapshot.heartbeats.erase(sample.key);
      continue;
    }
    if (heartbeat.kind() == msg::NodeKind::NODE_AGENT) note_agent(sample);
    Time& newest = heartbeat.host() == self_.host ? newest_.own_host : newest_.other_hosts;
    if (heartbeat.node() != self_.node) newest = std::max(newest, arrival(sample));
    const Speaker* speaker = speaker_of(sample, to.detector);
    if (speaker) observe_term(*speaker, sample, to);
    // The cause of a failed node may be empty.
    const bool failed = heartbeat.state() == msg::NodeState::NODE_FAILED;
    const bool speaks = speaker || !to.detector.expects(heartbeat.node());
    to.detector.heard(heartbeat.node(),
                      {heartbeat.pid(), arrival(sample), heartbeat.sequence_number(),
                       failed ? std::optional(heartbeat.cause()) : std::nullopt, key_expiry(heartbeat), speaks});
    if (speaker) {
      for (const msg::Refusal& refusal : heartbeat.refusals()) to.detector.refusal_heard(heartbeat.node(), refusal);
    }
    if (!to.detector.expects(heartbeat.node())) make_room_for(heartbeat.node(), to);
    to.snapshot.update_heartbeat(sample);
  }
}

void SupervisorSubscriptions::make_room_for(const std::string& helper, const Consumers& to) {
  auto& heartbeats = to.snapshot.heartbeats;
  if (heartbeats.contains(helper) || heartbeats.size() < to.detector.nodes().size() + kMostHelpers) return;
  auto oldest = heartbeats.end();
  for (auto one = heartbeats.begin(); one != heartbeats.end(); ++one) {
    if (to.detector.expects(one->first)) continue;
    if (oldest == heartbeats.end() || one->second.at < oldest->second.at) oldest = one;
  }
  if (oldest != heartbeats.end()) heartbeats.erase(oldest);
}

SupervisorSubscriptions::Speaker* SupervisorSubscriptions::speaker_of(const bus::Sample<msg::Heartbeat>& sample,
                                                                      const FaultDetector& detector) {
  if (speakers_.empty()) {
    for (const ExpectedNode& node : detector.nodes()) {
      speakers_.emplace(node.name, Speaker{.role = node.role, .arm = node.arm});
    }
  }
  const auto known = speakers_.find(sample.value.node());
  if (known == speakers_.end()) return nullptr;
  Speaker& speaker = known->second;
  const bool same = speaker.heartbeats.same_participant(sample.writer);
  if (!same && speaker.heard > Time(0) && arrival(sample) - speaker.heard <= kHeld) return nullptr;
  speaker.heartbeats = sample.writer;
  speaker.heard = arrival(sample);
  return &speaker;
}

void SupervisorSubscriptions::observe_term(const Speaker& speaker, const bus::Sample<msg::Heartbeat>& sample,
                                           const Consumers& to) {
  if (speaker.role == msg::NodeKind::NODE_DRIVER) {  // it also sends the states of its arm
    const auto* state = find(to.snapshot.arms, speaker.arm);
    if (!state || !state->writer.same_participant(sample.writer)) return;
  } else if (speaker.role != msg::NodeKind::NODE_PLANNER) {
    return;
  }
  to.leadership.observe_term(sample.value.term(), arrival(sample));
  // A planner may know a lease that has not reached its driver, and wait for the planner that the lease names.
  to.failover.update(speaker.arm, lease_of(sample.value.lease()));
}

void SupervisorSubscriptions::receive_rows(const Consumers& to) {
  for (const auto& sample : readers_.rows.take()) {
    if (sample.disposed) continue;
    std::vector<HostAge> ages;
    for (const msg::HostAge& heard : sample.value.heard()) {
      ages.push_back({heard.host(), std::chrono::round<Time>(std::chrono::duration<float>(heard.age()))});
    }
    to.detector.row_heard(sample.value.host(), ages, arrival(sample));
  }
}

void SupervisorSubscriptions::receive_arm_states(const Consumers& to) {
  std::map<std::string_view, const bus::Sample<msg::ArmState>*> newest;
  const auto samples = readers_.arms.take();
  for (const auto& sample : samples) {
    if (sample.disposed || !to.detector.expects(driver_node(sample.value.arm()))) continue;
    newest.insert_or_assign(sample.value.arm(), &sample);
    to.snapshot.update_observed(sample.value);
    to.detector.stream_heard(driver_node(sample.value.arm()), arrival(sample), sample.value.sequence_number());
  }
  for (const auto& [arm, last] : newest) {
    const auto& sample = *last;
    const msg::ArmState& state = sample.value;
    if (to.failover.planners_of(state.arm())) {
      to.failover.update_from_driver(state.arm(), {state.planner(), state.newest_term()});
    } else {
      to.leadership.observe_term(state.newest_term(), arrival(sample));  // the only planner uses the cell's term
    }
    to.detector.device_heard(state.arm(), device_fault_in(state));
    to.snapshot.arms.insert_or_assign(state.arm(), received(sample));
  }
  for (const auto& sample : readers_.goals.take()) {
    if (to.detector.expects(driver_node(sample.value.arm()))) to.snapshot.update_goal(sample);
  }
}

void SupervisorSubscriptions::note_agent(const bus::Sample<msg::Heartbeat>& sample) {
  const auto known = processes_.agents.find(sample.value.node());
  if (known != processes_.agents.end()) {
    KnownAgent& agent = known->second;
    const bool same = agent.heartbeats.same_participant(sample.writer);
    if (same) agent.heard = arrival(sample);
    // Events of another participant do not count while the agent is heard.
    if (same || arrival(sample) - agent.heard <= kHeld) return;
  } else if (processes_.agents.size() == kMostAgents) {
    return;
  }
  processes_.agents.insert_or_assign(sample.value.node(),
                                     KnownAgent{sample.writer, sample.value.newest_event(), arrival(sample),
                                                sample.value.stamp_ns(), arrival(sample)});
}

const SupervisorSubscriptions::KnownAgent* SupervisorSubscriptions::known_agent(
    const bus::Sample<msg::ProcessEvent>& sample) const {
  const auto known = processes_.agents.find(agent_node(sample.value.host()));
  return known != processes_.agents.end() && known->second.heartbeats.same_participant(sample.writer) ? &known->second
                                                                                                      : nullptr;
}

// A late joiner receives the agent's last events. Only the agent's heartbeat says which of them are in the past, so
// events wait for the first heartbeat.
void SupervisorSubscriptions::receive_process_events(const Consumers& to) {
  auto events = std::exchange(processes_.waiting, {});
  for (auto& sample : readers_.processes.take()) events.push_back(std::move(sample));
  for (auto& sample : events) {
    if (sample.disposed || is_repeated(to.snapshot, sample)) continue;
    if (known_agent(sample)) {
      apply_process_event(sample, to);
    } else {
      processes_.waiting.push_back(std::move(sample));
      if (processes_.waiting.size() > kMostWaiting) processes_.waiting.erase(processes_.waiting.begin());
    }
  }
}

void SupervisorSubscriptions::apply_process_event(const bus::Sample<msg::ProcessEvent>& sample, const Consumers& to) {
  const msg::ProcessEvent& event = sample.value;
  const bool is_new = !find(to.snapshot.processes, event.process());
  if (is_new && to.snapshot.processes.size() == kMostProcesses) return;
  to.snapshot.processes.insert_or_assign(event.process(), received(sample));
  const bool exited = event.kind() == msg::ProcessEventKind::PROCESS_EXITED;
  const KnownAgent& agent = *known_agent(sample);
  const bool past = event.sequence_number() <= agent.past_events;
  const bool own = event.node() == self_.node;  // an earlier process of this supervisor: take_own_predecessor_exit()
  if (exited && !own) {
    ProcessExit exit = exit_of(event);
    const Time at = agent.at - std::chrono::nanoseconds(agent.stamp_ns - event.stamp_ns());
    if (past || arrival(sample) - at > kLate) exit.at = at;
    // Without a checkpoint this supervisor cannot know whether a past exit was published.
    to.detector.process_exited(event.node(), exit, self_.has_checkpoint || !past);
  } else if (!exited) {
    to.detector.process_started(event.node(), event.pid());
  }
  const auto* leader = find(to.snapshot.heartbeats, leader_.node);
  const bool led = leader && event.node() == leader_.node && event.pid() == leader->value.pid();
  if (exited && led) to.leadership.leader_died();
  if (!own) return;
  if (exited) {
    processes_.own_exit = exit_of(event);
  } else if (event.pid() == getpid() && processes_.own_exit && !processes_.own_exit->wanted) {
    processes_.predecessor = processes_.own_exit;
  }
}

void SupervisorSubscriptions::receive_world(const Consumers& to) {
  for (const auto& sample : readers_.shapes.take()) {
    if (sample.disposed) {
      to.snapshot.obstacles.erase(sample.key);
    } else {
      to.snapshot.obstacles.insert_or_assign(sample.value.name(), received(sample));
    }
  }
  for (const auto& sample : readers_.states.take()) {
    if (sample.disposed) continue;
    to.detector.stream_heard(world_node(), arrival(sample));
    to.snapshot.update_obstacle_states(sample);
  }
  for (const auto& sample : readers_.contacts.take()) {
    const bool of_world = !to.snapshot.states || to.snapshot.states->writer.same_participant(sample.writer);
    if (sample.disposed || !of_world) continue;
    to.snapshot.contact_report = received(sample);
    const msg::Separation contact = latest_contact(sample.value);
    to.detector.contacts(sample.value.contacts(), contact.a(), contact.a() + " touched " + contact.b());
  }
}

std::optional<ProcessExit> SupervisorSubscriptions::take_own_predecessor_exit() {
  return std::exchange(processes_.predecessor, std::nullopt);
}

}  // namespace hecaton::services
