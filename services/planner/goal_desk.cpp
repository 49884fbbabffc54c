#include "services/planner/goal_desk.hpp"

#include <algorithm>
#include <cstdio>

#include "services/messages/convert.hpp"
#include "services/runtime/goal_state.hpp"

namespace hecaton::services {
namespace {

using namespace std::chrono_literals;

constexpr auto kRepeat = 100ms;                             // of an active goal's status
constexpr auto kFree = 500ms;                               // without a break, until an arm is no longer held back
constexpr std::size_t kRemembered = GoalAccount::kHandled;  // goals handled before, for repetitions
const std::string kGivenUp = "its client gave it up";

double seconds(std::chrono::steady_clock::duration duration) {
  return std::chrono::duration<double>(duration).count();
}

/// Of a goal or its cancellation, as its client sent it: FNV-1a, the same in every process.
std::uint64_t digest(const msg::Goal& goal) {
  std::uint64_t hash = 14695981039346656037U;
  const auto add = [&hash](unsigned char byte) { hash = (hash ^ byte) * 1099511628211U; };
  for (const char c : goal.client() + "/" + goal.goal() + (goal.cancel() ? "/cancel" : "")) {
    add(static_cast<unsigned char>(c));
  }
  for (unsigned shift = 0; shift < 64; shift += 8) add(static_cast<unsigned char>(goal.sequence_number() >> shift));
  return hash;
}

}  // namespace

GoalDesk::GoalDesk(std::string arm, std::string node) : arm_(std::move(arm)), node_(std::move(node)) {}

bool GoalDesk::handled_before(const msg::Goal& goal) {
  const std::uint64_t id = digest(goal);
  if (std::find(handled_.begin(), handled_.end(), id) != handled_.end()) return true;
  handled_.push_back(id);
  if (handled_.size() > kRemembered) handled_.pop_front();
  return false;
}

void GoalDesk::receive(const msg::Goal& goal, Clock::time_point now) {
  if (goal.arm() != arm_ || handled_before(goal)) return;
  if (active_ && active_->followed && active_->goal.goal() == goal.goal() && !goal.cancel()) {
    active_->goal = goal;  // now its client is known, too
    active_->followed = false;
    return;
  }
  if (goal.cancel()) {
    cancel(goal.goal(), now);
  } else {
    waiting_.push_back({goal, now});
  }
}

void GoalDesk::cancel(const std::string& goal, Clock::time_point now) {
  if (active_ && active_->goal.goal() == goal) end_active(msg::GoalState::GOAL_CANCELLED, kGivenUp, now);
  if (asked_ && asked_->goal() == goal) asked_cancelled_ = true;
  for (const Waiting& waiting : waiting_) {
    if (waiting.goal.goal() == goal) tell(waiting.goal, msg::GoalState::GOAL_CANCELLED, kGivenUp);
  }
  std::erase_if(waiting_, [&](const Waiting& waiting) { return waiting.goal.goal() == goal; });
}

std::optional<msg::Goal> GoalDesk::next_question() {
  if (asked_ || waiting_.empty()) return std::nullopt;
  asked_ = std::move(waiting_.front().goal);
  asked_cancelled_ = false;
  asked_refused_ = false;
  waiting_.pop_front();
  return asked_;
}

void GoalDesk::wait_from(Clock::time_point now) {
  for (Waiting& waiting : waiting_) waiting.since = now;
}

void GoalDesk::refuse_waiting(Clock::time_point now, Clock::duration limit, const std::string& reason) {
  while (!waiting_.empty() && now - waiting_.front().since > limit) {
    tell(waiting_.front().goal, msg::GoalState::GOAL_REJECTED, reason);
    waiting_.pop_front();
  }
}

void GoalDesk::refuse_all(const std::string& reason) {
  if (asked_ && !std::exchange(asked_refused_, true)) {
    tell(*asked_, asked_cancelled_ ? msg::GoalState::GOAL_CANCELLED : msg::GoalState::GOAL_REJECTED,
         asked_cancelled_ ? kGivenUp : reason);
  }
  for (const Waiting& waiting : waiting_) tell(waiting.goal, msg::GoalState::GOAL_REJECTED, reason);
  waiting_.clear();
}

bool GoalDesk::answer(const GoalAnswer& answer, Clock::time_point now) {
  asked_.reset();
  if (asked_refused_) return false;
  if (asked_cancelled_) {
    tell(answer.goal, msg::GoalState::GOAL_CANCELLED, kGivenUp);
    return false;
  }
  if (!answer.accepted) {
    tell(answer.goal, msg::GoalState::GOAL_REJECTED, answer.reason);
    return false;
  }
  if (answer.goal.goal().size() > GoalAccount::kLongestName ||
      answer.goal.client().size() > GoalAccount::kLongestName) {
    tell(answer.goal, msg::GoalState::GOAL_REJECTED,
         "the names of a goal and of its client must have at most " + std::to_string(GoalAccount::kLongestName) +
             " bytes");
    return false;
  }
  if (active_) end_active(msg::GoalState::GOAL_REPLACED, "goal " + answer.goal.goal() + " came later", now);
  forget_ = false;
  begin(Active{answer.goal, answer.q_goal, now, now, msg::GoalState::GOAL_ACCEPTED, {}});
  tell_active(msg::GoalState::GOAL_ACCEPTED, {}, now);
  return true;
}

bool GoalDesk::follow(const msg::GoalStatus& status, Clock::time_point now) {
  if (is_over(status.state())) {
    if (!active_ || active_->goal.goal() != status.goal()) return false;
    active_.reset();
    forget_ = status.state() != msg::GoalState::GOAL_REACHED;  // the arm keeps the place that it was sent to
    return false;
  }
  if (status.q_goal().empty() || knows(status.goal())) return false;
  const auto q_goal = Eigen::Map<const Eigen::VectorXd>(status.q_goal().data(), std::ssize(status.q_goal()));
  msg::Goal goal;
  goal.arm(arm_);
  goal.goal(status.goal());
  const auto elapsed = std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(status.elapsed()));
  forget_ = false;
  begin(Active{goal, q_goal, now - elapsed, now, status.state(), {}, true});
  return true;
}

