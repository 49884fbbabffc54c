#include "services/planner/goal_manager.hpp"

#include <algorithm>
#include <cstdio>

#include "planner/model/fnv1a.hpp"
#include "services/messages/convert.hpp"
#include "services/runtime/cause.hpp"

namespace hecaton::services {
namespace {

using namespace std::chrono_literals;

constexpr auto kStatusPeriod = 100ms;     // of an active goal
constexpr auto kTrajectoryTime = 10s;     // for a client to send the trajectory of its goal again
constexpr auto kFreeTime = 500ms;         // of free motion after which an arm is not obstructed
constexpr auto kUnknownTime = 1s;         // in which the goal of a cancellation, or a status of it, may still arrive
constexpr auto kUnknownPeriod = 20ms;     // between two answers to such cancellations: a writer keeps few statuses
constexpr std::size_t kMostWaiting = 64;  // each may have 1 MB
constexpr std::size_t kRemembered = GoalSnapshot::kHandled;  // goals, to recognise repetitions

msg::Cause cancelled() {
  return make_cause(msg::CauseKind::CAUSE_GOAL_CANCELLED, {}, "its client cancelled it");
}

msg::Cause resumed(std::string text) {
  return make_cause(msg::CauseKind::CAUSE_GOAL_RESUMED, {}, std::move(text));
}

double seconds(std::chrono::steady_clock::duration duration) {
  return std::chrono::duration<double>(duration).count();
}

/// Digest of a goal or a cancellation of a client.
std::uint64_t digest(const msg::Goal& goal) {
  planner::Fnv1a hash;
  hash.add(goal.client() + "/" + goal.goal() + (goal.cancel() ? "/cancel" : ""));
  for (unsigned shift = 0; shift < 64; shift += 8) hash.add((goal.sequence_number() >> shift) & 0xFFU);
  return hash.value();
}

}  // namespace

GoalManager::GoalManager(std::string arm, std::string node) : arm_(std::move(arm)), node_(std::move(node)) {}

bool GoalManager::handled_before(const msg::Goal& goal) {
  const std::uint64_t id = digest(goal);
  if (std::find(handled_.begin(), handled_.end(), id) != handled_.end()) return true;
  handled_.push_back(id);
  if (handled_.size() > kRemembered) handled_.pop_front();
  return false;
}

void GoalManager::receive(const msg::Goal& goal, Clock::time_point now) {
  if (goal.arm() != arm_) return;
  if (awaits_trajectory() && active_->goal.goal() == goal.goal() && !goal.cancel()) {
    (void)handled_before(goal);
    return take_trajectory(goal);
  }
  if (handled_before(goal)) return;
  if (active_ && active_->followed && active_->goal.goal() == goal.goal() && !goal.cancel()) {
    active_->goal = goal;  // now its client is known
    active_->followed = false;
    return;
  }
  if (goal.cancel()) {
    const bool answered = cancel(goal.goal(), now) || has_ended(goal.goal());
    // The planner would reject a goal with a longer name.
    if (answered || goal.goal().size() > GoalSnapshot::kLongestName) return;
    unknown_.push_back({goal.goal(), digest(goal), now});
    if (unknown_.size() > kRemembered) unknown_.pop_front();
    return;
  }
  // A later goal replaces an earlier one: it must not be refused for those.
  if (waiting_.size() == kMostWaiting) {
    add_status(waiting_.front().goal, msg::GoalState::GOAL_REJECTED,
               make_cause(msg::CauseKind::CAUSE_NOT_ALLOWED_NOW, waiting_.front().goal.goal(),
                          std::to_string(kMostWaiting) + " later goals of this arm wait"));
    waiting_.pop_front();
  }
  waiting_.push_back({goal, now});
  const bool cancelled_before = std::erase_if(unknown_, [&](const auto& it) { return it.goal == goal.goal(); }) > 0;
  if (cancelled_before) (void)cancel(goal.goal(), now);
}

bool GoalManager::cancel(const std::string& goal, Clock::time_point now) {
  bool known = false;
  if (active_ && active_->goal.goal() == goal) {
    known = true;
    end_active(msg::GoalState::GOAL_CANCELLED, cancelled(), now);
  }
  if (resolving_ && resolving_->goal() == goal) known = resolving_cancelled_ = true;
  for (const Waiting& waiting : waiting_) {
    if (waiting.goal.goal() != goal) continue;
    known = true;
    add_status(waiting.goal, msg::GoalState::GOAL_CANCELLED, cancelled());
  }
  std::erase_if(waiting_, [&](const Waiting& waiting) { return waiting.goal.goal() == goal; });
  return known;
}

void GoalManager::answer_unknown_cancellations(Clock::time_point now) {
  while (!unknown_.empty()) {
    const std::string goal = unknown_.front().goal;
    const bool settled = has_ended(goal) || cancel(goal, now);  // a status of another planner has told of it
    if (!settled) {
      if (now - unknown_.front().since < kUnknownTime || now - answered_unknown_ < kUnknownPeriod) return;
      answered_unknown_ = now;
      msg::Goal of;
      of.goal(goal);
      add_status(of, msg::GoalState::GOAL_CANCELLED,
                 make_cause(msg::CauseKind::CAUSE_GOAL_CANCELLED, {},
                            "its client cancelled it before this planner received it"));
    }
    unknown_.pop_front();
  }
}

bool GoalManager::has_ended(const std::string& goal) const {
  return std::find(ended_.begin(), ended_.end(), goal) != ended_.end();
}

void GoalManager::remember_end(const std::string& goal) {
  if (goal.size() > GoalSnapshot::kLongestName || has_ended(goal)) return;
  ended_.push_back(goal);
  if (ended_.size() > kRemembered) ended_.pop_front();
}

std::optional<msg::Goal> GoalManager::next_to_resolve() {
  if (resolving_ || waiting_.empty()) return std::nullopt;
  resolving_ = std::move(waiting_.front().goal);
  resolving_cancelled_ = false;
  resolving_rejected_ = false;
  waiting_.pop_front();
  return resolving_;
}

void GoalManager::restart_waits(Clock::time_point now) {
  for (Waiting& waiting : waiting_) waiting.since = now;
  for (UnknownCancellation& cancellation : unknown_) cancellation.since = now;
}

void GoalManager::reject_expired(Clock::time_point now, Clock::duration limit, const msg::Cause& cause) {
  while (!waiting_.empty() && now - waiting_.front().since > limit) {
    add_status(waiting_.front().goal, msg::GoalState::GOAL_REJECTED, cause);
    waiting_.pop_front();
  }
}

void GoalManager::reject_all(const msg::Cause& cause) {
  if (resolving_ && !std::exchange(resolving_rejected_, true)) {
    add_status(*resolving_, resolving_cancelled_ ? msg::GoalState::GOAL_CANCELLED : msg::GoalState::GOAL_REJECTED,
               resolving_cancelled_ ? cancelled() : cause);
  }
  for (const Waiting& waiting : waiting_) add_status(waiting.goal, msg::GoalState::GOAL_REJECTED, cause);
  waiting_.clear();
}

void GoalManager::end_all(const msg::Cause& cause, Clock::time_point now) {
  if (active_) end_active(msg::GoalState::GOAL_CANCELLED, cause, now);
  reject_all(cause);
}

bool GoalManager::answer(const GoalAnswer& answer, Clock::time_point now) {
  resolving_.reset();
  if (resolving_rejected_) return false;
  if (resolving_cancelled_) {
    add_status(answer.goal, msg::GoalState::GOAL_CANCELLED, cancelled());
    return false;
  }
  if (answer.rejection) {
    add_status(answer.goal, msg::GoalState::GOAL_REJECTED, *answer.rejection);
    if (answer.nearest) {
      msg::GoalStatus& status = statuses_.back();
      status.has_nearest(true);
      status.X_WT_nearest(messages::to_message(answer.nearest->X_WT));
      status.nearest_angle(answer.nearest->angle);
    }
    return false;
  }
  if (answer.goal.goal().size() > GoalSnapshot::kLongestName ||
      answer.goal.client().size() > GoalSnapshot::kLongestName) {
    add_status(answer.goal, msg::GoalState::GOAL_REJECTED,
               make_cause(msg::CauseKind::CAUSE_GOAL_MALFORMED, {},
                          "the names of a goal and of its client must have at most " +
                              std::to_string(GoalSnapshot::kLongestName) + " bytes"));
    return false;
  }
  if (active_) {
    const std::string& later = answer.goal.goal();
    end_active(msg::GoalState::GOAL_REPLACED,
               make_cause(msg::CauseKind::CAUSE_GOAL_REPLACED, later, "goal " + later + " came later"), now);
  }
  activate(Active{.goal = answer.goal,
                  .q_goal = answer.q_goal,
                  .since = now,
                  .reported = now,
                  .state = msg::GoalState::GOAL_ACCEPTED,
                  .last = {},
                  .tool = answer.tool,
                  .note = answer.note,
                  .trajectory = answer.trajectory,
                  .trajectory_time = answer.trajectory ? 0.0 : -1.0});
  add_active_status(msg::GoalState::GOAL_ACCEPTED, {}, now);
  return true;
}

bool GoalManager::follow(const msg::GoalStatus& status, Clock::time_point now) {
  if (is_final(status.state())) {
    remember_end(status.goal());
    if (!active_ || active_->goal.goal() != status.goal()) return false;
    active_.reset();
    if (status.state() != msg::GoalState::GOAL_REACHED) change_ = planner::GoalChange{};
    return false;
  }
  if (active_ && active_->goal.goal() == status.goal()) {
    active_->trajectory_time = std::max(active_->trajectory_time, status.trajectory_time());
  }
  if (status.q_goal().empty() || knows(status.goal())) return false;
  const auto q_goal = Eigen::Map<const Eigen::VectorXd>(status.q_goal().data(), std::ssize(status.q_goal()));
  msg::Goal goal;
  goal.arm(arm_);
  goal.goal(status.goal());
  const auto elapsed = std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(status.elapsed()));
  std::optional<planner::ToolGoal> tool;
  if (status.has_tool()) {
    if (const auto told = messages::from_message(status.tool(), "status of goal " + status.goal())) tool = *told;
  }
  activate(Active{.goal = goal,
                  .q_goal = q_goal,
                  .since = now - elapsed,
                  .reported = now,
                  .state = status.state(),
                  .last = {},
                  .followed = true,
                  .tool = tool,
                  .note = status.note(),
                  .trajectory_time = status.trajectory_time()});
  return true;
}

