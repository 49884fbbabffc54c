#include <algorithm>
#include <cmath>

#include <hecaton/client.hpp>

#include "services/client/connection.hpp"
#include "services/client/convert.hpp"
#include "services/config/text.hpp"
#include "services/runtime/orders.hpp"

namespace hecaton {
namespace {

using client::Connection;

Receipt receipt_of(const msg::WorldEditReply& reply) {
  if (!reply.done()) throw Rejected(client::to_public(reply.cause()));
  return {reply.edition(), client::to_public(reply.cause())};
}

Receipt receipt_of(const msg::SupervisorReply& reply) {
  if (!reply.done()) throw Rejected(client::to_public(reply.cause()));
  return {0, client::to_public(reply.cause())};
}

Receipt order(Connection& connection, msg::RequestKind kind, const std::vector<std::string>& arms, const Wait& wait) {
  return receipt_of(connection.order(kind, arms, wait));
}

Receipt order_speed(Connection& connection, double speed, const std::vector<std::string>& arms, const Wait& wait) {
  if (!(speed >= services::kSlowestSpeed && speed <= services::kFullSpeed)) {  // true for NaN
    throw InvalidArgument("speed = " + std::to_string(speed) + " must be 0.01 to 1");
  }
  msg::SupervisorRequest request;
  request.kind(msg::RequestKind::REQUEST_SPEED);
  request.arms(arms);
  request.speed(speed);
  return receipt_of(connection.order(std::move(request), wait));
}

void order_device(Connection& connection, msg::DeviceRequest request, const Wait& wait) {
  const msg::DeviceReply reply = connection.order_device(std::move(request), wait);
  if (!reply.done()) throw Rejected(client::to_public(reply.cause()));
}

void order_gripper(Connection& connection, const std::string& arm, msg::DeviceOrder order, const GripOptions& options,
                   const Wait& wait) {
  msg::DeviceRequest request;
  request.arm(arm);
  request.order(order);
  for (const auto& [what, value] : {std::pair("width", options.width), std::pair("force", options.force)}) {
    if (!value || (*value >= 0.0 && std::isfinite(*value))) continue;
    throw InvalidArgument(std::string(what) + " = " + std::to_string(*value) + " must be finite and at least 0");
  }
  request.width(options.width.value_or(-1.0));
  request.force(options.force.value_or(-1.0));
  order_device(connection, std::move(request), wait);
}

void order_value(Connection& connection, const std::string& arm, msg::DeviceOrder order, const std::string& name,
                 double value, const Wait& wait) {
  if (!std::isfinite(value)) throw InvalidArgument(name + " = " + std::to_string(value) + " must be a finite number");
  msg::DeviceRequest request;
  request.arm(arm);
  request.order(order);
  request.name(name);
  request.value(value);
  order_device(connection, std::move(request), wait);
}

msg::WorldEditRequest request_for(msg::EditKind kind, const std::string& name) {
  msg::WorldEditRequest request;
  request.kind(kind);
  request.name(name);
  return request;
}

/// Readers refuse a sample with such a number, so that its goal would never be answered.
void require_finite(const std::string& what, double value) {
  if (!std::isfinite(value)) throw InvalidArgument(what + " = " + std::to_string(value) + " must be a finite number");
}

msg::Goal goal_for(const std::string& arm, msg::GoalKind kind, const GoalOptions& options) {
  require_finite("position_tolerance", options.position_tolerance);
  require_finite("orientation_tolerance", options.orientation_tolerance);
  msg::Goal goal;
  goal.arm(arm);
  goal.kind(kind);
  if (options.time_limit < kForever) goal.time_limit(options.time_limit.count());
  return goal;
}

std::string sentence(const Unreachable::Reason& reason) {
  return reason.what_to_do.empty() ? reason.why : reason.why + ": " + reason.what_to_do;
}

OutcomeKind kind_of(GoalState state) {
  switch (state) {
    case GoalState::kReached:
      return OutcomeKind::kReached;
    case GoalState::kRejected:
      return OutcomeKind::kRejected;
    case GoalState::kCancelled:
      return OutcomeKind::kCancelled;
    case GoalState::kReplaced:
      return OutcomeKind::kReplaced;
    case GoalState::kTimedOut:
      return OutcomeKind::kTimedOut;
    case GoalState::kBlocked:
      return OutcomeKind::kBlocked;
    case GoalState::kAccepted:
    case GoalState::kActive:
      return OutcomeKind::kActive;
  }
  return OutcomeKind::kActive;
}

}  // namespace

Unreachable::Unreachable(Reason reason) : Error(sentence(reason)), reason_(std::move(reason)) {}
Rejected::Rejected(Cause cause) : Error(cause.text), cause_(std::move(cause)) {}

std::string Outcome::text() const {
  if (kind == OutcomeKind::kUnanswered) return "unanswered: no planner of the arm has answered the goal";
  std::string text = kind == OutcomeKind::kInterrupted ? "interrupted" : std::string(name_of(progress->state));
  // A planner reports an active goal ten times a second.
  constexpr Seconds kSilence{1.5};
  const bool continues = kind == OutcomeKind::kActive || kind == OutcomeKind::kBlocked;
  if (continues && progress && progress->age > kSilence) {
    text = "no planner of the arm has answered for " + std::to_string(std::lround(progress->age.count())) +
           " s; the goal was " + text;
  }
  if (!progress || kind == OutcomeKind::kReached) return text;
  if (progress->cause) text += ": " + progress->cause.text;
  if (progress->binding) text += " (" + progress->binding->own + " – " + progress->binding->other + ")";
  return text;
}

Goal::Goal(std::shared_ptr<Connection> connection, std::shared_ptr<client::GoalRecord> record)
    : connection_(std::move(connection)), record_(std::move(record)) {}

const std::string& Goal::id() const {
  return record_->goal.goal();
}

const std::string& Goal::arm() const {
  return record_->goal.arm();
}

std::optional<Progress> Goal::progress() const {
  return connection_->progress_of(*record_);
}

void Goal::on_progress(std::function<void(const Progress&)> callback) const {
  connection_->set_callback(record_, std::move(callback));
}

Outcome Goal::wait(const Wait& wait) const {
  Outcome outcome;
  const auto ended = [&] {
    outcome.progress = progress();
    return outcome.progress && is_final(outcome.progress->state);
  };
  const bool over = connection_->wait_until(ended, wait);
  if (!over) outcome.progress = progress();  // its age grows without news
  outcome.kind = !over && wait.stop.stop_requested() ? OutcomeKind::kInterrupted
                 : outcome.progress                  ? kind_of(outcome.progress->state)
                                                     : OutcomeKind::kUnanswered;
  return outcome;
}

void Goal::cancel() const {
  connection_->cancel(*record_);
}

Arm::Arm(std::shared_ptr<Connection> connection, std::string name)
    : connection_(std::move(connection)), name_(std::move(name)) {}

Goal Arm::go_to(const std::string& named, const GoalOptions& options) const {
  msg::Goal goal = goal_for(name_, msg::GoalKind::GOAL_NAMED, options);
  goal.named(named);
  return {connection_, connection_->send(std::move(goal))};
}

Goal Arm::go_to(const std::vector<double>& q, const GoalOptions& options) const {
  if (q.size() > msg::MAX_JOINTS) {
    throw InvalidArgument("q = " + std::to_string(q.size()) + " joint positions must be at most " +
                          std::to_string(msg::MAX_JOINTS));
  }
  for (std::size_t i = 0; i < q.size(); ++i) require_finite("q[" + std::to_string(i) + "]", q[i]);
  msg::Goal goal = goal_for(name_, msg::GoalKind::GOAL_JOINTS, options);
  goal.q(q);
  return {connection_, connection_->send(std::move(goal))};
}

Goal Arm::go_to(const Pose& tool, const GoalOptions& options) const {
  msg::Goal goal = goal_for(name_, msg::GoalKind::GOAL_POSE, options);
  goal.tool().X_WT(client::to_message(tool));
  const msg::Pose& X_WT = goal.tool().X_WT();
  for (const double value : {X_WT.position().x(), X_WT.position().y(), X_WT.position().z()}) {
    require_finite("a coordinate of the tool", value);
  }
  for (const double value : {X_WT.qw(), X_WT.qx(), X_WT.qy(), X_WT.qz()}) {
    require_finite("a component of the tool's quaternion", value);
  }
  goal.tool().free_rotation(static_cast<msg::FreeRotation>(options.free_rotation));
  goal.tool().position_tolerance(options.position_tolerance);
  goal.tool().orientation_tolerance(options.orientation_tolerance);
  return {connection_, connection_->send(std::move(goal))};
}

Goal Arm::follow(const Trajectory& trajectory, const GoalOptions& options) const {
  msg::Goal goal = goal_for(name_, msg::GoalKind::GOAL_TRAJECTORY, options);
  goal.trajectory(client::to_message(trajectory));
  return {connection_, connection_->send(std::move(goal))};
}

ArmState Arm::state(const Wait& wait) const {
  const auto heard = connection_->arm_state(name_, wait);
  if (heard) return client::to_public(heard->value, heard->age);
  if (wait.stop.stop_requested()) throw Interrupted("the wait for the state of arm '" + name_ + "' was interrupted");
  throw Unreachable({"no driver of arm '" + name_ + "' publishes in " + connection_->where(), {}, "driver/" + name_});
}

std::optional<Progress> Arm::goal() const {
  return connection_->newest_progress(name_);
}

void Arm::hold(const Wait& wait) const {
  order(*connection_, msg::RequestKind::REQUEST_HOLD, {name_}, wait);
}

void Arm::resume(const Wait& wait) const {
  order(*connection_, msg::RequestKind::REQUEST_RESUME, {name_}, wait);
}

void Arm::stop(const Wait& wait) const {
  order(*connection_, msg::RequestKind::REQUEST_STOP, {name_}, wait);
}

void Arm::set_speed(double speed, const Wait& wait) const {
  order_speed(*connection_, speed, {name_}, wait);
}

void Arm::close_gripper(const GripOptions& options, const Wait& wait) const {
  order_gripper(*connection_, name_, msg::DeviceOrder::DEVICE_CLOSE_TOOL, options, wait);
}

void Arm::open_gripper(const GripOptions& options, const Wait& wait) const {
  order_gripper(*connection_, name_, msg::DeviceOrder::DEVICE_OPEN_TOOL, options, wait);
}

void Arm::set_signal(const std::string& name, double value, const Wait& wait) const {
  order_value(*connection_, name_, msg::DeviceOrder::DEVICE_SET_SIGNAL, name, value, wait);
}

void Arm::place_joint(const std::string& joint, double position, const Wait& wait) const {
  order_value(*connection_, name_, msg::DeviceOrder::DEVICE_PLACE_JOINT, joint, position, wait);
}

ToolState Arm::tool(const Wait& wait) const {
  const auto heard = connection_->tool_state(name_, wait);
  if (heard) return client::to_public(heard->value, heard->age);
  if (wait.stop.stop_requested()) throw Interrupted("the wait for the tool of arm '" + name_ + "' was interrupted");
  throw Unreachable({"no driver of arm '" + name_ + "' publishes a gripper or signals in " + connection_->where() +
                         ": has the arm the keys gripper or signals?",
                     {},
                     "driver/" + name_});
}

bool Arm::wait_for_signal(const std::string& name, double lowest, double highest, const Wait& wait) const {
  const ToolState now = tool(wait);
  const bool has =
      std::any_of(now.signals.begin(), now.signals.end(), [&](const Signal& signal) { return signal.name == name; });
  if (!has) throw Rejected({CauseKind::kUnknownName, name, "arm " + name_ + " has no signal " + name});
  const auto heard = connection_->tool_state(name_, wait, [&](const msg::ToolState& state) {
    return std::any_of(state.signals().begin(), state.signals().end(), [&](const msg::Signal& signal) {
      return signal.name() == name && signal.known() && signal.value() >= lowest && signal.value() <= highest;
    });
  });
  if (!heard && wait.stop.stop_requested()) throw Interrupted("the wait for signal '" + name + "' was interrupted");
  return heard.has_value();
}

World::World(std::shared_ptr<Connection> connection) : connection_(std::move(connection)) {}

Receipt World::add(const std::string& name, const Shape& shape, const Pose& pose, const Motion& motion,
                   const Wait& wait) const {
  msg::WorldEditRequest request = request_for(msg::EditKind::EDIT_ADD, name);
  request.obstacle(client::to_message(name, shape, pose, motion));
  return receipt_of(connection_->edit(std::move(request), wait));
}

Receipt World::replace(const std::string& name, const Shape& shape, const Pose& pose, const Motion& motion,
                       const Wait& wait) const {
  msg::WorldEditRequest request = request_for(msg::EditKind::EDIT_REPLACE, name);
  request.obstacle(client::to_message(name, shape, pose, motion));
  return receipt_of(connection_->edit(std::move(request), wait));
}

Receipt World::move(const std::string& name, const Pose& pose, const Wait& wait) const {
  msg::WorldEditRequest request = request_for(msg::EditKind::EDIT_MOVE, name);
  request.X_WO(client::to_message(pose));
  return receipt_of(connection_->edit(std::move(request), wait));
}

Receipt World::remove(const std::string& name, const Wait& wait) const {
  return receipt_of(connection_->edit(request_for(msg::EditKind::EDIT_REMOVE, name), wait));
}

Receipt World::attach(const std::string& arm, const std::string& object, const Wait& wait) const {
  msg::WorldEditRequest request = request_for(msg::EditKind::EDIT_ATTACH, object);
  request.arm(arm);
  return receipt_of(connection_->edit(std::move(request), wait));
}

Receipt World::detach(const std::string& arm, const std::string& object, const Wait& wait) const {
  msg::WorldEditRequest request = request_for(msg::EditKind::EDIT_DETACH, object);
  request.arm(arm);
  return receipt_of(connection_->edit(std::move(request), wait));
}

std::vector<ObstacleState> World::obstacles(const Wait& wait) const {
  const auto scene = connection_->scene(wait);
  if (!scene && wait.stop.stop_requested()) throw Interrupted("the wait for the obstacles was interrupted");
  if (!scene) throw Unreachable({"no world service publishes in " + connection_->where(), {}, "the node world"});
  std::vector<ObstacleState> obstacles;
  for (const msg::ObstacleState& state : scene->states.value.states()) {
    const msg::Vec3& v = state.velocity().linear();
    ObstacleState& obstacle = obstacles.emplace_back();
    obstacle.name = state.name();
    obstacle.pose = client::to_public(state.X_WO());
    obstacle.velocity = {v.x(), v.y(), v.z()};
    obstacle.age = scene->states.age;
    const std::string& carrier = scene->shapes.at(state.name()).obstacle().attached_to();
    if (!carrier.empty()) obstacle.attached_to = carrier;
  }
  return obstacles;
}

Cell Cell::connect(const std::string& cell_file, const Wait& wait) {
  return connect(ConnectOptions{cell_file, std::nullopt}, wait);
}

Cell Cell::connect(const ConnectOptions& options, const Wait& wait) {
  Cell cell(Connection::make(client::join(options)));
  cell.connection_->wait_for_cell(wait);
  return cell;
}

Cell::Cell(std::shared_ptr<Connection> connection) : connection_(std::move(connection)) {}

Arm Cell::arm(const std::string& name) const {
  const std::vector<std::string> known = arms();
  if (!known.empty() && std::find(known.begin(), known.end(), name) == known.end()) {
    const std::vector<std::string_view> words(known.begin(), known.end());
    throw InvalidArgument("'" + config::printable(name) + "' is no arm of the cell; its arms are " +
                          config::listed(words));
  }
  return {connection_, name};
}

std::vector<std::string> Cell::arms() const {
  return connection_->arms();
}

World Cell::world() const {
  return World(connection_);
}

CellStatus Cell::status(const Wait& wait) const {
  return client::to_public(connection_->status(wait));
}

Receipt Cell::hold(const Wait& wait) const {
  return hold(std::vector<std::string>(), wait);
}

Receipt Cell::resume(const Wait& wait) const {
  return resume(std::vector<std::string>(), wait);
}

Receipt Cell::stop(const Wait& wait) const {
  return stop(std::vector<std::string>(), wait);
}

Receipt Cell::hold(const std::vector<std::string>& arms, const Wait& wait) const {
  return order(*connection_, msg::RequestKind::REQUEST_HOLD, arms, wait);
}

Receipt Cell::resume(const std::vector<std::string>& arms, const Wait& wait) const {
  return order(*connection_, msg::RequestKind::REQUEST_RESUME, arms, wait);
}

Receipt Cell::stop(const std::vector<std::string>& arms, const Wait& wait) const {
  return order(*connection_, msg::RequestKind::REQUEST_STOP, arms, wait);
}

Receipt Cell::set_speed(double speed, const Wait& wait) const {
  return order_speed(*connection_, speed, {}, wait);
}

Receipt Cell::set_speed(double speed, const std::vector<std::string>& arms, const Wait& wait) const {
  return order_speed(*connection_, speed, arms, wait);
}

std::vector<SavedRecording> Cell::save_recordings(const Wait& wait) const {
  std::vector<SavedRecording> saved;
  for (const msg::RecorderReply& reply : connection_->order_recorders(wait)) {
    if (!reply.done()) throw Rejected(client::to_public(reply.cause()));
    saved.push_back({reply.host(), reply.file()});
  }
  return saved;
}

std::vector<Fault> Cell::faults() const {
  std::vector<Fault> faults;
  for (const msg::Fault& fault : connection_->faults()) faults.push_back(client::to_public(fault));
  return faults;
}

void Cell::on_fault(std::function<void(const Fault&)> callback) const {
  connection_->set_fault_callback(std::move(callback));
}

std::vector<Outcome> Cell::wait_all(const std::vector<Goal>& goals, const Wait& wait) const {
  const auto until = client::deadline_of(wait.limit);
  std::vector<Outcome> outcomes;
  for (const Goal& goal : goals) outcomes.push_back(goal.wait({until - client::Clock::now(), wait.stop}));
  return outcomes;
}

bool Cell::wait_until(const std::function<bool()>& condition, const Wait& wait) const {
  return connection_->wait_until(condition, wait);
}

}  // namespace hecaton
