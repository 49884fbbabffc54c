#include "services/planner/live_planner.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "services/messages/convert.hpp"
#include "services/runtime/cause.hpp"
#include "services/runtime/node_name.hpp"
#include "services/tick_log/program.hpp"

namespace hecaton::services {
namespace {

using msg::CauseKind;

msg::Cause obstacles_old(std::string text) {
  return make_cause(CauseKind::CAUSE_OBSTACLES_OLD, world_node(), std::move(text));
}

double largest_influence_distance(const planner::Cell& cell) {
  double largest = 0.0;
  for (const planner::PlannedArm& arm : cell.arms) {
    largest = std::max(largest, arm.parameters.damper.influence_distance);
  }
  return largest;
}

}  // namespace

bool is_missing_input(const msg::Cause& hold) {
  return hold.kind() == CauseKind::CAUSE_ARM_STATE_OLD || hold.kind() == CauseKind::CAUSE_OBSTACLES_OLD ||
         hold.kind() == CauseKind::CAUSE_SENSOR_OLD || hold.kind() == CauseKind::CAUSE_DEVICE_FAILED;
}

LivePlanner::LivePlanner(const planner::Cell& cell, int self, const std::string& node,
                         const planner::ArmPlannerOptions& options)
    : self_(self),
      state_age_limit_(cell.arms[self].parameters.state_age_limit),
      influence_distance_(largest_influence_distance(cell)),
      sensor_only_(cell.arms[self].parameters.method->traits().sensor_only),
      arms_(cell, self),
      obstacles_(names_of(cell)),
      sensors_(cell.arms[self]),
      arms_of_cell_(arms_of(cell)),
      options_(options),
      planner_(planner::CellGeometry(arms_of(cell), self), cell.arms[self].parameters, options) {
  command_.arm(name());
  command_.node(node);
  command_.period(options.control_period);
  arms_.set_neighbours(find_neighbours());
}

std::vector<int> LivePlanner::find_neighbours() const {
  return planner_.controller().geometry().neighbourhood(influence_distance_);
}

std::vector<std::string> LivePlanner::neighbour_names() const {
  std::vector<std::string> names;
  for (const int arm : arms_.neighbours()) names.push_back(arms_of_cell_[arm].name);
  return names;
}

std::optional<std::string> LivePlanner::apply(const msg::RangeScan& scan, const bus::EndpointId& writer,
                                              Clock::time_point received) {
  if (!own_arm()) return std::nullopt;
  std::optional<std::string> unusable;
  if (auto taken = sensors_.take(scan, writer, received, *own_arm(), unusable)) scans_.push_back(std::move(*taken));
  return unusable;
}

bool LivePlanner::has_fresh_own_state(Clock::time_point now) const {
  return arms_.age(self_, now) <= state_age_limit_;
}

std::optional<msg::Cause> LivePlanner::missing_environment(Clock::time_point now) const {
  if (sensor_only_) return sensors_.silent(now, state_age_limit_);
  if (!obstacles_.known()) return obstacles_old(obstacles_.missing());
  if (obstacles_.age(now) > state_age_limit_) return obstacles_old("the world service sends no states");
  return std::nullopt;
}

std::optional<msg::Cause> LivePlanner::hold(Clock::time_point now, const CellModeView& mode) const {
  if (!has_fresh_own_state(now)) {
    // The driver of a failed device continues to publish the last measured state, which ages.
    if (own_arm() && own_arm()->cause.kind() == CauseKind::CAUSE_DEVICE_FAILED) return own_arm()->cause;
    return make_cause(CauseKind::CAUSE_ARM_STATE_OLD, name(), "the driver of arm " + name() + " sends no states");
  }
  if (own_arm()->cause.kind() == CauseKind::CAUSE_OBSERVED) return own_arm()->cause;
  if (mode.order(name()) != msg::Mode::MODE_RUN) return mode.why(name());
  return missing_environment(now);
}

std::optional<msg::Cause> LivePlanner::cannot_resolve() const {
  if (!sensor_only_ && !obstacles_.known()) return obstacles_old(obstacles_.missing());
  if (own_arm()) return std::nullopt;
  return make_cause(CauseKind::CAUSE_ARM_STATE_OLD, name(), "no state of arm " + name() + " has been received");
}

GoalQuestion LivePlanner::question(const msg::Goal& goal, Clock::time_point now, bool begins) {
  GoalQuestion question{goal, own_arm()->q, std::make_shared<const std::vector<world::Obstacle>>(), {}};
  question.follows_trajectories = planner_.controller().guide() == nullptr;
  question.begins = begins;
  if (sensor_only_) return question;
  update_scene(now);
  const auto now_states = states(now);
  question.obstacles = scene_;
  question.states.assign(now_states.begin(), now_states.end());
  return question;
}

LivePlanner::OldestInput LivePlanner::oldest_input(Clock::time_point now, const CellModeView& mode) const {
  OldestInput oldest;
  const auto consider = [&oldest](double age, const std::string& input, CauseKind kind) {
    if (age > oldest.age) oldest = {age, input, kind};
  };
  const auto& arms = planner_.controller().geometry().arms();
  for (int i = 0; i < static_cast<int>(arms.size()); ++i) {
    if (arms_.is_neighbour(i) && !arms_.lost(i, now, mode)) {
      consider(arms_.age(i, now), "ArmState/" + arms[i].name, CauseKind::CAUSE_ARM_STATE_OLD);
    }
  }
  const double never = std::numeric_limits<double>::infinity();
  if (!sensor_only_) {
    consider(obstacles_.known() ? obstacles_.age(now) : never, "ObstacleStates", CauseKind::CAUSE_OBSTACLES_OLD);
  }
  return oldest;
}

void LivePlanner::update_scene(Clock::time_point now) {
  if (sensor_only_ || !obstacles_.obstacles()) {
    scene_ = obstacles_.obstacles();
    return;
  }
  std::vector<std::vector<planner::MotionRange>> places;
  for (int i = 0; i < static_cast<int>(arms_of_cell_.size()); ++i) places.push_back(arms_.outside(i, now));
  if (scene_ && joined_ == obstacles_.obstacles() && places == places_) return;
  joined_ = obstacles_.obstacles();
  places_ = std::move(places);
  auto scene = std::make_shared<std::vector<world::Obstacle>>(*joined_);
  for (std::size_t i = 0; i < arms_of_cell_.size(); ++i) {
    for (world::Obstacle& body : planner::outside_obstacles(arms_of_cell_[i], places_[i])) {
      scene->push_back(std::move(body));
    }
  }
  scene_ = std::move(scene);
}

// An arm carries the bodies outside the chains: their own states do not count.
std::span<const world::ObstacleState> LivePlanner::states(Clock::time_point now) {
  const auto of_world = obstacles_.states(now);
  if (!scene_ || scene_->size() == of_world.size()) return of_world;
  states_.assign(of_world.begin(), of_world.end());
  world::ObstacleState carried;
  carried.age = obstacles_.age(now);
  states_.resize(scene_->size(), carried);
  return states_;
}

/// The number of the next command; 0: none is sent.
std::uint64_t LivePlanner::next_number(const PeriodContext& context) {
  if (!context.commands || !context.mode.heard()) return 0;
  // A planner that was restarted within its term continues from the number at the driver.
  if (own_arm()->term == context.term) sequence_ = std::max(sequence_, own_arm()->command_sequence);
  return ++sequence_;
}

/// Set-points that begin ahead of an arm would drive it faster and faster, if its state is not as old as it seems. So
/// the driver brakes a moving arm before its planner begins, unless the state is fresh.
bool LivePlanner::is_braked_first(const PeriodContext& context) const {
  constexpr double kFresh = 0.05;   // [s]
  constexpr double kStands = 0.05;  // [rad/s | m/s]
  const ArmView::ReceivedState& own = *own_arm();
  const bool continues =
      context.continues && planner_.controller().has_setpoint() && own.mode == msg::ArmMode::ARM_RUNNING;
  return !continues && arms_.age(self_, context.now) > kFresh && own.qd.cwiseAbs().maxCoeff() > kStands;
}

std::optional<LivePlanner::PlannedPeriod> LivePlanner::step(const PeriodContext& context,
                                                            planner::SearchExecutor& searches) {
  const bool silent = !has_fresh_own_state(context.now) || is_braked_first(context);
  planner::PeriodEvents events;
  events.missed = context.missed;
  // While the drive follows another planner, set-points of this planner begin at the measured position.
  events.drops_setpoint = silent || !context.continues;
  update_scene(context.now);
  if (scene_ != planned_with_) events.obstacles = planned_with_ = scene_;
  events.goal = context.goal;
  events.scans = scans_;
  if (context.ticks != nullptr) log_events(context, events);
  planner_.receive(events);
  // Before the arms are observed: a new neighbour is unknown, and this arm waits, until its state arrives.
  if (events.obstacles) arms_.set_neighbours(find_neighbours());
  scans_.clear();
  if (silent) return std::nullopt;

  const ArmView::ReceivedState& own = *own_arm();
  // When the command is sent, all states are older by reaction_.
  const Clock::time_point sent = context.now + reaction_;
  PlannedPeriod period;
  planner::PeriodInputs& inputs = period.inputs;
  inputs.own.state = {own.q, own.qd};
  inputs.own.age = arms_.age(self_, context.now);
  inputs.own.follows = own.mode == msg::ArmMode::ARM_RUNNING;
  // Under another term the driver's last command was not from this planner.
  inputs.own.setpoint = own.term == context.term ? own.command_sequence : 0;
  inputs.own.setpoint_age = own.command_age;
  inputs.own.tracking_delay = own.tracking_delay;
  inputs.own.speed_scaling = own.speed_scaling;
  inputs.arms = arms_.observe(sent, context.mode);
  inputs.obstacles = states(sent);
  inputs.hold = context.hold;
  inputs.speed = context.mode.speed(name());
  inputs.commands = context.commands;
  inputs.number = next_number(context);
  inputs.answers = searches.answers();
  period.result = planner_.step(inputs);
  if (context.ticks != nullptr) context.ticks->finish(inputs, period.result);
  if (inputs.number > 0) {
    command_.term(context.term);
    command_.sequence_number(inputs.number);
    messages::to_message(period.result.q, command_.q());
    messages::to_message(period.result.qd, command_.qd());
  }
  return period;
}

void LivePlanner::log_events(const PeriodContext& context, const planner::PeriodEvents& events) const {
  std::optional<TickWriter::Snapshot> snapshot;
  if (context.snapshot) {
    snapshot = TickWriter::Snapshot{planner_.save(), program_text(), options_, scene_};
    // A motion method with a map has no memory that can be saved. The recording then has no snapshot to verify from.
    if (snapshot->memory.empty()) snapshot.reset();
  }
  context.ticks->begin(context.now.time_since_epoch().count(), events, snapshot);
}

void LivePlanner::note_reaction(Clock::duration taken) {
  constexpr int kFadesIn = 64;  // periods
  reaction_ = std::max(taken, reaction_ - reaction_ / kFadesIn);
}

void LivePlanner::plan_ahead(const PlannedPeriod& period, planner::SearchExecutor& searches) {
  searches.ask(planner_.plan_ahead(period.inputs, period.result), scene_);
}

}  // namespace hecaton::services