bool GoalManager::knows(const std::string& goal) const {
  return std::find(activated_.begin(), activated_.end(), goal) != activated_.end() ||
         (resolving_ && resolving_->goal() == goal) ||
         std::any_of(waiting_.begin(), waiting_.end(), [&](const Waiting& w) { return w.goal.goal() == goal; });
}

void GoalManager::activate(Active active) {
  activated_.push_back(active.goal.goal());
  if (activated_.size() > kRemembered) activated_.pop_front();
  active_ = std::move(active);
  if (awaits_trajectory()) {
    change_ = planner::GoalChange{};
  } else {
    change_ = planner::GoalChange{active_->q_goal, active_->trajectory, std::max(0.0, active_->trajectory_time)};
  }
}

void GoalManager::take_trajectory(const msg::Goal& goal) {
  const auto joints = static_cast<int>(active_->q_goal.size());
  auto trajectory = messages::from_message(goal.trajectory(), "goal: trajectory", joints);
  if (!trajectory) return;  // another planner has accepted it: this does not happen
  active_->trajectory = std::make_shared<const planner::TimedTrajectory>(std::move(*trajectory.value));
  active_->q_goal = active_->trajectory->end();
  active_->goal = goal;
  active_->followed = false;
  change_ = planner::GoalChange{active_->q_goal, active_->trajectory, active_->trajectory_time};
}

