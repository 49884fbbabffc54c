#include "services/planner/planner_service.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "planner/model/fnv1a.hpp"
#include "services/messages/names.hpp"
#include "services/planner/coordination_messages.hpp"
#include "services/runtime/cause.hpp"
#include "services/runtime/cell_nodes.hpp"
#include "services/runtime/join.hpp"
#include "services/runtime/log.hpp"
#include "services/runtime/orders.hpp"
#include "services/runtime/process_info.hpp"

namespace hecaton::services {
namespace {

/// Each arm has its own random seeds, the same in every run.
planner::ArmPlannerOptions planner_options(const planner::Cell& cell, int arm) {
  const std::uint64_t seed = planner::fnv1a(cell.arms[arm].arm.name);
  planner::ArmPlannerOptions options;
  options.control_period = cell.timing.control_period;
  options.motion_seed = options.rollout_seed = options.route_seed = seed;
  // In milliseconds: greater than the numbers of this planner before a restart.
  options.plan_numbers_after = static_cast<std::uint32_t>(stamp_now() / 1'000'000);
  return options;
}

}  // namespace

PlannerSubscriptions::PlannerSubscriptions(bus::Participant& participant, bus::Mailbox& mailbox,
                                           const LivePlanner& planner)
    : arm_(planner.name()),
      participant_(participant),
      mailbox_(mailbox),
      neighbours_(planner.neighbours()),
      arm_states_(participant, &mailbox, {.keys = planner.neighbour_names()}),
      obstacle_shapes_(participant, &mailbox),
      obstacle_states_(participant, &mailbox),
      scans_(participant, &mailbox),
      goals_(participant, &mailbox),
      statuses_(participant, &mailbox, {.keys = planner.neighbour_names()}),
      proposals_(participant, &mailbox),
      progress_(participant, &mailbox) {}

void PlannerSubscriptions::report_unusable(const std::optional<std::string>& unusable) {
  if (!unusable || unusable == last_warning_) return;
  last_warning_ = unusable;
  log_warning("message ignored", {{"reason", *unusable}});
}

void PlannerSubscriptions::follow_neighbours(const LivePlanner& planner) {
  if (planner.neighbours() == neighbours_) return;
  neighbours_ = planner.neighbours();
  arm_states_ = bus::Reader<msg::ArmState>(participant_, &mailbox_, {.keys = planner.neighbour_names()});
  statuses_ = bus::Reader<msg::GoalStatus>(participant_, &mailbox_, {.keys = planner.neighbour_names()});
}

std::vector<msg::GoalStatus> PlannerSubscriptions::update(LivePlanner& planner) {
  (void)mailbox_.take_events();
  follow_neighbours(planner);
  ArmView& arms = planner.arms();
  std::vector<msg::GoalStatus> usable;
  for (const auto& sample : arm_states_.take()) {
    if (!sample.disposed) report_unusable(arms.apply(sample.value, sample.writer, sample.received));
  }
  for (auto& sample : statuses_.take()) {
    if (sample.disposed) continue;
    const auto unusable = arms.apply(sample.value);
    report_unusable(unusable);
    if (!unusable) usable.push_back(std::move(sample.value));
  }
  for (const auto& sample : proposals_.take()) {
    if (!sample.disposed && sample.value.arm() != arm_) report_unusable(arms.apply(sample.value));
  }
  for (const auto& sample : progress_.take()) {
    if (!sample.disposed && sample.value.arm() != arm_) report_unusable(arms.apply(sample.value));
  }
  update_obstacles(planner.obstacles());
  for (const auto& sample : scans_.take()) {
    if (!sample.disposed) report_unusable(planner.apply(sample.value, sample.writer, sample.received));
  }
  return usable;
}

void PlannerSubscriptions::update_obstacles(ObstacleView& obstacles) {
  for (const auto& sample : obstacle_shapes_.take()) {
    if (sample.disposed) {
      obstacles.withdraw(sample.key, sample.writer);
    } else {
      report_unusable(obstacles.apply(sample.value, sample.writer));
    }
  }
  for (const auto& sample : obstacle_states_.take()) {
    report_unusable(obstacles.apply(sample.value, sample.writer, sample.received));
  }
  obstacles.join();
}

std::vector<msg::Goal> PlannerSubscriptions::take_goals() {
  std::vector<msg::Goal> goals;
  for (auto& sample : goals_.take()) {
    if (!sample.disposed) goals.push_back(std::move(sample.value));
  }
  return goals;
}

CoordinationPublisher::CoordinationPublisher(bus::Participant& participant, std::vector<std::string> arms, int self,
                                             std::string node)
    : arms_(std::move(arms)),
      self_(self),
      node_(std::move(node)),
      proposal_writer_(participant),
      progress_writer_(participant) {}

void CoordinationPublisher::publish(const std::shared_ptr<const planner::CoupledPlan>& proposal,
                                    const planner::CoupledPlanProgress& progress) {
  const bool begins = !std::exchange(begun_, true);
  if (begins || proposal != proposal_) {
    proposal_ = proposal;
    write_proposal();
  }
  if (begins || progress != progress_) {
    const bool took_part = progress_.proposer >= 0;
    const bool takes_part = progress.proposer >= 0;
    if (takes_part != took_part) {
      log_info(takes_part ? "joined coupled plan" : "left coupled plan", {{"arm", arms_[self_]}});
    }
    progress_ = progress;
    write_progress();
  }
}

// The bus logs a failed write. Without the message other arms do not join, or leave after a wait.
void CoordinationPublisher::write_proposal() {
  msg::CoupledPlan message = coupled_plan_message(proposal_.get(), arms_);
  message.arm(arms_[self_]);
  message.node(node_);
  message.stamp_ns(stamp_now());
  (void)proposal_writer_.write(message);
}

void CoordinationPublisher::write_progress() {
  msg::CoupledPlanProgress message = progress_message(progress_, arms_);
  message.arm(arms_[self_]);
  message.node(node_);
  message.stamp_ns(stamp_now());
  (void)progress_writer_.write(message);
}

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
    : participant_(make_participant(file, options, Role::kPlanner, place.node, &mailbox_)),
      modes_(participant_, &modes_mailbox_),
      planner_(planner::live_cell(file.cell, arm), arm, place.node, planner_options(file.cell, arm)),
      subscriptions_(participant_, mailbox_, planner_),
      publishers_{.commands = bus::Writer<msg::ArmCommand>(participant_, {.key = place.arm}),
                  .statuses = bus::Writer<msg::GoalStatus>(participant_, {.key = place.arm}),
                  .coordination = CoordinationPublisher(participant_, names_of(file.cell), arm, place.node),
                  .heartbeat =
                      HeartbeatPublisher(participant_, {place.node, msg::NodeKind::NODE_PLANNER, place.arm, place.host},
                                         heartbeat_timing(file, options)),
                  .ticks = TickPublisher(participant_, place.arm, arm, place.node),
                  .motions = MotionPublisher(participant_, place.arm, place.node)},
      loop_(nanoseconds(file.cell.timing.control_period), shutdown),
      failover_({.arm = place.arm, .node = place.node, .first = place.first, .alone = place.alone}, options.checkpoint,
                file.cell.arms[arm].arm.model->joints()),
      goals_(place.arm, place.node),
      resolver_(planner::CellGeometry(arms_of(planner::live_cell(file.cell, arm)), arm),
                file.cell.arms[arm].parameters.damper.self_security_distance),
      searches_(planner::live_cell(file.cell, arm), arm),
      hold_(make_cause(msg::CauseKind::CAUSE_STARTING, {}, "has just started")) {
  participant_.know_term(failover_.saved_term());
}

void PlannerService::run() {
  const std::string& arm = planner_.name();
  log_info("planner started",
           {{"arm", arm}, {"period_ms", std::chrono::duration<double>(loop_.period()).count() * 1e3}});
  const auto take_charge = [&] {
    (void)modes_mailbox_.take_events();
    modes_.update();
    return failover_.update_lease(modes_.view().lease(arm));
  };
  while (failover_.in_charge() ? loop_.next() : loop_.next(modes_mailbox_, take_charge)) run_period(Clock::now());
  log_info("planner ends", {{"arm", arm}});
}

void PlannerService::run_period(Clock::time_point now) {
  const std::vector<msg::GoalStatus> statuses = subscriptions_.update(planner_);
  (void)modes_mailbox_.take_events();
  modes_.update();
  const ArmLease ordered = modes_.view().lease(planner_.name());
  failover_.update({.now = now, .ordered = ordered, .own = planner_.own_arm(), .statuses = statuses}, goals_);
  check_threads(now);
  if (failover_.ready()) handle_goals(now);
  plan(now);
  publish_statuses(now);
  if (publishers_.heartbeat.due(now, loop_.period() / 2)) publish_heartbeat(now);
}

void PlannerService::check_threads(Clock::time_point now) {
  StalledThreads stalled;
  const auto silence = resolver_.silence(now);
  if (silence > kLongestWait) stalled.resolver = stall_text("the thread that resolves goals", silence, kLongestWait);
  const auto search = searches_.stalled(now);
  stalled.any = stalled.resolver ? stalled.resolver : search;
  if (stalled.any.has_value() != stalled_.any.has_value()) {
    log_warning(stalled.any ? "background thread does not answer" : "all background threads answer",
                {{"reason", stalled.any.value_or("")}});
  }
  stalled_ = std::move(stalled);
}

void PlannerService::handle_goals(Clock::time_point now) {
  for (const msg::Goal& goal : subscriptions_.take_goals()) goals_.receive(goal, now);
  for (const GoalAnswer& answer : resolver_.answers()) goals_.answer(answer, now);

  if (failover_.in_charge()) {
    goals_.answer_unknown_cancellations(now);
  } else {
    goals_.restart_waits(now);
  }
  end_goals_without_device(now);
  if (failover_.in_charge() && stalled_.resolver) {
    goals_.reject_all(make_cause(msg::CauseKind::CAUSE_GOAL_NOT_RESOLVED, {}, *stalled_.resolver));
  }
  if (const auto cause = planner_.cannot_resolve()) {
    goals_.reject_expired(now, kLongestWait, *cause);
  } else if (const auto goal = goals_.next_to_resolve()) {
    resolver_.ask(planner_.question(*goal, now, failover_.in_charge()));
  }
}

// Others move an observed arm, so that no goal of it can be reached. A person resumes the arm, and does not know the
// goal that it had then. The driver reports a short fault for some periods only, which a planner that stands still
// meanwhile does not receive; the hold lasts. Goals that are sent during the hold stay.
void PlannerService::end_goals_without_device(Clock::time_point now) {
  if (!failover_.in_charge()) return;
  const auto& own = planner_.own_arm();
  if (own && (device_fault(own->cause.kind()) || own->cause.kind() == msg::CauseKind::CAUSE_OBSERVED))
    goals_.end_all(own->cause, now);
  const CellModeView& mode = modes_.view();
  if (!mode.heard()) return;
  const bool held = is_held_for_device(mode.mode(), planner_.name());
  if (held && !held_for_device_) goals_.end_all(order_in(mode.mode(), planner_.name())->cause(), now);
  held_for_device_ = held;
}

void PlannerService::plan(Clock::time_point now) {
  std::optional<msg::Cause> hold = planner_.hold(now, modes_.view());
  if (hold != hold_) log_info(hold ? "arm is held" : "arm may move", {{"reason", hold ? hold->text() : std::string()}});
  hold_ = std::move(hold);

  const TickPublisher::Period recorded = publishers_.ticks.begin(now, failover_.in_charge());
  const auto planned = planner_.step(
      {.now = now,
       .missed = static_cast<double>(loop_.skipped()) * std::chrono::duration<double>(loop_.period()).count(),
       .mode = modes_.view(),
       .term = failover_.role().term(),
       .commands = failover_.in_charge(),
       .continues = failover_.continues(),
       .hold = hold_.has_value(),
       .goal = goals_.take_change(),
       .ticks = recorded.ticks,
       .snapshot = recorded.snapshot},
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
  const auto reported = planned
                            ? std::optional(ProgressReporter::Planned{planned->inputs, planned->result,
                                                                      planner_.own_arm()->q, planner_.own_arm()->cause})
                            : std::nullopt;
  const auto progress = reporter_.report({.planner = planner_.planner(),
                                          .planned = reported,
                                          .hold = hold_,
                                          .q_goal = goals_.has_active() ? &goals_.q_goal() : nullptr,
                                          .tool = goals_.has_active() ? goals_.tool() : nullptr,
                                          .commands = failover_.in_charge()});
  if (progress) goals_.progress(*progress, now);
  planner_.note_reaction(Clock::now() - now);
  publishers_.ticks.publish();  // a recorder makes no command later
  if (!failover_.in_charge()) {
    publishers_.motions.resign();
  } else if (planned) {
    publishers_.motions.publish(now, planner_.planner(), planned->inputs.answers);
  }
}

// If this process was stopped while planning, the command rests on older states than the planner assumed. It is then
// not sent, as if the network had lost it.
void PlannerService::send_command(Clock::time_point now) {
  planner_.command().stamp_ns(stamp_now());
  if (Clock::now() - now > planner_.reaction() + loop_.period()) return;
  (void)publishers_.commands.write(
      planner_.command());  // the bus logs a failed write; the next command follows in one period
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

void PlannerService::publish_heartbeat(Clock::time_point now) {
  const CellModeView& mode = modes_.view();
  const LivePlanner::OldestInput oldest = planner_.oldest_input(now, mode);
  const bool starved = oldest.age > planner_.state_age_limit() || !mode.heard();
  HealthReport report;
  report.term = mode.term();
  report.lease = failover_.role().lease();
  report.oldest_input_age = std::isfinite(oldest.age) ? oldest.age : -1.0;
  report.oldest_input = oldest.topic_and_key;
  report.state = failover_.in_charge() ? msg::NodeState::NODE_RUNNING : msg::NodeState::NODE_STANDBY;
  if (starved || stalled_.any) report.state = msg::NodeState::NODE_DEGRADED;
  if (starved) {
    report.cause =
        hold_ ? *hold_ : make_cause(oldest.kind, oldest.topic_and_key, oldest.topic_and_key + " is old or missing");
  }
  if (stalled_.any) {
    const std::string also = starved ? "; " + report.cause.text() : "";
    report.cause = make_cause(msg::CauseKind::CAUSE_NODE_SILENT, failover_.node(), *stalled_.any + also);
  }
  publishers_.heartbeat.publish(now, report, loop_.statistics());
}

}  // namespace hecaton::services