bool GoalDesk::knows(const std::string& goal) const {
  return std::find(begun_.begin(), begun_.end(), goal) != begun_.end() || (asked_ && asked_->goal() == goal) ||
         std::any_of(waiting_.begin(), waiting_.end(), [&](const Waiting& w) { return w.goal.goal() == goal; });
}

void GoalDesk::begin(Active active) {
  begun_.push_back(active.goal.goal());
  if (begun_.size() > kRemembered) begun_.pop_front();
  active_ = std::move(active);
}

GoalAccount GoalDesk::account(Clock::time_point now) const {
  GoalAccount account;
  if (active_) {
    const msg::Goal& goal = active_->goal;
    account.active = GoalAccount::Active{
        goal.goal(),    goal.client(), goal.sequence_number(), goal.time_limit(), seconds(now - active_->since),
        active_->q_goal};
  }
  account.ends.assign(ends_.begin(), ends_.end());
  std::vector<std::uint64_t> unanswered;
  if (asked_ && !asked_refused_) unanswered.push_back(digest(*asked_));
  for (const Waiting& waiting : waiting_) unanswered.push_back(digest(waiting.goal));
  for (const std::uint64_t id : handled_) {
    if (std::find(unanswered.begin(), unanswered.end(), id) == unanswered.end()) account.handled.push_back(id);
  }
  const std::size_t forgotten = account.handled.size() - std::min(account.handled.size(), GoalAccount::kHandled);
  account.handled.erase(account.handled.begin(), account.handled.begin() + static_cast<std::ptrdiff_t>(forgotten));
  return account;
}

