#include "services/planner/planner_service.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <stdexcept>
#include <utility>

#include "planner/local/goal_objective.hpp"
#include "services/messages/convert.hpp"
#include "services/messages/names.hpp"
#include "services/planner/explain.hpp"
#include "services/runtime/cause.hpp"
#include "services/runtime/join.hpp"
#include "services/runtime/log.hpp"
#include "services/runtime/node_name.hpp"
#include "services/runtime/process_info.hpp"

namespace hecaton::services {
namespace {

using namespace std::chrono_literals;

/// Of the threads that search. They have no budgets of time, and go after everything else on a busy machine: what takes
/// longer than this has no end.
constexpr auto kLongestSearch = 60s;
/// Without fresh states this long the goal counts as blocked [s]; shorter gaps are the network's everyday life.
constexpr double kBlockedAfter = 1.0;
/// The measured arm may be this much farther from the goal than its set-point: the drive's tracking error.
constexpr double kTrackingTolerance = 2.0;

std::vector<planner::Arm> arms_of(const planner::Cell& cell) {
  std::vector<planner::Arm> arms;
  for (const planner::PlannedArm& planned : cell.arms) arms.push_back(planned.arm);
  return arms;
}

std::vector<planner::LocalParameters> parameters_of(const planner::Cell& cell) {
  std::vector<planner::LocalParameters> parameters;
  for (const planner::PlannedArm& planned : cell.arms) parameters.push_back(planned.parameters);
  return parameters;
}

std::vector<std::string> names_of(const planner::Cell& cell) {
  std::vector<std::string> names;
  for (const planner::PlannedArm& planned : cell.arms) names.push_back(planned.arm.name);
  return names;
}

/// FNV-1a: each arm draws its own subspaces, the same ones in every run.
std::uint64_t seed_of(const std::string& name) {
  std::uint64_t hash = 0xcbf29ce484222325ULL;
  for (const char c : name) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3ULL;
  return hash;
}

/// An arm that cannot be used because the disk is full would be worse than one whose goal ends with its planner.
std::unique_ptr<GoalMemory> memory_in(const std::string& path, int joints) {
  try {
    return std::make_unique<GoalMemory>(path, joints);
  } catch (const std::runtime_error& error) {
    log_warning("goals are not remembered: they are lost when this process ends", {{"reason", error.what()}});
    return nullptr;
  }
}

}  // namespace

PlannerService::PlannerService(const config::CellFile& file, int arm, const ServiceOptions& options,
                               const ShutdownSignal& shutdown)
    : name_(file.cell.arms[arm].arm.name),
      planners_(planners_of(file, static_cast<std::size_t>(arm))),
      place_(index_on(planners_, options.host)),
      node_(planners_[place_].node),
      self_(arm),
      state_age_limit_(file.cell.arms[arm].parameters.state_age_limit),
      by_sight_(file.cell.arms[arm].parameters.method == planner::Method::kSensedCspace),
      participant_(make_participant(file, options, node_, &mailbox_)),
      modes_(participant_, &modes_mailbox_),
      arm_states_(participant_, &mailbox_),
      obstacle_shapes_(participant_, &mailbox_),
      obstacle_states_(participant_, &mailbox_),
      scans_(participant_, &mailbox_),
      goals_(participant_, &mailbox_),
      goals_of_others_(participant_, &mailbox_),
      commands_(participant_),
      statuses_(participant_),
      pulse_(participant_,
             {node_, msg::NodeKind::NODE_PLANNER, name_, options.host.empty() ? planners_[place_].host : options.host},
             pulse_timing(file, options)),
      loop_(nanoseconds(file.cell.timing.control_period), shutdown),
      duty_(node_, place_ == 0),
      in_charge_(planners_.size() == 1),
      arms_(file.cell, arm),
      obstacles_(names_of(file.cell)),
      sensors_(file.cell.arms[arm]),
      desk_(name_, node_),
      memory_(memory_in(options.memory, file.cell.arms[arm].arm.model->joints())),
      remembered_(memory_ ? memory_->recall() : std::nullopt),
      controller_(planner::CellGeometry(arms_of(file.cell), arm), file.cell.arms[arm].parameters,
                  file.cell.timing.control_period, seed_of(name_)),
      resolver_(arms_of(file.cell), arm),
      rollout_policy_(file.cell.arms[arm].parameters, seed_of(name_)),
      rollouts_(arms_of(file.cell), parameters_of(file.cell), arm,
                file.cell.arms[arm].parameters.rollout.ticks_per_period),
      route_policy_(file.cell.arms[arm].parameters, seed_of(name_)),
      routes_(arms_of(file.cell), parameters_of(file.cell), arm),
      company_(participant_, &mailbox_, arms_of(file.cell), parameters_of(file.cell), arm, node_, seed_of(name_)) {
  command_.arm(name_);
  command_.node(node_);
  command_.period(file.cell.timing.control_period);
}

void PlannerService::run() {
  log_info("planner started", {{"arm", name_}, {"period_ms", controller_.control_period() * 1e3}});
  const auto put_in_charge = [this] { return hear_mandate(); };
  while (in_charge_ ? loop_.next() : loop_.next(modes_mailbox_, put_in_charge)) {
    now_ = Clock::now();
    controller_.let_pass(static_cast<double>(loop_.skipped()) * controller_.control_period());
    listen();
    note_duty();
    resume_goal();
    catch_up();
    look_at_threads();
    handle_goals();
    plan();
    note_reaction(Clock::now() - now_);
    publish_statuses();
    if (pulse_.due(now_, loop_.period() / 2)) beat();
  }
  log_info("planner ends", {{"arm", name_}});
}

void PlannerService::listen() {
  (void)mailbox_.take_events();
  const auto complain = [this](const std::string& sentence) {
    if (sentence.empty() || sentence == complaint_) return;
    complaint_ = sentence;
    log_warning("message ignored", {{"reason", sentence}});
  };
  for (const auto& sample : arm_states_.take()) {
    if (!sample.disposed) complain(arms_.apply(sample.value, sample.writer, sample.received));
  }
  for (const auto& sample : goals_of_others_.take()) {
    if (sample.disposed) continue;
    const std::string unusable = arms_.apply(sample.value);
    complain(unusable);
    if (unusable.empty()) hear_the_other(sample.value);
  }
  company_.listen(arms_, complain);
  for (const auto& sample : obstacle_shapes_.take()) {
    if (sample.disposed) {
      obstacles_.withdraw(sample.key);
    } else {
      complain(obstacles_.apply(sample.value));
    }
  }
  for (const auto& sample : obstacle_states_.take()) {
    complain(obstacles_.apply(sample.value, sample.writer, sample.received));
  }
  if (obstacles_.join()) controller_.set_obstacles(*obstacles_.obstacles());
  listen_to_sensors();
}

void PlannerService::listen_to_sensors() {
  for (const auto& sample : scans_.take()) {
    if (sample.disposed || !arms_.arm(self_)) continue;
    std::string unusable;
    const auto scan = sensors_.take(sample.value, sample.writer, sample.received, *arms_.arm(self_), unusable);
    if (scan) controller_.sense(*scan);
    if (unusable.empty() || unusable == complaint_) continue;
    complaint_ = unusable;
    log_warning("message ignored", {{"reason", unusable}});
  }
}

bool PlannerService::hears_own_arm() const {
  return arms_.age(self_, now_) <= state_age_limit_;
}

std::string PlannerService::blind() const {
  if (by_sight_) return sensors_.silent(now_, state_age_limit_);
  if (!obstacles_.known()) return obstacles_.missing();
  return obstacles_.age(now_) > state_age_limit_ ? "the world is silent" : "";
}

std::string PlannerService::hold_reason() const {
  return modes_.view().order(name_) != msg::Mode::MODE_RUN ? modes_.view().why(name_).text() : blind();
}

void PlannerService::note_hold(const std::string& reason) {
  if (reason == hold_reason_) return;
  hold_reason_ = reason;
  log_info(reason.empty() ? "may move" : "holds", {{"reason", reason}});
}

void PlannerService::look_at_threads() {
  no_answers_ = complaint_about("the thread that resolves goals", resolver_.silence(now_), kLongestWait);
  std::string hangs = no_answers_;
  const auto look = [&hangs](const char* thread, Clock::duration silence) {
    if (hangs.empty()) hangs = complaint_about(thread, silence, kLongestSearch);
  };
  look("the thread that plays rollouts", rollouts_.silence(now_));
  look("the thread that searches routes", routes_.silence(now_));
  look("the thread that searches plans for several arms", company_.silence(now_));
  if (hangs.empty() != hanging_thread_.empty()) {
    log_warning(hangs.empty() ? "all threads answer again" : "a thread does not answer", {{"reason", hangs}});
  }
  hanging_thread_ = std::move(hangs);
}

void PlannerService::handle_goals() {
  if (remembered_) return;  // which of those that wait were answered is not known yet
  for (const auto& sample : goals_.take()) {
    if (!sample.disposed) desk_.receive(sample.value, now_);
  }
  for (const GoalAnswer& answer : resolver_.answers()) {
    if (desk_.answer(answer, now_)) controller_.set_goal(desk_.q_goal());
  }
  if (desk_.take_forget()) controller_.cancel_goal();

  if (!in_charge_) desk_.wait_from(now_);
  if (in_charge_ && !no_answers_.empty()) desk_.refuse_all(no_answers_);
  const bool knows_obstacles = by_sight_ || obstacles_.known();
  if (!knows_obstacles || !arms_.arm(self_)) {
    desk_.refuse_waiting(now_, kLongestWait,
                         knows_obstacles ? "the driver of arm " + name_ + " was never heard" : obstacles_.missing());
    return;
  }
  if (const auto goal = desk_.next_question()) {
    GoalQuestion question{*goal, arms_.arm(self_)->q, std::make_shared<const std::vector<world::Obstacle>>(), {}};
    if (!by_sight_) {
      const auto states = obstacles_.states(now_);
      question.obstacles = obstacles_.obstacles();
      question.states.assign(states.begin(), states.end());
    }
    resolver_.ask(std::move(question));
  }
}

void PlannerService::plan() {
  note_hold(hears_own_arm() ? hold_reason() : "the driver of arm " + name_ + " is silent");
  if (!hears_own_arm()) {
    // Without knowing where the arm is there is nothing sound to command; its driver stops it by itself.
    controller_.forget_setpoint();
    waited_for_input_ += controller_.control_period();
    Progress progress;
    progress.reason = hold_reason_;
    progress.trying = "waits for the driver";
    progress.held_back = true;
    progress.claim = controller_.claim();
    answer_clients(std::move(progress));
    return;
  }
  const ArmView::Heard& own = *arms_.arm(self_);
  // By the time that the command is out all this will be older.
  const auto observed = arms_.observe(now_ + reaction_, modes_.view());
  const auto obstacles = obstacles_.states(now_ + reaction_);
  rollout_policy_.prepare(controller_);
  const planner::TickResult result = controller_.step(news_of(own), observed, obstacles, !hold_reason_.empty());
  command(result);
  if (in_charge_) look_ahead(result, observed, obstacles);
  if (in_charge_) {
    company_.plan(controller_, result, observed, obstacles, obstacles_.obstacles());
  } else {
    company_.resign(controller_);
  }
  if (in_charge_ && !company_.takes_part()) {
    plan_route(result, observed, obstacles);
  } else {
    route_policy_.drop();
  }

  const bool world_missing = !hold_reason_.empty() && modes_.view().order(name_) == msg::Mode::MODE_RUN;
  const bool starved = world_missing || result.status == planner::TickStatus::kStaleInput;
  waited_for_input_ = starved ? waited_for_input_ + controller_.control_period() : 0.0;
  if (!desk_.has_active()) return;
  Progress progress =
      explain(result, controller_.approach(), controller_.geometry(), observed, obstacles, hold_reason_);
  if (const planner::cspace::SensedPlanner* cspace = controller_.cspace();
      cspace != nullptr && result.status == planner::TickStatus::kBlocked && !result.has_binding) {
    if (std::string why = cspace->why_none(own.q); !why.empty()) progress.reason = std::move(why);
    progress.trying = "stays until it sees a way";
  }
  const planner::Arm& arm = controller_.geometry().own_arm();
  const planner::JointVector to_go = planner::joint_difference(arm.limits, own.q, desk_.q_goal());
  progress.distance = to_go.norm();
  progress.claim = controller_.claim();
  if (rollout_policy_.looks_ahead()) progress.trying += ", looks ahead";
  const bool there = to_go.cwiseAbs().maxCoeff() < kTrackingTolerance * controller_.parameters().goal_tolerance;
  if (result.status == planner::TickStatus::kReached && there) progress.state = msg::GoalState::GOAL_REACHED;
  if (own.mode != msg::ArmMode::ARM_RUNNING && hold_reason_.empty() && !own.reason.empty() && !starved) {
    progress.reason = "the drive does not follow: " + own.reason;
  }
  answer_clients(std::move(progress));
}

planner::OwnNews PlannerService::news_of(const ArmView::Heard& own) const {
  planner::OwnNews news;
  news.state = {own.q, own.qd};
  news.age = arms_.age(self_, now_);
  news.follows = own.mode == msg::ArmMode::ARM_RUNNING;
  if (own.term == duty_.term()) news.setpoint = own.command_sequence;  // else the last that it accepted was not ours
  news.setpoint_age = own.command_age;
  return news;
}

// The longest of late: a machine that stalled will stall again.
void PlannerService::note_reaction(Clock::duration taken) {
  constexpr int kFadesIn = 64;  // periods
  reaction_ = std::max(taken, reaction_ - reaction_ / kFadesIn);
}

void PlannerService::look_ahead(const planner::TickResult& result, std::span<const planner::ArmObservation> arms,
                                std::span<const world::ObstacleState> obstacles) {
  if (const auto answer = rollouts_.answer()) {
    rollout_policy_.answered();
    controller_.begin(answer->manoeuvre);
  }
  if (auto question = rollout_policy_.next(controller_, result, arms, obstacles)) {
    rollouts_.ask(std::move(*question), obstacles_.obstacles());
  } else {
    rollouts_.grant();
  }
}

void PlannerService::plan_route(const planner::TickResult& result, std::span<const planner::ArmObservation> arms,
                                std::span<const world::ObstacleState> obstacles) {
  if (auto answer = routes_.answer()) {
    if (answer->route.kind == planner::RouteAnswer::Kind::kFound) {
      log_debug("route", {{"points", answer->route.points.size()},
                          {"ms", std::chrono::duration<double, std::milli>(answer->taken).count()}});
    }
    route_policy_.answered(answer->route, controller_);
  }
  if (auto question = route_policy_.next(controller_, result, arms, obstacles)) {
    routes_.ask(std::move(*question), obstacles_.obstacles());
  }
}

// Where this process was stopped in the midst of planning, the command follows from older news than was counted on: it
// is lost like a datagram, and the drive knows what to do then.
void PlannerService::command(const planner::TickResult& result) {
  if (!in_charge_ || !modes_.view().heard()) return;
  const ArmView::Heard& own = *arms_.arm(self_);
  const std::uint64_t term = duty_.term();
  // A planner that was restarted within its term goes on counting where the driver stands.
  if (own.term == term) sequence_ = std::max(sequence_, own.command_sequence);
  command_.term(term);
  command_.sequence_number(++sequence_);
  controller_.sent(sequence_);
  command_.stamp_ns(stamp_now());
  messages::to_message(result.q, command_.q());
  messages::to_message(result.qd, command_.qd());
  if (Clock::now() - now_ > reaction_ + loop_.period()) return;
  (void)commands_.write(command_);  // the bus logs a refusal; the next command is due in one period
}

void PlannerService::answer_clients(Progress progress) {
  if (progress.state == msg::GoalState::GOAL_ACTIVE && waited_for_input_ > kBlockedAfter)
    progress.state = msg::GoalState::GOAL_BLOCKED;
  desk_.progress(progress, now_);
  if (desk_.take_forget()) controller_.cancel_goal();
}

void PlannerService::publish_statuses() {
  std::vector<msg::GoalStatus> statuses = desk_.take_statuses();
  has_news_ = has_news_ || !statuses.empty();
  if (!in_charge_) {
    unsaid_.keep(std::move(statuses));
    desk_.owe_ends(unsaid_.ends());
    remember_goals();
    return;
  }
  remember_goals();
  std::vector<msg::GoalStatus> unsaid = unsaid_.take();
  statuses.insert(statuses.begin(), std::make_move_iterator(unsaid.begin()), std::make_move_iterator(unsaid.end()));
  for (msg::GoalStatus& status : statuses) {
    status.term(duty_.term());
    status.stamp_ns(stamp_now());
    (void)statuses_.write(status);
    const bool passing =
        status.state() == msg::GoalState::GOAL_ACTIVE || status.state() == msg::GoalState::GOAL_BLOCKED;
    (passing ? log_debug : log_info)("goal", {{"goal", status.goal()},
                                              {"state", text(status.state())},
                                              {"elapsed", status.elapsed()},
                                              {"distance", status.distance_to_goal()},
                                              {"reason", status.reason()}});
  }
}

void PlannerService::beat() {
  Vital vital;
  vital.term = modes_.view().term();
  vital.heard_mode = modes_.view().number();
  vital.lease = duty_.mandate();
  const auto consider = [&vital](double age, const std::string& input) {
    if (age <= vital.oldest_input_age) return;
    vital.oldest_input_age = std::isfinite(age) ? age : 1e9;
    vital.oldest_input = input;
  };
  for (int i = 0; i < static_cast<int>(controller_.geometry().arms().size()); ++i) {
    if (arms_.lost(i, now_, modes_.view())) continue;  // is worked around
    consider(arms_.age(i, now_), "ArmState/" + controller_.geometry().arms()[i].name);
  }
  if (!by_sight_) consider(obstacles_.known() ? obstacles_.age(now_) : HUGE_VAL, "ObstacleStates");
  const bool starved = vital.oldest_input_age > state_age_limit_ || !modes_.view().heard();
  vital.state = in_charge_ ? msg::NodeState::NODE_RUNNING : msg::NodeState::NODE_STANDBY;
  if (starved || !hanging_thread_.empty()) vital.state = msg::NodeState::NODE_DEGRADED;
  if (starved) {
    const bool obstacles = vital.oldest_input == "ObstacleStates";
    vital.cause =
        make_cause(obstacles ? msg::CauseKind::CAUSE_OBSTACLES_OLD : msg::CauseKind::CAUSE_ARM_STATE_OLD,
                   vital.oldest_input, hold_reason_.empty() ? vital.oldest_input + " is old or missing" : hold_reason_);
  }
  if (!hanging_thread_.empty()) {
    const std::string also = starved ? "; " + vital.cause.text() : "";
    vital.cause = make_cause(msg::CauseKind::CAUSE_NODE_SILENT, node_, hanging_thread_ + also);
  }
  pulse_.beat(now_, vital, loop_.statistics());
}

}  // namespace hecaton::services
