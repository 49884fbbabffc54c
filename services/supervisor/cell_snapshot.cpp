#include "services/supervisor/cell_snapshot.hpp"

#include <algorithm>
#include <tuple>

#include "services/runtime/cause.hpp"

namespace hecaton::services {
namespace {

bool newer(const bus::Sample<msg::GoalStatus>& sample, const Received<msg::GoalStatus>& known) {
  // Sequence numbers order the statuses of one planner. Of two planners of one term the later arrival is newer.
  if (sample.writer != known.writer && sample.value.term() == known.value.term()) return true;
  return std::make_tuple(sample.value.term(), sample.value.sequence_number()) >=
         std::make_tuple(known.value.term(), known.value.sequence_number());
}

/// `sample` is of another process than `before`. The pid does not tell: a container assigns the same ones again.
/// Endpoint ids are partly random; should one repeat, the sequence number of a new process begins at 1.
bool from_another_process(const bus::Sample<msg::Heartbeat>& sample, const Received<msg::Heartbeat>& before) {
  return sample.writer != before.writer || sample.value.sequence_number() < before.value.sequence_number();
}

}  // namespace

void CellSnapshot::update_observed(const msg::ArmState& state) {
  if (state.mode() == msg::ArmMode::ARM_OBSERVED || state.cause().kind() == msg::CauseKind::CAUSE_OBSERVED) {
    observed.insert(state.arm());
  } else if (state.mode() != msg::ArmMode::ARM_FAILED && !state.q().empty()) {
    observed.erase(state.arm());
  }
}

void CellSnapshot::update_goal(const bus::Sample<msg::GoalStatus>& sample) {
  if (sample.disposed) return;  // the planner keeps its last goals only; the state of this one stays valid
  const auto known = goals.find(sample.value.arm());
  if (known == goals.end() || newer(sample, known->second)) {
    goals.insert_or_assign(sample.value.arm(), received(sample));
    lost_goals.erase(sample.value.arm());
  }
}

void CellSnapshot::update_heartbeat(const bus::Sample<msg::Heartbeat>& sample) {
  const msg::Heartbeat& heartbeat = sample.value;
  const auto* before = find(heartbeats, heartbeat.node());
  if (heartbeat.kind() == msg::NodeKind::NODE_PLANNER && before && from_another_process(sample, *before)) {
    const auto goal = goals.find(heartbeat.subject());
    const auto was_its_own = [&] { return goal->second.value.node() == heartbeat.node(); };  // not that of its standby
    // A goal that the new process published before its first heartbeat is lost here too; the planner repeats it.
    if (goal != goals.end() && was_its_own() && !is_final(goal->second.value.state()))
      lost_goals.insert(goals.extract(goal));
  }
  heartbeats.insert_or_assign(heartbeat.node(), received(sample));
}

void CellSnapshot::update_obstacle_states(const bus::Sample<msg::ObstacleStates>& sample) {
  const auto& named = sample.value.states();
  if (states && states->writer != sample.writer) {
    std::erase_if(obstacles, [&](const auto& entry) {
      return !entry.second.writer.same_participant(sample.writer) &&
             std::none_of(named.begin(), named.end(), [&](const auto& state) { return state.name() == entry.first; });
    });
  }
  states = received(sample);
}

}  // namespace hecaton::services
