#include "services/planner/planner_service.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "planner/model/fnv1a.hpp"
#include "services/messages/names.hpp"
#include "services/runtime/cause.hpp"
#include "services/runtime/cell_nodes.hpp"
#include "services/runtime/join.hpp"
#include "services/runtime/log.hpp"
#include "services/runtime/process_info.hpp"

namespace hecaton::services {
namespace {

/// Each arm draws its own subspaces, the same ones in every run.
planner::ArmPlannerOptions planner_options(const planner::Cell& cell, int arm) {
  const std::uint64_t seed = planner::fnv1a(cell.arms[arm].arm.name);
  planner::ArmPlannerOptions options;
  options.control_period = cell.timing.control_period;
  options.motion_seed = options.rollout_seed = options.route_seed = seed;
  // Milliseconds: greater than any number that this planner used before it was restarted.
  options.plan_numbers_after = static_cast<std::uint32_t>(stamp_now() / 1'000'000);
  return options;
}

}  // namespace

PlannerService::Place PlannerService::place_of(const config::CellFile& file, int arm, const std::string& host) {
  const std::vector<PlacedNode> planners = planners_of(file, static_cast<std::size_t>(arm));
  const std::size_t index = index_on(planners, host);
  return {.arm = file.cell.arms[arm].arm.name,
          .node = planners[index].node,
          .host = host.empty() ? planners[index].host : host,
          .first = index == 0,
          .alone = planners.size() == 1};
}

PlannerService::PlannerService(const config::CellFile& file, int arm, const ServiceOptions& options,
                               const ShutdownSignal& shutdown)
    : PlannerService(file, arm, options, shutdown, place_of(file, arm, options.host)) {}

PlannerService::PlannerService(const config::CellFile& file, int arm, const ServiceOptions& options,
                               const ShutdownSignal& shutdown, const Place& place)
    : participant_(make_participant(file, options, place.node, &mailbox_)),
      modes_(participant_, &modes_mailbox_),
      subscriptions_(participant_, mailbox_, place.arm),
      publishers_{.commands = bus::Writer<msg::ArmCommand>(participant_),
                  .statuses = bus::Writer<msg::GoalStatus>(participant_),
                  .coordination = CoordinationPublisher(participant_, names_of(file.cell), arm, place.node),
                  .heartbeat = Pulse(participant_, {place.node, msg::NodeKind::NODE_PLANNER, place.arm, place.host},
                                     pulse_timing(file, options))},
      loop_(nanoseconds(file.cell.timing.control_period), shutdown),
      failover_({.arm = place.arm, .node = place.node, .first = place.first, .alone = place.alone}, options.memory,
                file.cell.arms[arm].arm.model->joints()),
      goals_(place.arm, place.node),
      resolver_(planner::CellGeometry(arms_of(file.cell), arm)),
      planner_(file.cell, arm, place.node, planner_options(file.cell, arm)),
      searches_(file.cell, arm),
      hold_(make_cause(msg::CauseKind::CAUSE_STARTING, {}, "has just started")) {}

void PlannerService::run() {
  const std::string& arm = planner_.name();
  log_info("planner started",
           {{"arm", arm}, {"period_ms", std::chrono::duration<double>(loop_.period()).count() * 1e3}});
  const auto put_in_charge = [&] {
    (void)modes_mailbox_.take_events();
    modes_.update();
    return failover_.hear(modes_.view().lease(arm));
  };
  while (failover_.in_charge() ? loop_.next() : loop_.next(modes_mailbox_, put_in_charge)) run_period(Clock::now());
  log_info("planner ends", {{"arm", arm}});
}

void PlannerService::run_period(Clock::time_point now) {
  const std::vector<msg::GoalStatus> statuses = subscriptions_.update(planner_);
  (void)modes_mailbox_.take_events();
  modes_.update();
  const ArmLease ordered = modes_.view().lease(planner_.name());
  failover_.update({.now = now, .ordered = ordered, .own = planner_.own_arm(), .statuses = statuses}, goals_);
  look_at_threads(now);
  if (failover_.ready()) handle_goals(now);
  plan(now);
  publish_statuses(now);
  if (publishers_.heartbeat.due(now, loop_.period() / 2)) beat(now);
}

void PlannerService::look_at_threads(Clock::time_point now) {
  HangingThreads hanging;
  const auto silence = resolver_.silence(now);
  if (silence > kLongestWait)
    hanging.resolver = complaint_about("the thread that resolves goals", silence, kLongestWait);
  const auto search = searches_.hanging(now);
  hanging.any = hanging.resolver ? hanging.resolver : search;
  if (hanging.any.has_value() != hanging_.any.has_value()) {
    log_warning(hanging.any ? "a thread does not answer" : "all threads answer again",
                {{"reason", hanging.any.value_or("")}});
  }
  hanging_ = std::move(hanging);
}

void PlannerService::handle_goals(Clock::time_point now) {
  for (const msg::Goal& goal : subscriptions_.take_goals()) goals_.receive(goal, now);
  for (const GoalAnswer& answer : resolver_.answers()) goals_.answer(answer, now);

  if (!failover_.in_charge()) goals_.wait_from(now);
  if (failover_.in_charge() && hanging_.resolver) {
    goals_.refuse_all(make_cause(msg::CauseKind::CAUSE_GOAL_NOT_RESOLVED, {}, *hanging_.resolver));
  }
  if (const auto cause = planner_.cannot_resolve()) {
    goals_.refuse_waiting(now, kLongestWait, *cause);
  } else if (const auto goal = goals_.next_question()) {
    resolver_.ask(planner_.question(*goal, now));
  }
}

void PlannerService::plan(Clock::time_point now) {
  std::optional<msg::Cause> hold = planner_.hold(now, modes_.view());
  if (hold != hold_) log_info(hold ? "holds" : "may move", {{"reason", hold ? hold->text() : std::string()}});
  hold_ = std::move(hold);

  const auto planned = planner_.step(
      {.now = now,
       .missed = static_cast<double>(loop_.skipped()) * std::chrono::duration<double>(loop_.period()).count(),
       .mode = modes_.view(),
       .term = failover_.duty().term(),
       .commands = failover_.in_charge(),
       .continues = failover_.continues(),
       .hold = hold_.has_value(),
       .goal = goals_.take_change()},
      searches_);
  if (planned) {
    if (planned->inputs.number > 0) send_command(now);
    planner_.plan_ahead(*planned, searches_);
    if (failover_.in_charge()) {
      publishers_.coordination.publish(planner_.planner().proposal(), planner_.planner().progress());
    } else {
      publishers_.coordination.resign();
    }
  }
  const auto progress = reporter_.report({.planner = planner_,
                                          .planned = planned,
                                          .hold = hold_,
                                          .q_goal = goals_.has_active() ? &goals_.q_goal() : nullptr});
  if (progress) goals_.progress(*progress, now);
  planner_.note_reaction(Clock::now() - now);
}

// Where this process was stopped in the midst of planning, the command follows from older states than was counted on:
// it is lost like a datagram, and the drive knows what to do then.
void PlannerService::send_command(Clock::time_point now) {
  planner_.command().stamp_ns(stamp_now());
  if (Clock::now() - now > planner_.reaction() + loop_.period()) return;
  (void)publishers_.commands.write(
      planner_.command());  // the bus logs a refusal; the next command is due in one period
}

void PlannerService::publish_statuses(Clock::time_point now) {
  for (msg::GoalStatus& status : failover_.release(goals_.take_statuses(), goals_, now)) {
    status.stamp_ns(stamp_now());
    (void)publishers_.statuses.write(status);
    const bool passing =
        status.state() == msg::GoalState::GOAL_ACTIVE || status.state() == msg::GoalState::GOAL_BLOCKED;
    (passing ? log_debug : log_info)("goal", {{"goal", status.goal()},
                                              {"state", text(status.state())},
                                              {"elapsed", status.elapsed()},
                                              {"distance", status.distance_to_goal()},
                                              {"reason", status.cause().text()}});
  }
}

void PlannerService::beat(Clock::time_point now) {
  const CellModeView& mode = modes_.view();
  const LivePlanner::OldestInput oldest = planner_.oldest_input(now, mode);
  const bool starved = oldest.age > planner_.state_age_limit() || !mode.heard();
  Vital vital;
  vital.term = mode.term();
  vital.lease = failover_.duty().mandate();
  vital.oldest_input_age = std::isfinite(oldest.age) ? oldest.age : 1e9;
  vital.oldest_input = oldest.topic_and_key;
  vital.state = failover_.in_charge() ? msg::NodeState::NODE_RUNNING : msg::NodeState::NODE_STANDBY;
  if (starved || hanging_.any) vital.state = msg::NodeState::NODE_DEGRADED;
  if (starved) {
    vital.cause =
        hold_ ? *hold_ : make_cause(oldest.kind, oldest.topic_and_key, oldest.topic_and_key + " is old or missing");
  }
  if (hanging_.any) {
    const std::string also = starved ? "; " + vital.cause.text() : "";
    vital.cause = make_cause(msg::CauseKind::CAUSE_NODE_SILENT, failover_.node(), *hanging_.any + also);
  }
  publishers_.heartbeat.beat(now, vital, loop_.statistics());
}

}  // namespace hecaton::services
