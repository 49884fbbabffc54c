#include "services/supervisor/cell_snapshot.hpp"

#include <algorithm>
#include <tuple>

#include "services/runtime/goal_state.hpp"

namespace hecaton::services {
namespace {

bool newer(const bus::Sample<msg::GoalStatus>& sample, const Heard<msg::GoalStatus>& known) {
  // Sequence numbers order one planner's statuses; another planner of the same term took over later.
  if (sample.writer != known.writer && sample.value.term() == known.value.term()) return true;
  return std::make_tuple(sample.value.term(), sample.value.sequence_number()) >=
         std::make_tuple(known.value.term(), known.value.sequence_number());
}

/// Told by another process than `before`. Process ids do not say it: a container gives its processes the same ones
/// again. An endpoint's id is partly random, and should that ever repeat, a new process counts its heartbeats anew.
bool other_life(const bus::Sample<msg::Heartbeat>& sample, const Heard<msg::Heartbeat>& before) {
  return sample.writer != before.writer || sample.value.sequence_number() < before.value.sequence_number();
}

}  // namespace

void CellSnapshot::take_goal(const bus::Sample<msg::GoalStatus>& sample) {
  if (sample.disposed) return;  // the planner keeps only its last goals; what became of this one stays true
  const auto known = goals.find(sample.value.arm());
  if (known == goals.end() || newer(sample, known->second)) {
    goals.insert_or_assign(sample.value.arm(), heard(sample));
    lost_goals.erase(sample.value.arm());
  }
}

void CellSnapshot::take_heartbeat(const bus::Sample<msg::Heartbeat>& sample) {
  const msg::Heartbeat& heartbeat = sample.value;
  const auto* before = find(heartbeats, heartbeat.node());
  if (heartbeat.kind() == msg::NodeKind::NODE_PLANNER && before && other_life(sample, *before)) {
    const auto goal = goals.find(heartbeat.subject());
    const auto was_its_own = [&] { return goal->second.value.node() == heartbeat.node(); };  // not its standby's
    // Should the new one have told of a goal before its first heartbeat came: it repeats that.
    if (goal != goals.end() && was_its_own() && !is_over(goal->second.value.state()))
      lost_goals.insert(goals.extract(goal));
  }
  heartbeats.insert_or_assign(heartbeat.node(), heard(sample));
}

void CellSnapshot::take_states(const bus::Sample<msg::ObstacleStates>& sample) {
  const auto& named = sample.value.states();
  if (states && states->writer != sample.writer) {
    std::erase_if(obstacles, [&](const auto& entry) {
      return !entry.second.writer.same_participant(sample.writer) &&
             std::none_of(named.begin(), named.end(), [&](const auto& state) { return state.name() == entry.first; });
    });
  }
  states = heard(sample);
}

}  // namespace hecaton::services
