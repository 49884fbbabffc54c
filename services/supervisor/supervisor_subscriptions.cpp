#include "services/supervisor/supervisor_subscriptions.hpp"

#include <algorithm>
#include <utility>

#include <unistd.h>

#include "services/runtime/cell_mode.hpp"
#include "services/runtime/node_name.hpp"

namespace hecaton::services {
namespace {

/// Whoever hears nothing but its own host for so long takes the others for lost, and not itself.
constexpr Time kAlone = std::chrono::seconds(1);
/// What an agent tells so long after it happened was told to nobody in between: it is history.
constexpr Time kLate = std::chrono::seconds(1);

// Silence is judged by FaultDetector, which compensates stalls of this process; the middleware's deadlines would only
// cost time.
bus::ReaderOptions without_deadline() {
  bus::ReaderOptions options;
  options.deadline = std::chrono::milliseconds(0);
  return options;
}

// Gaps tell what is lost on the way. And of two processes that are one node each would otherwise hide the other, as
// long as they beat in step.
bus::ReaderOptions every_sample() {
  bus::ReaderOptions options = without_deadline();
  options.conflate = false;
  return options;
}

template <class T>
Time arrival(const bus::Sample<T>& sample) {
  return sample.received.time_since_epoch();
}

/// After an absence, of ours or of the agent's, its last events come once more.
bool heard_before(const CellSnapshot& snapshot, const bus::Sample<msg::ProcessEvent>& event) {
  const auto* known = find(snapshot.processes, event.value.process());
  return known && known->writer == event.writer && event.value.sequence_number() <= known->value.sequence_number();
}

/// The first contacts are told one by one; of later ones there is only the deepest so far.
msg::Separation latest_contact(const msg::RefereeReport& report) {
  const auto count = report.contacts();
  const bool listed = count > 0 && count <= report.events().size();
  return listed ? report.events()[count - 1] : report.smallest();
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

void SupervisorSubscriptions::listen(const bus::EndpointId& self, const Listeners& to) {
  hear_leaders(self, to);
  hear_processes(to);
  hear_nodes(to);
  hear_rows(to);
  hear_drivers(to);
  hear_world(to);
}

Time SupervisorSubscriptions::newest_arrival() const {
  return newest_.near - newest_.far > kAlone ? newest_.near : newest_.far;
}

void SupervisorSubscriptions::hear_leaders(const bus::EndpointId& self, const Listeners& to) {
  for (const auto& sample : readers_.modes.take()) {
    const msg::CellMode& mode = sample.value;
    if (sample.disposed || sample.writer.same_participant(self)) continue;
    newest_.far = std::max(newest_.far, arrival(sample));
    to.leadership.heard_leader(mode.term(), arrival(sample));
    if (leader_.mode && mode.term() < leader_.mode->term()) continue;
    for (const msg::ArmLease& lease : mode.leases()) to.failover.hear(lease.arm(), lease_of(lease));
    leader_.node = mode.node();
    leader_.mode = mode;
    leader_.at = arrival(sample);
  }
  hear_faults(self);
  if (to.leadership.role() == Leadership::Role::kLeading) adopt_faults(to.detector, read_clocks());
}

void SupervisorSubscriptions::hear_faults(const bus::EndpointId& self) {
  for (const auto& sample : readers_.faults.take()) {
    if (sample.writer.same_participant(self)) continue;
    if (sample.disposed) {
      faults_.told.forget(sample.key);
    } else if (faults_.told.hear(sample.value)) {
      ++faults_.news;
      faults_.unadopted.insert(sample.value.id());
    }
  }
}

void SupervisorSubscriptions::adopt_faults(FaultDetector& watch, const Clocks& clocks) {
  for (const std::string& id : std::exchange(faults_.unadopted, {})) {
    const auto fault = faults_.told.all().find(id);
    if (fault == faults_.told.all().end()) continue;
    if (const auto told = told_record(fault->second, clocks)) watch.adopt(told->cause, told->record, clocks.now);
  }
}

msg::ModeNumber SupervisorSubscriptions::newest_mode_of_others() const {
  return leader_.mode ? number_of(*leader_.mode) : msg::ModeNumber();
}

void SupervisorSubscriptions::hear_nodes(const Listeners& to) {
  for (const auto& sample : readers_.heartbeats.take()) {
    const msg::Heartbeat& beat = sample.value;
    if (sample.disposed) continue;
    if (beat.kind() == msg::NodeKind::NODE_AGENT) meet_agent(sample);
    Time& newest = beat.host() == self_.host ? newest_.near : newest_.far;
    if (beat.node() != self_.node) newest = std::max(newest, arrival(sample));
    if (beat.kind() != msg::NodeKind::NODE_SUPERVISOR) to.leadership.heard_term(beat.term(), arrival(sample));
    // A lease that its driver never heard of may have reached a planner, which waits for the planner that it names.
    to.failover.hear(beat.subject(), lease_of(beat.lease()));
    // A node that says no more than that it failed has failed.
    const bool failed = beat.state() == msg::NodeState::NODE_FAILED;
    to.detector.heard(beat.node(), {beat.pid(), arrival(sample), beat.sequence_number(),
                                    failed ? std::optional(beat.cause()) : std::nullopt});
    to.snapshot.take_heartbeat(sample);
  }
}

void SupervisorSubscriptions::hear_rows(const Listeners& to) {
  for (const auto& sample : readers_.rows.take()) {
    if (sample.disposed) continue;
    std::vector<HostAge> ages;
    for (const msg::HostAge& heard : sample.value.heard()) {
      ages.push_back({heard.host(), std::chrono::round<Time>(std::chrono::duration<float>(heard.age()))});
    }
    to.detector.row_heard(sample.value.host(), ages, arrival(sample));
  }
}

void SupervisorSubscriptions::hear_drivers(const Listeners& to) {
  std::map<std::string_view, const bus::Sample<msg::ArmState>*> newest;
  const auto samples = readers_.arms.take();
  for (const auto& sample : samples) {
    if (sample.disposed) continue;
    newest.insert_or_assign(sample.value.arm(), &sample);
    to.detector.stream_heard(driver_node(sample.value.arm()), arrival(sample), sample.value.sequence_number());
  }
  for (const auto& [arm, last] : newest) {
    const auto& sample = *last;
    const msg::ArmState& state = sample.value;
    if (to.failover.planners_of(state.arm())) {
      to.failover.hear_driver(state.arm(), {state.planner(), state.newest_term()});
    } else {
      to.leadership.heard_term(state.newest_term(), arrival(sample));  // the only planner uses the cell's term
    }
    const bool failed = state.mode() == msg::ArmMode::ARM_FAILED;
    to.detector.device_heard(state.arm(), failed ? std::optional(state.cause().text()) : std::nullopt);
    to.snapshot.arms.insert_or_assign(state.arm(), heard(sample));
  }
  for (const auto& sample : readers_.goals.take()) to.snapshot.take_goal(sample);
}

void SupervisorSubscriptions::meet_agent(const bus::Sample<msg::Heartbeat>& sample) {
  const auto known = processes_.agents.find(sample.value.node());
  if (known != processes_.agents.end() && known->second.heartbeats.same_participant(sample.writer)) return;
  processes_.agents.insert_or_assign(sample.value.node(), Acquaintance{sample.writer, sample.value.newest_event(),
                                                                       arrival(sample), sample.value.stamp_ns()});
}

const SupervisorSubscriptions::Acquaintance* SupervisorSubscriptions::acquaintance(
    const bus::Sample<msg::ProcessEvent>& sample) const {
  const auto known = processes_.agents.find(agent_node(sample.value.host()));
  return known != processes_.agents.end() && known->second.heartbeats.same_participant(sample.writer) ? &known->second
                                                                                                      : nullptr;
}

// An agent tells its last events to whoever meets it. Which of them are history only its heartbeat says: they wait for
// the first one.
void SupervisorSubscriptions::hear_processes(const Listeners& to) {
  auto events = std::exchange(processes_.early, {});
  for (auto& sample : readers_.processes.take()) events.push_back(std::move(sample));
  for (auto& sample : events) {
    if (sample.disposed || heard_before(to.snapshot, sample)) continue;
    if (acquaintance(sample)) {
      hear_process(sample, to);
    } else {
      processes_.early.push_back(std::move(sample));
    }
  }
}

void SupervisorSubscriptions::hear_process(const bus::Sample<msg::ProcessEvent>& sample, const Listeners& to) {
  const msg::ProcessEvent& event = sample.value;
  to.snapshot.processes.insert_or_assign(event.process(), heard(sample));
  const bool exited = event.kind() == msg::ProcessEventKind::PROCESS_EXITED;
  const Acquaintance& agent = *acquaintance(sample);
  const bool past = event.sequence_number() <= agent.past_events;
  if (exited) {
    ProcessExit exit = exit_of(event);
    const Time at = agent.at - std::chrono::nanoseconds(agent.stamp_ns - event.stamp_ns());
    if (past || arrival(sample) - at > kLate) exit.at = at;
    // Who has no account of the past cannot know whether it was told.
    to.detector.process_exited(event.node(), exit, self_.remembers || !past);
  } else {
    to.detector.process_started(event.node(), event.pid());
  }
  const auto* leader = find(to.snapshot.heartbeats, leader_.node);
  const bool led = leader && event.node() == leader_.node && event.pid() == leader->value.pid();
  if (exited && led) to.leadership.leader_died();
  if (event.node() != self_.node) return;
  if (exited) {
    processes_.own_exit = exit_of(event);
  } else if (event.pid() == getpid() && processes_.own_exit && !processes_.own_exit->wanted) {
    processes_.predecessor = processes_.own_exit;
  }
}

void SupervisorSubscriptions::hear_world(const Listeners& to) {
  for (const auto& sample : readers_.shapes.take()) {
    if (sample.disposed) {
      to.snapshot.obstacles.erase(sample.key);
    } else {
      to.snapshot.obstacles.insert_or_assign(sample.value.name(), heard(sample));
    }
  }
  for (const auto& sample : readers_.states.take()) {
    if (sample.disposed) continue;
    to.detector.stream_heard(world_node(), arrival(sample));
    to.snapshot.take_states(sample);
  }
  for (const auto& sample : readers_.contacts.take()) {
    if (sample.disposed) continue;
    to.snapshot.referee = heard(sample);
    const msg::Separation contact = latest_contact(sample.value);
    to.detector.contacts(sample.value.contacts(), contact.a(), contact.a() + " touched " + contact.b());
  }
}

std::optional<ProcessExit> SupervisorSubscriptions::take_predecessor() {
  return std::exchange(processes_.predecessor, std::nullopt);
}

}  // namespace hecaton::services
