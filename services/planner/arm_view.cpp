#include "services/planner/arm_view.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "planner/local/latency_compensation.hpp"
#include "services/messages/convert.hpp"
#include "services/runtime/state_age.hpp"

namespace hecaton::services {
namespace {

/// An arm has two planners at most. Of further names, an intruder's, the last ones stay, and the planner in charge.
constexpr std::size_t kMostPlanners = 4;
/// A planner's log of set-points does not reach further back [s].
constexpr double kLongestTrackingDelay = 1.0;

}  // namespace

ArmView::ArmView(const planner::Cell& cell, int self)
    : self_(self),
      state_age_limit_(cell.arms[self].parameters.state_age_limit),
      received_(cell.arms.size()),
      observations_(cell.arms.size()),
      planned_at_(cell.arms.size()),
      coordination_(cell.arms.size()),
      goals_(cell.arms.size()) {
  for (const planner::PlannedArm& planned : cell.arms) {
    names_.push_back(planned.arm.name);
    joints_.push_back(planned.arm.model->joints());
    limits_.push_back(planned.arm.limits);
    homes_.push_back(planned.arm.home());
    neighbours_.push_back(static_cast<int>(neighbours_.size()));
    ranges_.push_back(planner::outside_ranges(*planned.arm.model));
  }
}

void ArmView::set_neighbours(std::vector<int> neighbours) {
  for (const int arm : neighbours) {
    if (!is_neighbour(arm)) received_[arm].reset();
  }
  neighbours_ = std::move(neighbours);
}

bool ArmView::is_neighbour(int index) const {
  return std::binary_search(neighbours_.begin(), neighbours_.end(), index);
}

std::optional<std::string> ArmView::apply(const msg::ArmState& state, const bus::EndpointId& writer,
                                          Clock::time_point received) {
  const auto name = std::find(names_.begin(), names_.end(), state.arm());
  if (name == names_.end()) return "ArmState of " + state.arm() + ": no such arm in this cell";
  const auto index = static_cast<std::size_t>(name - names_.begin());
  std::optional<ReceivedState>& known = received_[index];
  if (known && known->writer == writer && state.sequence_number() <= known->sequence) return std::nullopt;
  const auto q = messages::joints_from_message(state.q(), {"ArmState of ", state.arm(), ": q"}, joints_[index]);
  if (!q) return q.error;
  const auto qd = messages::joints_from_message(state.qd(), {"ArmState of ", state.arm(), ": qd"}, joints_[index]);
  if (!qd) return qd.error;
  if (!std::isfinite(state.command_age())) {
    return "ArmState of " + state.arm() + ": command_age = " + std::to_string(state.command_age()) +
           " must be a finite number";
  }
  if (!(state.tracking_delay() >= 0.0 && state.tracking_delay() <= kLongestTrackingDelay)) {
    return "ArmState of " + state.arm() + ": tracking_delay = " + std::to_string(state.tracking_delay()) +
           " must be 0 to 1 s";
  }
  if (!(state.speed_scaling() >= 0.0 && state.speed_scaling() <= 1.0)) {
    return "ArmState of " + state.arm() + ": speed_scaling = " + std::to_string(state.speed_scaling()) +
           " must be 0 to 1";
  }
  const std::vector<planner::MotionRange>& ranges = ranges_[index];
  std::vector<planner::MotionRange> outside;
  const bool described = state.outside_lower().size() == ranges.size() && state.outside_upper().size() == ranges.size();
  if (!described && !(state.outside_lower().empty() && state.outside_upper().empty())) {
    return "ArmState of " + state.arm() + ": outside_lower and outside_upper must have " +
           std::to_string(ranges.size()) + " values, or none";
  }
  for (std::size_t i = 0; described && i < ranges.size(); ++i) {
    const planner::MotionRange between{state.outside_lower()[i], state.outside_upper()[i]};
    if (!(between.lower >= ranges[i].lower && between.lower <= between.upper && between.upper <= ranges[i].upper)) {
      return "ArmState of " + state.arm() + ": outside_lower and outside_upper must be within the joint's range";
    }
    outside.push_back(between);
  }
  SenderClock clock = known && known->writer == writer ? known->clock : SenderClock();
  const Clock::time_point sent = measured_at(state, received, clock);
  // Nothing has stopped the arm that others move when its device fails.
  const bool failed = state.mode() == msg::ArmMode::ARM_FAILED;
  const bool foreign = state.mode() == msg::ArmMode::ARM_OBSERVED || (failed && known && known->foreign);
  known = ReceivedState{*q,
                        *qd,
                        state.mode(),
                        state.cause(),
                        state.term(),
                        state.command_sequence_number(),
                        state.command_age(),
                        state.tracking_delay(),
                        state.speed_scaling(),
                        {state.planner(), state.newest_term()},
                        state.stamp_ns(),
                        state.sequence_number(),
                        writer,
                        sent,
                        clock,
                        std::move(outside),
                        foreign};
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
    // A status of an earlier goal does not concern the present one.
    if (goals_[index] == status.goal()) seen.has_goal = false;
    return std::nullopt;
  }
  const auto q_goal =
      messages::joints_from_message(status.q_goal(), {"GoalStatus of ", status.arm(), ": q_goal"}, joints_[index]);
  if (!q_goal) return q_goal.error;
  goals_[index] = status.goal();
  seen.q_goal = *q_goal;
  seen.has_goal = true;
  seen.priority = status.priority();
  return std::nullopt;
}

