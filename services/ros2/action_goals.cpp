#include "services/ros2/action_goals.hpp"

#include <algorithm>
#include <utility>

#include "services/ros2_messages/time.hpp"

namespace hecaton::ros2 {
namespace {

// Return codes of action_msgs/srv/CancelGoal.
constexpr std::int8_t kCancelAccepted = 0;
constexpr std::int8_t kCancelUnknown = 2;
constexpr std::int8_t kCancelTerminated = 3;

std::int64_t nanoseconds_of(const Time& stamp) {
  return std::int64_t{stamp.sec} * 1'000'000'000 + stamp.nanosec;
}

}  // namespace

bool ActionGoals::add(const Id& id, const Time& stamp) {
  if (!goals_.try_emplace(id, Goal{stamp, kExecuting, {}, {}}).second) return false;
  order_.push_back(id);
  return true;
}

void ActionGoals::set_status(const Id& id, std::int8_t status) {
  goals_.at(id).status = status;
}

void ActionGoals::end(const Id& id, std::int8_t status, TrajectoryResult result, Clock::time_point now) {
  Goal& goal = goals_.at(id);
  goal.status = status;
  goal.result = std::move(result);
  goal.ended = now;
}

void ActionGoals::forget_old(Clock::time_point now) {
  std::size_t ended = 0;
  for (const auto& [id, goal] : goals_) ended += goal.result ? 1 : 0;
  std::erase_if(order_, [&](const Id& id) {
    const Goal& goal = goals_.at(id);
    if (!goal.result || (now - goal.ended < kKept && ended <= kMostKept)) return false;
    --ended;
    goals_.erase(id);
    return true;
  });
}

std::int8_t ActionGoals::status(const Id& id) const {
  const auto found = goals_.find(id);
  return found == goals_.end() ? kUnknown : found->second.status;
}

std::optional<GetResultResponse> ActionGoals::result(const Id& id) const {
  const auto found = goals_.find(id);
  if (found == goals_.end()) return GetResultResponse{kUnknown, {}};
  if (!found->second.result) return std::nullopt;
  return GetResultResponse{found->second.status, *found->second.result};
}

GoalStatusArray ActionGoals::statuses() const {
  GoalStatusArray array;
  for (const Id& id : order_) array.status_list.push_back({info(id), goals_.at(id).status});
  return array;
}

GoalInfo ActionGoals::info(const Id& id) const {
  return {{id}, goals_.at(id).stamp};
}

CancelGoalResponse ActionGoals::cancellable(const GoalInfo& request) const {
  CancelGoalResponse response;
  response.return_code = kCancelAccepted;
  const Id& id = request.goal_id.uuid;
  const bool certain = id != Id{} && is_stamp_zero(request.stamp);
  const bool all = id == Id{} && is_stamp_zero(request.stamp);
  for (const Id& each : order_) {
    const Goal& goal = goals_.at(each);
    if (goal.result) continue;
    const bool until = !certain && nanoseconds_of(goal.stamp) <= nanoseconds_of(request.stamp);
    if (all || until || each == id) response.goals_canceling.push_back(info(each));
  }
  if (certain && response.goals_canceling.empty()) {
    response.return_code = knows(id) ? kCancelTerminated : kCancelUnknown;
  }
  return response;
}

std::vector<SavedGoal> ActionGoals::saved() const {
  std::vector<SavedGoal> all;
  for (const Id& id : order_) {
    const Goal& goal = goals_.at(id);
    all.push_back({info(id), goal.status, goal.result.has_value(), goal.result.value_or(TrajectoryResult{}),
                   stamp_of(goal.ended)});
  }
  return all;
}

void ActionGoals::restore(const std::vector<SavedGoal>& goals) {
  for (const SavedGoal& goal : goals) {
    const Id& id = goal.info.goal_id.uuid;
    if (!add(id, goal.info.stamp)) continue;
    set_status(id, goal.status);
    if (goal.ended) end(id, goal.status, goal.result, time_of(goal.ended_ns));
  }
}

void ResultRequests::add(const ActionGoals::Id& goal, const bus::ros2::RequestId& request) {
  entries_.push_back({goal, request});
  if (entries_.size() <= kMost) return;
  auto dropped = entries_.begin();
  for (auto entry = entries_.begin(); entry != entries_.end(); ++entry) {
    const bool repeated = std::any_of(entry + 1, entries_.end(), [&](const Entry& later) {
      return later.goal == entry->goal && later.request.client == entry->request.client;
    });
    if (!repeated) continue;
    dropped = entry;
    break;
  }
  entries_.erase(dropped);
}

std::size_t ResultRequests::answer(const std::function<bool(const Entry&)>& answer) {
  return std::erase_if(entries_, answer);
}

}  // namespace hecaton::ros2
