#include "services/planner/arm_view.hpp"

#include <algorithm>
#include <limits>

#include "planner/local/rest_region.hpp"
#include "services/messages/convert.hpp"

namespace hecaton::services {

ArmView::ArmView(const planner::Cell& cell, int self)
    : self_(self),
      state_age_limit_(cell.arms[self].parameters.state_age_limit),
      heard_(cell.arms.size()),
      observations_(cell.arms.size()),
      said_(cell.arms.size()),
      goals_(cell.arms.size()) {
  for (const planner::PlannedArm& planned : cell.arms) {
    names_.push_back(planned.arm.name);
    joints_.push_back(planned.arm.model->joints());
    limits_.push_back(planned.arm.limits);
  }
}

std::optional<std::string> ArmView::apply(const msg::ArmState& state, const bus::EndpointId& writer,
                                          Clock::time_point received) {
  const auto name = std::find(names_.begin(), names_.end(), state.arm());
  if (name == names_.end()) return "ArmState of " + state.arm() + ": no such arm in this cell";
  const auto index = static_cast<std::size_t>(name - names_.begin());
  std::optional<Heard>& heard = heard_[index];
  if (heard && heard->writer == writer && state.sequence_number() <= heard->sequence) return std::nullopt;
  const auto q = messages::joints_from_message(state.q(), {"ArmState of ", state.arm(), ": q"}, joints_[index]);
  if (!q) return q.error;
  const auto qd = messages::joints_from_message(state.qd(), {"ArmState of ", state.arm(), ": qd"}, joints_[index]);
  if (!qd) return qd.error;
  if (!(state.command_age() >= 0.0)) {
    return "ArmState of " + state.arm() + ": command_age = " + std::to_string(state.command_age()) +
           " must be at least 0 s";
  }
  SenderClock clock = heard && heard->writer == writer ? heard->clock : SenderClock();
  const Clock::time_point sent = clock.sent(state.stamp_ns(), received);
  heard = Heard{*q,
                *qd,
                state.mode(),
                state.cause(),
                state.term(),
                state.command_sequence_number(),
                state.command_age(),
                {state.planner(), state.newest_term()},
                state.stamp_ns(),
                state.sequence_number(),
                writer,
                sent,
                clock};
  return std::nullopt;
}

std::optional<std::string> ArmView::apply(const msg::GoalStatus& status) {
  const auto name = std::find(names_.begin(), names_.end(), status.arm());
  if (name == names_.end()) return "GoalStatus of " + status.arm() + ": no such arm in this cell";
  const auto index = static_cast<std::size_t>(name - names_.begin());
  planner::ArmObservation& seen = observations_[index];
  const bool under_way =
      status.state() == msg::GoalState::GOAL_ACTIVE || status.state() == msg::GoalState::GOAL_BLOCKED;
  if (!under_way) {
    // A status of an earlier goal says nothing about the present one.
    if (goals_[index] == status.goal()) seen.has_goal = false;
    return std::nullopt;
  }
  const auto q_goal =
      messages::joints_from_message(status.q_goal(), {"GoalStatus of ", status.arm(), ": q_goal"}, joints_[index]);
  if (!q_goal) return q_goal.error;
  goals_[index] = status.goal();
  seen.q_goal = *q_goal;
  seen.has_goal = true;
  seen.claim = status.priority();
  return std::nullopt;
}

int ArmView::index_of(const std::string& name) const {
  const auto found = std::find(names_.begin(), names_.end(), name);
  return found == names_.end() ? -1 : static_cast<int>(found - names_.begin());
}

std::optional<std::string> ArmView::apply(const msg::CoupledPlan& plan) {
  const std::string what = "CoupledPlan of " + plan.arm();
  const int proposer = index_of(plan.arm());
  if (proposer < 0) return what + ": no such arm in this cell";
  auto heard = std::make_shared<planner::CoupledPlan>();
  heard->number = plan.number();
  const bool withdrawn = plan.arms().empty();
  if (withdrawn && (plan.points() != 0 || !plan.q().empty())) return what + ": it has points, but no arms";
  std::size_t joints = 0;
  for (const std::string& name : plan.arms()) {
    const int arm = index_of(name);
    if (arm < 0) return what + ": arm " + name + " is not in this cell";
    if (!heard->arms.empty() && arm <= heard->arms.back()) return what + ": its arms are not in the cell's order";
    heard->arms.push_back(arm);
    joints += static_cast<std::size_t>(joints_[arm]);
  }
  const bool own = std::find(heard->arms.begin(), heard->arms.end(), proposer) != heard->arms.end();
  if (!withdrawn && !own) return what + ": its proposer is not one of its arms";
  if (!withdrawn && plan.points() == 0) return what + ": it has arms, but no points";
  // Bounds the number of points by what really came over the wire: every arm has joints.
  if (plan.q().size() != joints * plan.points()) {
    return what + ": " + std::to_string(plan.q().size()) + " joint values must be " + std::to_string(plan.points()) +
           " points of " + std::to_string(joints) + " joints";
  }
  auto from = plan.q().begin();
  for (std::uint32_t point = 0; point < plan.points(); ++point) {
    auto& at = heard->points.emplace_back();
    for (const int arm : heard->arms) {
      const auto q = messages::joints_from_message({from, from + joints_[arm]}, what + ": q", joints_[arm]);
      if (!q) return q.error;
      at.push_back(*q);
      from += joints_[arm];
    }
  }
  said_by(proposer, plan.node()).proposal = withdrawn ? nullptr : std::move(heard);
  return std::nullopt;
}

std::optional<std::string> ArmView::apply(const msg::CoupledPlanProgress& progress) {
  const int arm = index_of(progress.arm());
  if (arm < 0) return "CoupledPlanProgress of " + progress.arm() + ": no such arm in this cell";
  const int proposer = progress.proposer().empty() ? -1 : index_of(progress.proposer());
  said_by(arm, progress.node()).progress = {proposer, progress.number(), progress.reached()};
  return std::nullopt;
}

ArmView::Said& ArmView::said_by(int arm, const std::string& planner) {
  std::vector<Said>& all = said_[arm];
  const auto found = std::find_if(all.begin(), all.end(), [&](const Said& said) { return said.planner == planner; });
  if (found == all.end()) return all.emplace_back(Said{planner, {}, nullptr});
  std::rotate(found, found + 1, all.end());
  return all.back();
}

const ArmView::Said* ArmView::company_of(int arm) const {
  const std::vector<Said>& all = said_[arm];
  if (all.empty()) return nullptr;
  const std::optional<Heard>& heard = heard_[arm];
  if (!heard) return &all.back();
  // On its own stop profile it may still be on its way: the next command is late, and ends that.
  if (heard->mode != msg::ArmMode::ARM_RUNNING && heard->mode != msg::ArmMode::ARM_BRAKING) return nullptr;
  const std::string& commands = heard->mandate.planner;
  if (commands.empty()) return &all.back();
  const auto found = std::find_if(all.begin(), all.end(), [&](const Said& said) { return said.planner == commands; });
  return found == all.end() ? nullptr : &*found;
}

double ArmView::age(int index, Clock::time_point now) const {
  if (!heard_[index]) return std::numeric_limits<double>::infinity();
  return std::max(0.0, std::chrono::duration<double>(now - heard_[index]->at).count());
}

bool ArmView::lost(int index, Clock::time_point now, const CellModeView& mode) const {
  const bool current = std::chrono::duration<double>(now - mode.received()).count() <= state_age_limit_;
  return index != self_ && current && age(index, now) > state_age_limit_ && mode.lost(names_[index]) != nullptr;
}

// The later the state, the smaller the region; but what the supervisor heard last may be later or earlier than what
// this planner did, and only from the last that anybody heard does it count how long the arm moved on.
void ArmView::observe_lost(int index, const msg::LostArm& lost) {
  const std::optional<Heard>& heard = heard_[index];
  const bool own_is_newer = heard && heard->stamp_ns >= lost.stamp_ns();
  const auto q = messages::joints_from_message(lost.q(), {"LostArm ", lost.arm(), ": q"}, joints_[index]);
  const auto qd = messages::joints_from_message(lost.qd(), {"LostArm ", lost.arm(), ": qd"}, joints_[index]);
  planner::ArmObservation& seen = observations_[index];
  seen.known = own_is_newer || (q && qd);
  if (!seen.known) return;
  const planner::RestRegion region = planner::rest_region(limits_[index], own_is_newer ? heard->q : *q,
                                                          own_is_newer ? heard->qd : *qd, lost.moved_for());
  seen.q = region.q;
  seen.qd = planner::JointVector::Zero(joints_[index]);
  seen.stray = region.stray;
  seen.age = 0.0;
  seen.plans = false;
}

std::span<const planner::ArmObservation> ArmView::observe(Clock::time_point now, const CellModeView& mode) {
  for (std::size_t i = 0; i < heard_.size(); ++i) {
    planner::ArmObservation& seen = observations_[i];
    seen.stray.resize(0);
    const bool gone = lost(static_cast<int>(i), now, mode);
    const Said* said = gone ? nullptr : company_of(static_cast<int>(i));
    seen.progress = said != nullptr ? said->progress : planner::CoupledPlanProgress{};
    seen.proposal = said != nullptr ? said->proposal : nullptr;
    if (gone) {
      observe_lost(static_cast<int>(i), *mode.lost(names_[i]));
      continue;
    }
    if (!heard_[i]) continue;
    seen.q = heard_[i]->q;
    seen.qd = heard_[i]->qd;
    seen.age = age(static_cast<int>(i), now);
    seen.known = true;
    seen.plans = heard_[i]->mode == msg::ArmMode::ARM_RUNNING && mode.order(names_[i]) == msg::Mode::MODE_RUN;
  }
  return observations_;
}

}  // namespace hecaton::services
