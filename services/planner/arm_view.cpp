#include "services/planner/arm_view.hpp"

#include <algorithm>
#include <limits>

#include "services/bus/convert.hpp"

namespace hecaton::services {

ArmView::ArmView(const planner::Cell& cell)
    : heard_(cell.arms.size()), observations_(cell.arms.size()), goals_(cell.arms.size()) {
  for (const planner::PlannedArm& planned : cell.arms) {
    names_.push_back(planned.arm.name);
    joints_.push_back(planned.arm.model->joints());
  }
}

std::string ArmView::apply(const msg::ArmState& state, const bus::EndpointId& writer, Clock::time_point received) {
  const auto name = std::find(names_.begin(), names_.end(), state.arm());
  if (name == names_.end()) return "ArmState of " + state.arm() + ": no such arm in this cell";
  const auto index = static_cast<std::size_t>(name - names_.begin());
  std::optional<Heard>& heard = heard_[index];
  if (heard && heard->writer == writer && state.sequence_number() <= heard->sequence) return {};
  const std::string what = "ArmState of " + state.arm();
  const auto q = bus::joints_from_message(state.q(), what + ": q", joints_[index]);
  if (!q) return q.error;
  const auto qd = bus::joints_from_message(state.qd(), what + ": qd", joints_[index]);
  if (!qd) return qd.error;
  SenderClock clock = heard && heard->writer == writer ? heard->clock : SenderClock();
  const Clock::time_point sent = clock.sent(state.stamp_ns(), received);
  heard = Heard{*q,
                *qd,
                state.mode(),
                state.reason(),
                state.term(),
                state.command_sequence_number(),
                {state.planner(), state.newest_term()},
                state.sequence_number(),
                writer,
                sent,
                clock};
  return {};
}

std::string ArmView::apply(const msg::GoalStatus& status) {
  const auto name = std::find(names_.begin(), names_.end(), status.arm());
  if (name == names_.end()) return "GoalStatus of " + status.arm() + ": no such arm in this cell";
  const auto index = static_cast<std::size_t>(name - names_.begin());
  planner::ArmObservation& seen = observations_[index];
  const bool under_way = status.state() == msg::GOAL_ACTIVE || status.state() == msg::GOAL_BLOCKED;
  if (!under_way) {
    // A status of an earlier goal says nothing about the present one.
    if (goals_[index] == status.goal()) seen.has_goal = false;
    return {};
  }
  const auto q_goal =
      bus::joints_from_message(status.q_goal(), "GoalStatus of " + status.arm() + ": q_goal", joints_[index]);
  if (!q_goal) return q_goal.error;
  goals_[index] = status.goal();
  seen.q_goal = *q_goal;
  seen.has_goal = true;
  seen.claim = status.claim();
  return {};
}

double ArmView::age(int index, Clock::time_point now) const {
  if (!heard_[index]) return std::numeric_limits<double>::infinity();
  return std::max(0.0, std::chrono::duration<double>(now - heard_[index]->at).count());
}

std::span<const planner::ArmObservation> ArmView::observe(Clock::time_point now, const CellModeView& mode) {
  for (std::size_t i = 0; i < heard_.size(); ++i) {
    if (!heard_[i]) continue;
    planner::ArmObservation& seen = observations_[i];
    seen.q = heard_[i]->q;
    seen.qd = heard_[i]->qd;
    seen.age = age(static_cast<int>(i), now);
    seen.known = true;
    seen.plans = heard_[i]->mode == msg::ARM_RUNNING && mode.order(names_[i]) == ArmOrder::kRun;
  }
  return observations_;
}

}  // namespace hecaton::services
