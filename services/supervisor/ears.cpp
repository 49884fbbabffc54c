#include "services/supervisor/ears.hpp"

#include <utility>

#include <unistd.h>

#include "services/runtime/node_name.hpp"

namespace hecaton::services {
namespace {

// Silence is judged by CellWatch, which knows of our own stalls; the middleware's deadlines would only cost time.
bus::ReaderOptions without_deadline() {
  bus::ReaderOptions options;
  options.deadline = std::chrono::milliseconds(0);
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

ProcessExit exit_of(const msg::ProcessEvent& event) {
  return {event.pid(), event.exit_code(), event.signal_number(), event.wanted()};
}

}  // namespace

Ears::Ears(bus::Participant& participant, bus::Mailbox& urgent, bus::Mailbox& quiet)
    : requests_(participant, &urgent),
      processes_(participant, &urgent),
      heartbeats_(participant, &quiet, without_deadline()),
      arms_(participant, &quiet, without_deadline()),
      goals_(participant, &quiet),
      shapes_(participant, &quiet),
      states_(participant, &quiet, without_deadline()),
      referee_(participant, &quiet),
      modes_(participant, &quiet, without_deadline()) {}

void Ears::listen(const bus::EndpointId& self, Picture& picture, CellWatch& watch, Leadership& leadership) {
  for (const auto& sample : modes_.take()) {
    if (sample.disposed || sample.writer.same_participant(self)) continue;
    leadership.heard_leader(sample.value.term(), arrival(sample));
    other_mode_ = sample.value;
  }
  hear_processes(picture, watch);
  hear_nodes(picture, watch, leadership);
  hear_world(picture, watch);
}

void Ears::hear_nodes(Picture& picture, CellWatch& watch, Leadership& leadership) {
  for (const auto& sample : heartbeats_.take()) {
    if (sample.disposed) continue;
    if (sample.value.kind() != msg::NODE_SUPERVISOR) leadership.heard_term(sample.value.term());
    const bool failed = sample.value.state() == msg::NODE_FAILED;
    watch.heard(sample.value.node(), sample.value.pid(), arrival(sample),
                failed ? sample.value.detail() : std::string());
    picture.take_heartbeat(sample);
  }
  for (const auto& sample : arms_.take()) {
    if (sample.disposed) continue;
    leadership.heard_term(sample.value.term());
    watch.stream_heard(driver_node(sample.value.arm()), arrival(sample));
    picture.arms.insert_or_assign(sample.value.arm(), heard(sample));
  }
  for (const auto& sample : goals_.take()) picture.take_goal(sample);
}

void Ears::hear_processes(Picture& picture, CellWatch& watch) {
  for (const auto& sample : processes_.take()) {
    if (sample.disposed) continue;
    const msg::ProcessEvent& event = sample.value;
    if (heard_before(picture, sample)) continue;
    picture.processes.insert_or_assign(event.process(), heard(sample));
    const bool exited = event.kind() == msg::PROCESS_EXITED;
    if (exited) {
      watch.process_exited(event.node(), exit_of(event));
    } else {
      watch.process_started(event.node(), event.pid());
    }
    if (event.node() != supervisor_node()) continue;
    if (exited) {
      own_exit_ = exit_of(event);
    } else if (event.pid() == getpid() && own_exit_ && !own_exit_->wanted) {
      predecessor_ = own_exit_;
    }
  }
}

void Ears::hear_world(Picture& picture, CellWatch& watch) {
  for (const auto& sample : shapes_.take()) {
    if (sample.disposed) {
      picture.obstacles.erase(sample.key);
    } else {
      picture.obstacles.insert_or_assign(sample.value.name(), heard(sample));
    }
  }
  for (const auto& sample : states_.take()) {
    if (sample.disposed) continue;
    watch.stream_heard(world_node(), arrival(sample));
    picture.take_states(sample);
  }
  for (const auto& sample : referee_.take()) {
    if (!sample.disposed) picture.referee = heard(sample);
  }
}

std::optional<ProcessExit> Ears::take_predecessor() {
  return std::exchange(predecessor_, std::nullopt);
}

}  // namespace hecaton::services
