#include "services/ros2/goal_reports.hpp"

#include <algorithm>
#include <utility>

namespace hecaton::ros2 {

void GoalReports::add(Report report, Clock::time_point now) {
  sent_.push_back({std::move(report), now, ++goals_});
  if (sent_.size() <= kMost) return;
  refuse("no planner has answered the last " + std::to_string(kMost) + " goals", sent_.front().number);
  sent_.pop_front();
}

void GoalReports::refuse(std::string reason) {
  refuse(std::move(reason), ++goals_);
}

void GoalReports::refuse(std::string reason, std::uint64_t number) {
  ++refused_;
  if (number < newest_) return;
  newest_ = number;
  refusal_ = std::move(reason);
}

void GoalReports::update(Clock::time_point now) {
  std::erase_if(sent_, [&](const Sent& goal) { return count(goal, now); });
}

bool GoalReports::count(const Sent& goal, Clock::time_point now) {
  const std::optional<Progress> progress = goal.report();
  if (progress && progress->state == GoalState::kRejected) {
    refuse("the planner rejects the goal: " + progress->cause.text, goal.number);
  } else if (progress) {
    ++accepted_;
    if (goal.number > newest_) refusal_.reset();
    newest_ = std::max(newest_, goal.number);
  } else if (now - goal.at > kAnswerTime) {
    refuse("no planner has answered the goal for " + std::to_string(kAnswerTime.count()) +
               " s; `hecaton status` shows whether one runs",
           goal.number);
  } else {
    return false;
  }
  return true;
}

}  // namespace hecaton::ros2