bool GoalDesk::resume(const GoalAccount& account, Clock::duration ago, Clock::time_point now) {
  handled_.insert(handled_.begin(), account.handled.begin(), account.handled.end());
  for (const GoalAccount::End& end : account.ends) {
    msg::Goal goal;
    goal.goal(end.goal);
    tell(goal, end.state, "told again by a planner that was restarted");
  }
  if (!account.active) return false;
  const GoalAccount::Active& active = *account.active;
  msg::Goal goal;
  goal.arm(arm_);
  goal.goal(active.goal);
  goal.client(active.client);
  goal.sequence_number(active.sequence_number);
  goal.time_limit(active.time_limit);
  const auto elapsed = std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(active.elapsed));
  const bool followed = active.client.empty();  // then it may still come from its client, too
  begin(Active{goal, active.q_goal, now - elapsed - ago, now, msg::GoalState::GOAL_ACTIVE, {}, followed});
  tell_active(msg::GoalState::GOAL_ACTIVE, "resumed by a planner that was restarted", now);
  return true;
}

void GoalDesk::owe_ends(const std::vector<GoalAccount::End>& ends) {
  const std::size_t left = std::min(ends.size(), GoalAccount::kEnds);
  ends_.assign(ends.end() - static_cast<std::ptrdiff_t>(left), ends.end());
}

void GoalDesk::progress(const Progress& progress, Clock::time_point now) {
  if (!active_) return;
  Active& active = *active_;
  const bool asks = progress.claim != active.last.claim;
  active.last = progress;
  note_hold(progress.held_back, now);
  if (progress.state == msg::GoalState::GOAL_REACHED) {
    end_active(msg::GoalState::GOAL_REACHED, {}, now);
    forget_ = false;  // the arm keeps the place that it was sent to
    return;
  }
  if (active.goal.time_limit() > 0.0 && seconds(now - active.since) > active.goal.time_limit()) {
    char text[64];
    std::snprintf(text, sizeof text, "not reached within %.6g s", active.goal.time_limit());
    end_active(msg::GoalState::GOAL_TIMED_OUT, progress.reason.empty() ? text : text + (": " + progress.reason), now);
    return;
  }
  if (progress.state != active.state || asks || now - active.told >= kRepeat)
    tell_active(progress.state, progress.reason, now);
}

void GoalDesk::note_hold(bool held_back, Clock::time_point now) {
  Active& active = *active_;
  if (held_back) {
    if (!active.held_since) active.held_since = now;
    active.free_since.reset();
  } else if (active.held_since) {
    if (!active.free_since) active.free_since = now;
    if (now - *active.free_since >= kFree) active.held_since.reset();
  }
}

void GoalDesk::tell(const msg::Goal& goal, msg::GoalState state, const std::string& reason) {
  msg::GoalStatus& status = statuses_.emplace_back();
  status.arm(arm_);
  status.goal(goal.goal());
  status.node(node_);
  status.sequence_number(++sequence_);
  status.state(state);
  status.reason(reason);
  if (!is_over(state) || goal.goal().size() > GoalAccount::kLongestName) return;
  ends_.push_back({goal.goal(), state});
  if (ends_.size() > GoalAccount::kEnds) ends_.pop_front();
}

void GoalDesk::tell_active(msg::GoalState state, const std::string& reason, Clock::time_point now) {
  Active& active = *active_;
  active.state = state;
  active.told = now;
  tell(active.goal, state, reason);
  msg::GoalStatus& status = statuses_.back();
  status.has_binding(active.last.has_binding);
  status.binding_own(active.last.binding_own);
  status.binding_other(active.last.binding_other);
  status.binding_distance(active.last.binding_distance);
  status.trying(active.last.trying);
  status.held_for(active.held_since ? seconds(now - *active.held_since) : 0.0);
  status.claim(active.last.claim);
  status.distance_to_goal(active.last.distance);
  status.elapsed(seconds(now - active.since));
  status.q_goal(messages::to_message(active.q_goal));
}

void GoalDesk::end_active(msg::GoalState state, const std::string& reason, Clock::time_point now) {
  tell_active(state, reason, now);
  active_.reset();
  forget_ = true;
}

}  // namespace hecaton::services
