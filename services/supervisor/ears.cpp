#include "services/supervisor/ears.hpp"

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
bool heard_before(const Picture& picture, const bus::Sample<msg::ProcessEvent>& event) {
  const auto* known = find(picture.processes, event.value.process());
  return known && known->writer == event.writer && event.value.sequence_number() <= known->value.sequence_number();
}

/// The first contacts are told one by one; of later ones there is only the deepest so far.
msg::Separation latest_contact(const msg::RefereeReport& report) {
  const auto count = report.contacts();
  const bool listed = count > 0 && count <= report.events().size();
  return listed ? report.events()[count - 1] : report.smallest();
}

ProcessExit exit_of(const msg::ProcessEvent& event) {
  return {event.pid(), event.exit_code(), event.signal_number(), event.wanted(), {}, event.reason()};
}

}  // namespace

Ears::Ears(bus::Participant& participant, Self self, bus::Mailbox& urgent, bus::Mailbox& quiet)
    : self_(std::move(self)),
      requests_(participant, &urgent),
      processes_(participant, &urgent),
      heartbeats_(participant, &quiet, every_sample()),
      rows_(participant, &quiet),
      arms_(participant, &quiet, every_sample()),
      goals_(participant, &quiet),
      shapes_(participant, &quiet),
      states_(participant, &quiet, without_deadline()),
      referee_(participant, &quiet),
      modes_(participant, &quiet, without_deadline()),
      faults_(participant, &quiet) {}

void Ears::listen(const bus::EndpointId& self, const Listeners& to) {
  hear_leaders(self, to);
  hear_processes(to);
  hear_nodes(to);
  hear_rows(to);
  hear_drivers(to);
  hear_world(to);
}

Time Ears::newest_arrival() const {
  return newest_near_ - newest_far_ > kAlone ? newest_near_ : newest_far_;
}

void Ears::hear_leaders(const bus::EndpointId& self, const Listeners& to) {
  for (const auto& sample : modes_.take()) {
    const msg::CellMode& mode = sample.value;
    if (sample.disposed || sample.writer.same_participant(self)) continue;
    newest_far_ = std::max(newest_far_, arrival(sample));
    to.leadership.heard_leader(mode.term(), arrival(sample));
    if (other_mode_ && mode.term() < other_mode_->term()) continue;
    for (const msg::Grant& grant : mode.grants()) to.succession.hear(grant.arm(), {grant.planner(), grant.term()});
    leader_ = mode.node();
    other_mode_ = mode;
    other_mode_at_ = arrival(sample);
  }
  hear_faults(self);
  if (to.leadership.role() == Leadership::Role::kLeading) adopt_faults(to.watch, read_clocks());
}

void Ears::hear_faults(const bus::EndpointId& self) {
  for (const auto& sample : faults_.take()) {
    if (sample.writer.same_participant(self)) continue;
    if (sample.disposed) {
      other_faults_.forget(sample.key);
    } else if (other_faults_.hear(sample.value)) {
      ++fault_news_;
      unadopted_.insert(sample.value.id());
    }
  }
}

void Ears::adopt_faults(FaultDetector& watch, const Clocks& clocks) {
  for (const std::string& id : std::exchange(unadopted_, {})) {
    const auto fault = other_faults_.all().find(id);
    if (fault == other_faults_.all().end()) continue;
    if (const auto told = told_record(fault->second, clocks)) watch.adopt(told->cause, told->record, clocks.now);
  }
}

msg::ModeNumber Ears::newest_mode_of_others() const {
  return other_mode_ ? number_of(*other_mode_) : msg::ModeNumber();
}

void Ears::hear_nodes(const Listeners& to) {
  for (const auto& sample : heartbeats_.take()) {
    const msg::Heartbeat& beat = sample.value;
    if (sample.disposed) continue;
    if (beat.kind() == msg::NodeKind::NODE_AGENT) meet_agent(sample);
    Time& newest = beat.host() == self_.host ? newest_near_ : newest_far_;
    if (beat.node() != self_.node) newest = std::max(newest, arrival(sample));
    if (beat.kind() != msg::NodeKind::NODE_SUPERVISOR) to.leadership.heard_term(beat.term(), arrival(sample));
    // A grant that its driver never heard of may have reached a planner, which waits for the planner that it names.
    to.succession.hear(beat.subject(), {beat.mandate().planner(), beat.mandate().term()});
    const bool failed = beat.state() == msg::NodeState::NODE_FAILED;
    to.watch.heard(beat.node(), {beat.pid(), arrival(sample), beat.sequence_number(),
                                 failed ? std::optional(beat.detail()) : std::nullopt});
    to.picture.take_heartbeat(sample);
  }
}

void Ears::hear_rows(const Listeners& to) {
  for (const auto& sample : rows_.take()) {
    if (sample.disposed) continue;
    std::vector<HostAge> ages;
    for (const msg::HostAge& heard : sample.value.heard()) {
      ages.push_back({heard.host(), std::chrono::round<Time>(std::chrono::duration<float>(heard.age()))});
    }
    to.watch.row_heard(sample.value.host(), ages, arrival(sample));
  }
}