GoalSnapshot GoalManager::snapshot(Clock::time_point now) const {
  GoalSnapshot snapshot;
  if (active_) {
    const msg::Goal& goal = active_->goal;
    snapshot.active = GoalSnapshot::Active{
        goal.goal(),     goal.client(), goal.sequence_number(),  goal.time_limit(), seconds(now - active_->since),
        active_->q_goal, active_->tool, active_->trajectory_time};
  }
  snapshot.results.assign(results_.begin(), results_.end());
  std::vector<std::uint64_t> unanswered;
  if (resolving_ && !resolving_rejected_) unanswered.push_back(digest(*resolving_));
  for (const Waiting& waiting : waiting_) unanswered.push_back(digest(waiting.goal));
  for (const UnknownCancellation& cancellation : unknown_) unanswered.push_back(cancellation.digest);
  for (const std::uint64_t id : handled_) {
    if (std::find(unanswered.begin(), unanswered.end(), id) == unanswered.end()) snapshot.handled.push_back(id);
  }
  const std::size_t forgotten = snapshot.handled.size() - std::min(snapshot.handled.size(), GoalSnapshot::kHandled);
  snapshot.handled.erase(snapshot.handled.begin(), snapshot.handled.begin() + static_cast<std::ptrdiff_t>(forgotten));
  return snapshot;
}