const std::vector<planner::MotionRange>& ArmView::outside(int index, Clock::time_point now) const {
  const bool fresh = age(index, now) <= state_age_limit_;
  return fresh && !received_[index]->outside.empty() ? received_[index]->outside : ranges_[index];
}

int ArmView::index_of(const std::string& name) const {
  const auto found = std::find(names_.begin(), names_.end(), name);
  return found == names_.end() ? -1 : static_cast<int>(found - names_.begin());
}

std::optional<std::string> ArmView::apply(const msg::CoupledPlan& plan) {
  const std::string what = "CoupledPlan of " + plan.arm();
  const int proposer = index_of(plan.arm());
  if (proposer < 0) return what + ": no such arm in this cell";
  auto received = std::make_shared<planner::CoupledPlan>();
  received->number = plan.number();
  const bool withdrawn = plan.arms().empty();
  if (withdrawn && (plan.points() != 0 || !plan.q().empty())) return what + ": it has points, but no arms";
  std::size_t joints = 0;
  for (const std::string& name : plan.arms()) {
    const int arm = index_of(name);
    if (arm < 0) return what + ": arm " + name + " is not in this cell";
    if (!received->arms.empty() && arm <= received->arms.back()) return what + ": its arms are not in the cell's order";
    received->arms.push_back(arm);
    joints += static_cast<std::size_t>(joints_[arm]);
  }
  const bool own = std::find(received->arms.begin(), received->arms.end(), proposer) != received->arms.end();
  if (!withdrawn && !own) return what + ": its proposer is not one of its arms";
  if (!withdrawn && plan.points() == 0) return what + ": it has arms, but no points";
  // Bounds the number of points by the received data: every arm has joints.
  if (plan.q().size() != joints * plan.points()) {
    return what + ": " + std::to_string(plan.q().size()) + " joint values must be " + std::to_string(plan.points()) +
           " points of " + std::to_string(joints) + " joints";
  }
  auto from = plan.q().begin();
  for (std::uint32_t point = 0; point < plan.points(); ++point) {
    auto& at = received->points.emplace_back();
    for (const int arm : received->arms) {
      const auto q = messages::joints_from_message({from, from + joints_[arm]}, what + ": q", joints_[arm]);
      if (!q) return q.error;
      at.push_back(*q);
      from += joints_[arm];
    }
  }
  coordination_of(proposer, plan.node()).proposal = withdrawn ? nullptr : std::move(received);
  return std::nullopt;
}

std::optional<std::string> ArmView::apply(const msg::CoupledPlanProgress& progress) {
  const int arm = index_of(progress.arm());
  if (arm < 0) return "CoupledPlanProgress of " + progress.arm() + ": no such arm in this cell";
  const int proposer = progress.proposer().empty() ? -1 : index_of(progress.proposer());
  coordination_of(arm, progress.node()).progress = {proposer, progress.number(), progress.reached()};
  return std::nullopt;
}

ArmView::Coordination& ArmView::coordination_of(int arm, const std::string& planner) {
  std::vector<Coordination>& all = coordination_[arm];
  const auto found =
      std::find_if(all.begin(), all.end(), [&](const Coordination& entry) { return entry.planner == planner; });
  if (found == all.end()) {
    if (all.size() == kMostPlanners) {
      const std::string commands = received_[arm] ? received_[arm]->lease.planner : std::string();
      all.erase(all.begin() + (all.front().planner == commands ? 1 : 0));
    }
    return all.emplace_back(Coordination{planner, {}, nullptr});
  }
  std::rotate(found, found + 1, all.end());
  return all.back();
}