void Ears::hear_drivers(const Listeners& to) {
  std::map<std::string_view, const bus::Sample<msg::ArmState>*> newest;
  const auto samples = arms_.take();
  for (const auto& sample : samples) {
    if (sample.disposed) continue;
    newest.insert_or_assign(sample.value.arm(), &sample);
    to.watch.stream_heard(driver_node(sample.value.arm()), arrival(sample), sample.value.sequence_number());
  }
  for (const auto& [arm, last] : newest) {
    const auto& sample = *last;
    const msg::ArmState& state = sample.value;
    if (to.succession.planners_of(state.arm())) {
      to.succession.hear_driver(state.arm(), {state.planner(), state.newest_term()});
    } else {
      to.leadership.heard_term(state.newest_term(), arrival(sample));  // the only planner uses the cell's term
    }
    const bool failed = state.mode() == msg::ArmMode::ARM_FAILED;
    to.watch.device_heard(state.arm(), failed ? std::optional(state.reason()) : std::nullopt);
    to.picture.arms.insert_or_assign(state.arm(), heard(sample));
  }
  for (const auto& sample : goals_.take()) to.picture.take_goal(sample);
}

void Ears::meet_agent(const bus::Sample<msg::Heartbeat>& sample) {
  const auto known = agents_.find(sample.value.node());
  if (known != agents_.end() && known->second.heartbeats.same_participant(sample.writer)) return;
  agents_.insert_or_assign(sample.value.node(), Acquaintance{sample.writer, sample.value.newest_event(),
                                                             arrival(sample), sample.value.stamp_ns()});
}

const Ears::Acquaintance* Ears::acquaintance(const bus::Sample<msg::ProcessEvent>& sample) const {
  const auto known = agents_.find(agent_node(sample.value.host()));
  return known != agents_.end() && known->second.heartbeats.same_participant(sample.writer) ? &known->second : nullptr;
}

// An agent tells its last events to whoever meets it. Which of them are history only its heartbeat says: they wait for
// the first one.
void Ears::hear_processes(const Listeners& to) {
  auto events = std::exchange(early_events_, {});
  for (auto& sample : processes_.take()) events.push_back(std::move(sample));
  for (auto& sample : events) {
    if (sample.disposed || heard_before(to.picture, sample)) continue;
    if (acquaintance(sample)) {
      hear_process(sample, to);
    } else {
      early_events_.push_back(std::move(sample));
    }
  }
}

void Ears::hear_process(const bus::Sample<msg::ProcessEvent>& sample, const Listeners& to) {
  const msg::ProcessEvent& event = sample.value;
  to.picture.processes.insert_or_assign(event.process(), heard(sample));
  const bool exited = event.kind() == msg::ProcessEventKind::PROCESS_EXITED;
  const Acquaintance& agent = *acquaintance(sample);
  const bool past = event.sequence_number() <= agent.past_events;
  if (exited) {
    ProcessExit exit = exit_of(event);
    const Time at = agent.at - std::chrono::nanoseconds(agent.stamp_ns - event.stamp_ns());
    if (past || arrival(sample) - at > kLate) exit.at = at;
    // Who has no account of the past cannot know whether it was told.
    to.watch.process_exited(event.node(), exit, self_.remembers || !past);
  } else {
    to.watch.process_started(event.node(), event.pid());
  }
  const auto* leader = find(to.picture.heartbeats, leader_);
  const bool led = leader && event.node() == leader_ && event.pid() == leader->value.pid();
  if (exited && led) to.leadership.leader_died();
  if (event.node() != self_.node) return;
  if (exited) {
    own_exit_ = exit_of(event);
  } else if (event.pid() == getpid() && own_exit_ && !own_exit_->wanted) {
    predecessor_ = own_exit_;
  }
}

void Ears::hear_world(const Listeners& to) {
  for (const auto& sample : shapes_.take()) {
    if (sample.disposed) {
      to.picture.obstacles.erase(sample.key);
    } else {
      to.picture.obstacles.insert_or_assign(sample.value.name(), heard(sample));
    }
  }
  for (const auto& sample : states_.take()) {
    if (sample.disposed) continue;
    to.watch.stream_heard(world_node(), arrival(sample));
    to.picture.take_states(sample);
  }
  for (const auto& sample : referee_.take()) {
    if (sample.disposed) continue;
    to.picture.referee = heard(sample);
    const msg::Separation contact = latest_contact(sample.value);
    to.watch.contacts(sample.value.contacts(), contact.a(), contact.a() + " touched " + contact.b());
  }
}

std::optional<ProcessExit> Ears::take_predecessor() {
  return std::exchange(predecessor_, std::nullopt);
}

}  // namespace hecaton::services