bool GoalManager::resume(const GoalSnapshot& snapshot, Clock::duration ago, Clock::time_point now) {
  handled_.insert(handled_.begin(), snapshot.handled.begin(), snapshot.handled.end());
  for (const GoalSnapshot::Result& end : snapshot.results) {
    msg::Goal goal;
    goal.goal(end.goal);
    add_status(goal, end.state, resumed("published again by a restarted planner"));
  }
  if (!snapshot.active) return false;
  const GoalSnapshot::Active& active = *snapshot.active;
  msg::Goal goal;
  goal.arm(arm_);
  goal.goal(active.goal);
  goal.client(active.client);
  goal.sequence_number(active.sequence_number);
  goal.time_limit(active.time_limit);
  const auto elapsed = std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(active.elapsed));
  const bool followed = active.client.empty();  // its client may still send it to this planner
  activate(Active{.goal = goal,
                  .q_goal = active.q_goal,
                  .since = now - elapsed - ago,
                  .reported = now,
                  .state = msg::GoalState::GOAL_ACTIVE,
                  .last = {},
                  .followed = followed,
                  .tool = active.tool,
                  .trajectory_time = active.trajectory_time});
  add_active_status(msg::GoalState::GOAL_ACTIVE, resumed("resumed by a restarted planner"), now);
  return true;
}

void GoalManager::keep_results(const std::vector<GoalSnapshot::Result>& results) {
  const std::size_t left = std::min(results.size(), GoalSnapshot::kResults);
  results_.assign(results.end() - static_cast<std::ptrdiff_t>(left), results.end());
}

