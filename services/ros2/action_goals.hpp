#pragma once
/// What an action server remembers: its goals, and the requests for their results. No network.

#include <array>
#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <vector>

#include "services/bus/mailbox.hpp"
#include "services/bus/ros2_endpoint.hpp"
#include "services/ros2/action_checkpoint.hpp"
#include "services/ros2_messages/ros2_types.hpp"

namespace hecaton::ros2 {

/// Goals of an action server with their status and result, on values. Ended goals are kept for late clients.
class ActionGoals {
 public:
  using Clock = bus::Clock;
  using Id = std::array<std::uint8_t, 16>;

  static constexpr std::chrono::minutes kKept{15};  ///< result of an ended goal
  static constexpr std::size_t kMostKept = 256;

  // Status of action_msgs/msg/GoalStatus.
  static constexpr std::int8_t kUnknown = 0;
  static constexpr std::int8_t kExecuting = 2;
  static constexpr std::int8_t kCanceling = 3;
  static constexpr std::int8_t kSucceeded = 4;
  static constexpr std::int8_t kCanceled = 5;
  static constexpr std::int8_t kAborted = 6;

  /// False: the id is known.
  bool add(const Id& id, const Time& stamp);
  void set_status(const Id& id, std::int8_t status);
  void end(const Id& id, std::int8_t status, TrajectoryResult result, Clock::time_point now);
  void forget_old(Clock::time_point now);

  [[nodiscard]] bool knows(const Id& id) const { return goals_.contains(id); }
  [[nodiscard]] std::int8_t status(const Id& id) const;
  /// Empty while the goal has not ended; kUnknown for an unknown goal.
  [[nodiscard]] std::optional<GetResultResponse> result(const Id& id) const;
  [[nodiscard]] GoalStatusArray statuses() const;
  [[nodiscard]] GoalInfo info(const Id& id) const;
  /// The answer to a request to cancel goals, as rcl_action gives it: with the goals that shall be cancelled. A zero id
  /// and a zero stamp name all goals; a stamp names all goals accepted until then, and the goal of the id.
  [[nodiscard]] CancelGoalResponse cancellable(const GoalInfo& request) const;
  /// All goals, in the order of acceptance.
  [[nodiscard]] std::vector<SavedGoal> saved() const;
  void restore(const std::vector<SavedGoal>& goals);

 private:
  struct Goal {
    Time stamp;
    std::int8_t status = kExecuting;
    std::optional<TrajectoryResult> result;
    Clock::time_point ended{};
  };
  std::map<Id, Goal> goals_;
  std::deque<Id> order_;  ///< of acceptance
};

/// Requests for results of goals that have not ended, oldest first.
class ResultRequests {
 public:
  struct Entry {
    ActionGoals::Id goal;
    bus::ros2::RequestId request;
  };
  static constexpr std::size_t kMost = 64;

  /// Of more than kMost, the oldest one is dropped that its client has repeated for the same goal; without such, the
  /// oldest.
  void add(const ActionGoals::Id& goal, const bus::ros2::RequestId& request);
  /// Calls `answer` with each entry, and removes those for which it returns true. Returns their number.
  std::size_t answer(const std::function<bool(const Entry&)>& answer);
  [[nodiscard]] const std::vector<Entry>& all() const { return entries_; }

 private:
  std::vector<Entry> entries_;
};

}  // namespace hecaton::ros2
