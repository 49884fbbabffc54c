#include "services/ros2/trajectory_server.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "services/client/convert.hpp"
#include "services/ros2_messages/time.hpp"
#include "services/runtime/log.hpp"

namespace hecaton::ros2 {
namespace {

using namespace std::chrono_literals;

constexpr auto kFeedbackPeriod = 40ms;
constexpr std::size_t kMostReplaced = 16;  // trajectories that wait for an answer of the planner
/// After a restart, clients of the earlier process are discovered within this time.
constexpr auto kRediscovery = 3s;

std::string action_name(const std::string& ns, const planner::Arm& arm) {
  return ns + "/" + arm.name + "/follow_joint_trajectory/_action/";
}

/// Why the arm is late or the goal has ended, with the pair of bodies that bounds the motion.
std::string reason_of(const Progress& progress) {
  const std::string& text = progress.cause.text;
  if (!progress.binding) return text;
  const std::string pair = progress.binding->own + " is " + std::to_string(progress.binding->distance).substr(0, 5) +
                           " m from " + progress.binding->other;
  return text.empty() ? pair : text + " (" + pair + ")";
}

double in_seconds(bus::Clock::duration time) {
  return std::chrono::duration<double>(time).count();
}

double seconds_of(const Time& stamp) {
  return static_cast<double>(stamp.sec) + 1e-9 * static_cast<double>(stamp.nanosec);
}

planner::JointVector measured(const ArmSnapshot& arm) {
  const auto& q = arm.state->value.q();
  return Eigen::Map<const Eigen::VectorXd>(q.data(), std::ssize(q));
}

}  // namespace

TrajectoryServer::TrajectoryServer(bus::Participant& participant, const std::string& ns, const planner::Arm& arm,
                                   const std::shared_ptr<client::Connection>& connection, bus::Mailbox& mailbox,
                                   const std::string& checkpoint)
    : arm_(arm),
      connection_(connection),
      checkpoint_(checkpoint),
      send_goal_(participant, service_of(action_name(ns, arm) + "send_goal", type::kSendTrajectory), mailbox),
      cancel_goal_(participant, service_of(action_name(ns, arm) + "cancel_goal", type::kCancelGoal), mailbox),
      get_result_(participant, service_of(action_name(ns, arm) + "get_result", type::kTrajectoryResult), mailbox),
      feedback_(participant, action_name(ns, arm) + "feedback", type::kTrajectoryFeedback),
      status_(participant, action_name(ns, arm) + "status", type::kGoalStatuses, Delivery::kLatched),
      cancellations_(arm.name),
      unreadable_(action_name(ns, arm), "control_msgs/action/FollowJointTrajectory") {
  restore();
}

// A killed process leaves goals of three kinds. The planner reports those that it has received. Those that it never
// received end as lost. Those that have ended here, but perhaps not there, have no client any more: they are cancelled.
void TrajectoryServer::restore() {
  const auto saved = checkpoint_.load(arm_.name);
  if (!saved) return;
  restored_ = Clock::now();
  goals_.restore(saved->goals);
  for (const SavedRequest& request : saved->requests) {
    waiting_.add(request.goal.uuid, bus::ros2::RequestId{{request.client}, request.number});
  }
  std::vector<std::string> ownerless = saved->uncancelled;
  for (const SavedTrajectory& active : saved->active) {
    // The planner may still follow these, if it has not received the trajectory.
    ownerless.insert(ownerless.end(), active.replaced.begin(), active.replaced.end());
    if (!restore(active, restored_)) ownerless.push_back(active.goal);
  }
  for (const std::string& goal : ownerless) {
    if (!goal.empty()) cancel(client::Connection::adopt(connection_, arm_.name, goal), restored_);
  }
  for (const SavedGoal& goal : saved->goals) {
    const ActionGoals::Id& id = goal.info.goal_id.uuid;
    if (goals_.result(id) || (active_ && active_->id == id)) continue;
    goals_.end(id, ActionGoals::kAborted,
               {static_cast<std::int32_t>(TrajectoryCode::kInvalidGoal),
                "the trajectory does not go on after a restart of hecaton-ros2"},
               restored_);
  }
  save();
  status_.publish(goals_.statuses());
}

bool TrajectoryServer::restore(const SavedTrajectory& active, Clock::time_point now) {
  const ActionGoals::Id& id = active.id.uuid;
  const auto joints = static_cast<std::ptrdiff_t>(active.start.size());
  if (active_ || active.goal.empty() || goals_.result(id) || joints != arm_.model->joints()) return false;
  const planner::JointVector start = Eigen::Map<const Eigen::VectorXd>(active.start.data(), joints);
  auto checked = check_trajectory(active.order, arm_, start, 0.0);
  auto* order = std::get_if<TrajectoryOrder>(&checked);
  if (order == nullptr) return false;
  const Clock::time_point begun = std::min(now, time_of(active.begun_ns));
  active_.emplace(Active{id,
                         TrajectoryFollower(std::move(*order), in_seconds(now - begun)),
                         active.order,
                         client::Connection::adopt(connection_, arm_.name, active.goal),
                         {},
                         begun,
                         now,
                         std::nullopt,
                         true});
  if (active.canceling) {
    active_->cancellation.emplace();
    cancel_active(now);
  }
  services::log_info("trajectory continues after a restart", {{"arm", arm_.name}, {"goal", active.goal}});
  return true;
}

/// Before a client is answered: the answer is a promise.
void TrajectoryServer::save() {
  SavedAction action{arm_.name, goals_.saved(), {}, {}, cancellations_.unsent()};
  for (const auto& [goal, request] : waiting_.all()) {
    action.requests.push_back({{goal}, request.client.bytes, request.number});
  }
  if (active_) {
    const planner::JointVector& start = active_->follower.order().start;
    std::vector<std::string> replaced;
    for (const Goal& goal : active_->replaced) replaced.push_back(goal.id());
    action.active.push_back({{active_->id},
                             active_->goal.id(),
                             active_->order,
                             {start.begin(), start.end()},
                             stamp_of(active_->begun),
                             active_->cancellation.has_value(),
                             std::move(replaced)});
  }
  checkpoint_.save(action);
}

// Requests are numbered for each client and service only. When a goal and a cancellation of all goals arrive together,
// their order is not known, and the cancellation comes first. A client that must cancel a new goal waits for its
// acceptance. One that cancels all goals before a new one need not wait. A cancellation that names its goal comes
// behind it.
void TrajectoryServer::update(const ArmSnapshot& arm, const ArmReadiness& readiness, Clock::time_point now) {
  const std::vector<CancelRequest> of_unknown_goals = take_cancellations(now);
  take_goals(arm, readiness, now);
  for (const CancelRequest& request : of_unknown_goals) carry_out(request, now);
  cancellations_.retry(now);
  follow(arm, readiness.planner_heard, now);
  take_result_requests(now);
  send_results(now);
  goals_.forget_old(now);
}

void TrajectoryServer::take_goals(const ArmSnapshot& arm, const ArmReadiness& readiness, Clock::time_point now) {
  for (const bus::ros2::Request& request : send_goal_.take()) {
    const auto goal = decoded<SendGoalRequest>(request.bytes);
    if (!goal) {
      unreadable_.note(now);
      continue;
    }
    const Time stamp = ros_time(std::chrono::system_clock::now());
    const bool accepted = goals_.add(goal->goal_id.uuid, stamp);
    if (accepted) accept(*goal, arm, readiness, now);
    send_goal_.reply(request.id, encoded(SendGoalResponse{accepted, stamp}));
  }
}

// An arm that was stopped keeps its trajectory, which the person who resumes it can know. A later one would move the
// arm by that resume, perhaps long after its sender has ended.
void TrajectoryServer::accept(const SendGoalRequest& request, const ArmSnapshot& arm, const ArmReadiness& readiness,
                              Clock::time_point now) {
  const ActionGoals::Id& id = request.goal_id.uuid;
  const auto refuse = [&](TrajectoryCode code, const std::string& text) {
    goals_.end(id, ActionGoals::kAborted, {static_cast<std::int32_t>(code), text}, now);
    services::log_info("trajectory refused", {{"arm", arm_.name}, {"reason", text}});
    save();
    status_.publish(goals_.statuses());
  };
  if (arm.kinematics == nullptr) {
    return refuse(TrajectoryCode::kInvalidGoal, "the driver of arm " + arm_.name + " has sent no state");
  }
  if (readiness.latched_by) {
    return refuse(TrajectoryCode::kInvalidGoal, *readiness.latched_by + "; resume it, then send the trajectory again");
  }
  const Time& begin = request.goal.trajectory.header.stamp;
  const double age =
      is_stamp_zero(begin) ? 0.0 : seconds_of(ros_time(std::chrono::system_clock::now())) - seconds_of(begin);
  auto checked = check_trajectory(request.goal, arm_, measured(arm), age);
  if (const auto* refusal = std::get_if<TrajectoryRefusal>(&checked)) return refuse(refusal->code, refusal->text);
  std::vector<Goal> replaced = replaceable();
  if (replaced.size() > kMostReplaced) {
    return refuse(TrajectoryCode::kInvalidGoal, "the planner of arm " + arm_.name + " has not answered the last " +
                                                    std::to_string(kMostReplaced) + " trajectories");
  }
  auto& order = std::get<TrajectoryOrder>(checked);
  std::optional<Goal> goal;
  try {
    goal = prepared(order.trajectory);
  } catch (const Error& error) {
    return refuse(TrajectoryCode::kInvalidGoal, error.what());
  }
  if (active_ && active_->cancellation) {
    end_active(ActionGoals::kCanceled, TrajectoryCode::kSuccessful, "canceled by its client", now);
  } else if (active_) {
    end_active(ActionGoals::kAborted, TrajectoryCode::kInvalidGoal, "a later trajectory has replaced this one", now);
  }
  active_.emplace(Active{id, TrajectoryFollower(std::move(order)), request.goal, *goal, std::move(replaced), now, now});
  services::log_info("trajectory accepted", {{"arm", arm_.name}, {"duration_s", active_->follower.order().duration()}});
  // All of the replacement at once, before the planner can receive it: a successor of this process then knows each goal
  // that the planner may have.
  save();
  send_goal(now);
  status_.publish(goals_.statuses());
}

std::vector<Goal> TrajectoryServer::replaceable() const {
  if (!active_) return {};
  std::vector<Goal> goals;
  const auto progress = active_->goal.progress();
  if (!progress || progress->state == GoalState::kRejected) goals = active_->replaced;
  if (!progress || !is_final(progress->state)) goals.push_back(active_->goal);
  return goals;
}

std::vector<TrajectoryServer::CancelRequest> TrajectoryServer::take_cancellations(Clock::time_point now) {
  std::vector<CancelRequest> of_unknown_goals;
  for (const bus::ros2::Request& request : cancel_goal_.take()) {
    const auto cancel = decoded<CancelGoalRequest>(request.bytes);
    if (!cancel) {
      unreadable_.note(now);
      continue;
    }
    const ActionGoals::Id& id = cancel->goal_info.goal_id.uuid;
    const CancelRequest each{request.id, cancel->goal_info};
    if (id == ActionGoals::Id{} || goals_.knows(id)) {
      carry_out(each, now);
    } else {
      of_unknown_goals.push_back(each);
    }
  }
  return of_unknown_goals;
}

void TrajectoryServer::carry_out(const CancelRequest& request, Clock::time_point now) {
  const CancelGoalResponse response = goals_.cancellable(request.goal);
  for (const GoalInfo& goal : response.goals_canceling) {
    if (!active_ || active_->id != goal.goal_id.uuid || active_->cancellation) continue;
    active_->cancellation.emplace();
    active_->updated = now;
    goals_.set_status(active_->id, ActionGoals::kCanceling);
    save();  // a successor of this process cancels it, too
    cancel_active(now);
    status_.publish(goals_.statuses());
  }
  cancel_goal_.reply(request.id, encoded(response));
}

void TrajectoryServer::take_result_requests(Clock::time_point now) {
  for (const bus::ros2::Request& request : get_result_.take()) {
    const auto wanted = decoded<GetResultRequest>(request.bytes);
    if (!wanted) {
      unreadable_.note(now);
      continue;
    }
    waiting_.add(wanted->goal_id.uuid, request.id);
    if (!goals_.result(wanted->goal_id.uuid)) save();
  }
}

void TrajectoryServer::send_results(Clock::time_point now) {
  if (now < restored_ + kRediscovery) return;
  const std::size_t answered = waiting_.answer([&](const ResultRequests::Entry& entry) {
    const auto result = goals_.result(entry.goal);
    if (!result) return false;
    get_result_.reply(entry.request, encoded(*result));
    return true;
  });
  if (answered > 0) save();
}

Goal TrajectoryServer::prepared(const planner::TimedTrajectory& from) const {
  const auto values = [](const planner::JointVector& q) { return std::vector<double>(q.begin(), q.end()); };
  const auto all_have = [&](auto member) {
    return std::all_of(from.points.begin(), from.points.end(),
                       [&](const auto& point) { return (point.*member).size() > 0; });
  };
  const bool qd = all_have(&planner::TimedPoint::qd);
  const bool qdd = qd && all_have(&planner::TimedPoint::qdd);
  Trajectory trajectory;
  for (const planner::TimedPoint& point : from.points) {
    TrajectoryPoint& to = trajectory.points.emplace_back();
    to.time = Seconds(point.time);
    to.q = values(point.q);
    if (qd) to.qd = values(point.qd);
    if (qdd) to.qdd = values(point.qdd);
  }
  if (from.has_path_tolerance()) {
    for (const double tolerance : from.path_tolerance) {
      trajectory.path_tolerance.push_back(std::isfinite(tolerance) ? tolerance : 0.0);
    }
  }
  msg::Goal goal;
  goal.arm(arm_.name);
  goal.kind(msg::GoalKind::GOAL_TRAJECTORY);
  goal.trajectory(client::to_message(trajectory));
  return client::Connection::prepare(connection_, std::move(goal));
}

void TrajectoryServer::send_goal(Clock::time_point now) {
  try {
    connection_->send_prepared(active_->goal);
  } catch (const Error& error) {
    for (const Goal& goal : active_->replaced) cancel(goal, now);
    finish(ActionGoals::kAborted, TrajectoryCode::kInvalidGoal, error.what(), now);
  }
}

void TrajectoryServer::follow(const ArmSnapshot& arm, bool planner_heard, Clock::time_point now) {
  if (!active_) return;
  if (active_->cancellation) return await_cancellation(planner_heard, now);
  TrajectoryFollower::Input input{std::nullopt, in_seconds(now - active_->updated)};
  input.heard = planner_heard;
  if (arm.kinematics != nullptr) {
    input.q = measured(arm);
    input.q_age = in_seconds(now - arm.state->received);
  }
  active_->updated = now;
  bool over = false;
  const auto progress = active_->goal.progress();
  if (!progress) {
    input.report =
        active_->restored ? TrajectoryFollower::GoalReport::kUnreported : TrajectoryFollower::GoalReport::kUnanswered;
  }
  if (progress) {
    input.reported = progress->elapsed.count();
    over = is_final(progress->state);
    if (progress->state != GoalState::kRejected && !active_->replaced.empty()) {
      active_->replaced.clear();  // the planner has left them
      save();
    }
    input.reason = reason_of(*progress);
    if (progress->trajectory_time) input.time = progress->trajectory_time->count();
    input.rate = progress->trajectory_rate;
    if (progress->state == GoalState::kReached) input.report = TrajectoryFollower::GoalReport::kReached;
    if (progress->state == GoalState::kRejected) input.report = TrajectoryFollower::GoalReport::kRejected;
    if (progress->state == GoalState::kReplaced) input.report = TrajectoryFollower::GoalReport::kReplaced;
    if (over && progress->cause.kind == CauseKind::kPathTolerance) {
      input.report = TrajectoryFollower::GoalReport::kLeftPath;
    }
    if (over && input.report == TrajectoryFollower::GoalReport::kUnderWay) {
      input.report = TrajectoryFollower::GoalReport::kLost;
    }
  }
  if (const auto end = active_->follower.update(input)) {
    const bool done = end->code == TrajectoryCode::kSuccessful;
    // Also when the arm rests near enough: its planner would go on, and move the arm after the result.
    if (!done || !over) cancel_active(now);
    return finish(done ? ActionGoals::kSucceeded : ActionGoals::kAborted, end->code, end->text, now);
  }
  const bool time_is_known = progress || !active_->restored;  // after a restart the planner says it
  if (arm.kinematics != nullptr && time_is_known && now >= fed_back_ + kFeedbackPeriod) {
    fed_back_ = now;
    publish_feedback(arm);
  }
}

void TrajectoryServer::await_cancellation(bool planner_heard, Clock::time_point now) {
  const auto progress = active_->goal.progress();
  CancellationWait::Input input{in_seconds(now - active_->updated)};
  active_->updated = now;
  input.heard = planner_heard;
  input.restored = active_->restored;
  input.over = progress && is_final(progress->state);
  if (progress) input.reported = progress->elapsed.count();
  if (const auto end = active_->cancellation->update(input)) {
    finish(ActionGoals::kCanceled, TrajectoryCode::kSuccessful, *end, now);
  }
}

void TrajectoryServer::cancel_active(Clock::time_point now) {
  for (const Goal& goal : active_->replaced) cancel(goal, now);
  cancel(active_->goal, now);
}

void TrajectoryServer::cancel(const Goal& goal, Clock::time_point now) {
  cancellations_.add(
      goal.id(), [goal] { goal.cancel(); }, now);
}

void TrajectoryServer::finish(std::int8_t status, TrajectoryCode code, const std::string& text, Clock::time_point now) {
  end_active(status, code, text, now);
  save();
  status_.publish(goals_.statuses());
}

void TrajectoryServer::end_active(std::int8_t status, TrajectoryCode code, const std::string& text,
                                  Clock::time_point now) {
  goals_.end(active_->id, status, {static_cast<std::int32_t>(code), text}, now);
  services::log_info("trajectory ended", {{"arm", arm_.name}, {"status", static_cast<int>(status)}, {"reason", text}});
  active_.reset();
}

void TrajectoryServer::publish_feedback(const ArmSnapshot& arm) {
  if (!feedback_.wanted()) return;
  FeedbackMessage message;
  message.goal_id.uuid = active_->id;
  TrajectoryFeedback& feedback = message.feedback;
  feedback.header.stamp = ros_time(arm.state->received);
  feedback.joint_names = active_->order.trajectory.joint_names;
  const TrajectoryFollower& follower = active_->follower;
  const planner::JointState desired = follower.order().at(follower.time());
  const planner::JointVector q = measured(arm);
  const planner::JointVector error = follower.order().error(q, follower.time());
  const auto& qd = arm.state->value.qd();
  const auto joints = joint_numbers(feedback.joint_names, arm_);
  for (const int j : *joints) {
    feedback.desired.positions.push_back(desired.q[j]);
    feedback.desired.velocities.push_back(follower.rate() * desired.qd[j]);
    feedback.actual.positions.push_back(q[j]);
    if (std::ssize(qd) == q.size()) feedback.actual.velocities.push_back(qd[static_cast<std::size_t>(j)]);
    feedback.error.positions.push_back(error[j]);
  }
  feedback.desired.time_from_start = ros_duration(follower.time());
  feedback.actual.time_from_start = feedback.desired.time_from_start;
  feedback.error.time_from_start = feedback.desired.time_from_start;
  feedback_.publish(message);
}

std::optional<OrderedPath> TrajectoryServer::path() const {
  if (!active_) return std::nullopt;
  OrderedPath path{arm_.name, {active_->follower.order().start}};
  for (const planner::TimedPoint& point : active_->follower.order().trajectory.points) path.points.push_back(point.q);
  return path;
}

NodeEndpoints TrajectoryServer::endpoints() const {
  NodeEndpoints endpoints{{}, {feedback_.id(), status_.id()}};
  for (const bus::ros2::Server* server : {&send_goal_, &cancel_goal_, &get_result_}) {
    endpoints.readers.push_back(server->reader_id());
    endpoints.writers.push_back(server->writer_id());
  }
  return endpoints;
}

}  // namespace hecaton::ros2