void GoalManager::progress(const Progress& progress, Clock::time_point now) {
  if (!active_) return;
  Active& active = *active_;
  const bool priority_changed = progress.priority != active.last.priority;
  active.last = progress;
  if (awaits_trajectory()) {
    active.last.trajectory.reset();
    if (!active.awaiting_since) active.awaiting_since = now;
    const auto why =
        make_cause(msg::CauseKind::CAUSE_GOAL_NOT_RESOLVED, {},
                   "this planner has not received the trajectory of the goal from its client again, for which "
                   "it waits " +
                       std::to_string(std::chrono::seconds(kTrajectoryTime).count()) + " s");
    if (now - *active.awaiting_since > kTrajectoryTime) return end_active(msg::GoalState::GOAL_CANCELLED, why, now);
    if (now - active.reported >= kStatusPeriod) add_active_status(msg::GoalState::GOAL_BLOCKED, why, now);
    return;
  }
  if (progress.trajectory) {
    active.trajectory_time = std::max(active.trajectory_time, progress.trajectory->time);
    if (!is_none(progress.trajectory->left)) {
      return end_active(msg::GoalState::GOAL_CANCELLED, msg::Cause(progress.trajectory->left), now);
    }
  }
  update_hold(progress.obstructed, now);
  if (progress.state == msg::GoalState::GOAL_REACHED) {
    add_active_status(msg::GoalState::GOAL_REACHED, {}, now);
    active_.reset();
    return;
  }
  if (active.goal.time_limit() > 0.0 && seconds(now - active.since) > active.goal.time_limit()) {
    char text[64];
    std::snprintf(text, sizeof text, "not reached within %.6g s", active.goal.time_limit());
    const std::string why = is_none(progress.cause) ? "" : ": " + progress.cause.text();
    end_active(msg::GoalState::GOAL_TIMED_OUT,
               make_cause(msg::CauseKind::CAUSE_TIME_LIMIT, progress.cause.subject(), text + why), now);
    return;
  }
  if (progress.state != active.state || priority_changed || now - active.reported >= kStatusPeriod)
    add_active_status(progress.state, progress.cause, now);
}

void GoalManager::update_hold(bool obstructed, Clock::time_point now) {
  Active& active = *active_;
  if (obstructed) {
    if (!active.held_since) active.held_since = now;
    active.free_since.reset();
  } else if (active.held_since) {
    if (!active.free_since) active.free_since = now;
    if (now - *active.free_since >= kFreeTime) active.held_since.reset();
  }
}

void GoalManager::add_status(const msg::Goal& goal, msg::GoalState state, const msg::Cause& cause) {
  msg::GoalStatus& status = statuses_.emplace_back();
  status.arm(arm_);
  status.goal(goal.goal());
  status.node(node_);
  status.sequence_number(++sequence_);
  status.state(state);
  status.cause(cause);
  if (!is_final(state) || goal.goal().size() > GoalSnapshot::kLongestName) return;
  remember_end(goal.goal());
  results_.push_back({goal.goal(), state});
  if (results_.size() > GoalSnapshot::kResults) results_.pop_front();
}

void GoalManager::add_active_status(msg::GoalState state, const msg::Cause& cause, Clock::time_point now) {
  Active& active = *active_;
  active.state = state;
  active.reported = now;
  add_status(active.goal, state, cause);
  msg::GoalStatus& status = statuses_.back();
  status.has_binding(active.last.has_binding);
  status.binding_own(active.last.binding_own);
  status.binding_other(active.last.binding_other);
  status.binding_distance(active.last.binding_distance);
  status.recovery_action(active.last.recovery_action);
  status.blocked_duration(active.held_since ? seconds(now - *active.held_since) : 0.0);
  status.priority(active.last.priority);
  status.distance_to_goal(active.last.distance);
  status.elapsed(seconds(now - active.since));
  const bool on_the_way = active.last.trajectory && !is_final(state);
  status.q_goal(messages::to_message(on_the_way ? active.last.trajectory->q_next : active.q_goal));
  status.trajectory_time(active.trajectory_time);
  status.trajectory_rate(active.last.trajectory ? active.last.trajectory->rate : 0.0);
  status.note(active.note);
  status.has_tool(active.tool.has_value());
  if (active.tool) status.tool(messages::to_message(*active.tool));
  status.position_error(active.last.tool_error ? active.last.tool_error->position : -1.0);
  status.orientation_error(active.last.tool_error ? active.last.tool_error->orientation : -1.0);
}

void GoalManager::end_active(msg::GoalState state, const msg::Cause& cause, Clock::time_point now) {
  add_active_status(state, cause, now);
  active_.reset();
  change_ = planner::GoalChange{};
}

}  // namespace hecaton::services