const ArmView::Coordination* ArmView::active_coordination(int arm) const {
  const std::vector<Coordination>& all = coordination_[arm];
  if (all.empty()) return nullptr;
  const std::optional<ReceivedState>& known = received_[arm];
  if (!known) return &all.back();
  // A braking arm may continue: a late command ends its stop profile.
  if (known->mode != msg::ArmMode::ARM_RUNNING && known->mode != msg::ArmMode::ARM_BRAKING) return nullptr;
  const std::string& commands = known->lease.planner;
  if (commands.empty()) return &all.back();
  const auto found =
      std::find_if(all.begin(), all.end(), [&](const Coordination& entry) { return entry.planner == commands; });
  return found == all.end() ? nullptr : &*found;
}

double ArmView::age(int index, Clock::time_point now) const {
  if (!received_[index]) return std::numeric_limits<double>::infinity();
  return std::max(0.0, std::chrono::duration<double>(now - received_[index]->at).count());
}

bool ArmView::lost(int index, Clock::time_point now, const CellModeView& mode) const {
  const bool current = std::chrono::duration<double>(now - mode.received()).count() <= state_age_limit_;
  return index != self_ && current && age(index, now) > state_age_limit_ && mode.lost(names_[index]) != nullptr;
}

// A later state gives a smaller stop set. The supervisor's last state may be later or earlier than this planner's, and
// the braking delay is bounded from the last state that any node has received.
void ArmView::observe_lost(int index, const msg::LostArm& lost) {
  const std::optional<ReceivedState>& known = received_[index];
  const bool own_is_newer = known && known->stamp_ns >= lost.stamp_ns();
  const auto q = messages::joints_from_message(lost.q(), {"LostArm ", lost.arm(), ": q"}, joints_[index]);
  const auto qd = messages::joints_from_message(lost.qd(), {"LostArm ", lost.arm(), ": qd"}, joints_[index]);
  planner::ArmObservation& seen = observations_[index];
  seen.known = own_is_newer || (q && qd);
  if (!seen.known) return;
  const planner::ReachableStopSet region = planner::reachable_stop_set(
      limits_[index], own_is_newer ? known->q : *q, own_is_newer ? known->qd : *qd, lost.braking_delay_bound());
  seen.q = region.q;
  seen.qd = planner::JointVector::Zero(joints_[index]);
  seen.position_uncertainty = region.position_uncertainty;
  seen.age = 0.0;
  seen.plans = seen.foreign = false;
}

void ArmView::observe_far(int index) {
  planner::ArmObservation& seen = observations_[index];
  seen.known = true;
  seen.q = homes_[index];
  seen.qd = planner::JointVector::Zero(joints_[index]);
  seen.age = 0.0;
  seen.plans = seen.foreign = false;
}

std::span<const planner::ArmObservation> ArmView::observe(Clock::time_point now, const CellModeView& mode) {
  for (std::size_t i = 0; i < received_.size(); ++i) {
    planner::ArmObservation& seen = observations_[i];
    seen.position_uncertainty.resize(0);
    seen.speed = mode.speed(names_[i]);
    const bool is_lost = lost(static_cast<int>(i), now, mode);
    const Coordination* coordination = is_lost ? nullptr : active_coordination(static_cast<int>(i));
    seen.progress = coordination != nullptr ? coordination->progress : planner::CoupledPlanProgress{};
    seen.proposal = coordination != nullptr ? coordination->proposal : nullptr;
    if (is_lost) {
      observe_lost(static_cast<int>(i), *mode.lost(names_[i]));
      continue;
    }
    if (!is_neighbour(static_cast<int>(i))) {
      observe_far(static_cast<int>(i));
      continue;
    }
    seen.known = received_[i].has_value();
    if (!seen.known) continue;
    seen.q = received_[i]->q;
    seen.qd = received_[i]->qd;
    seen.age = age(static_cast<int>(i), now);
    seen.foreign = received_[i]->foreign;
    const bool plans = received_[i]->mode == msg::ArmMode::ARM_RUNNING && mode.order(names_[i]) == msg::Mode::MODE_RUN;
    if (plans) planned_at_[i] = now;
    // An arm that lags still moves as it was planned, and begins its stop that much later.
    const std::chrono::duration<double> lag(received_[i]->tracking_delay);
    seen.plans = plans || (!seen.foreign && planned_at_[i] && now - *planned_at_[i] < lag);
  }
  return observations_;
}

}  // namespace hecaton::services
