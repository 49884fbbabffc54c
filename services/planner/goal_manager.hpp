#pragma once
/// The goals of one arm from arrival to their final status. No network, threads or clock.

#include <chrono>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <idl/goal.h>

#include "planner/arm_planner/arm_planner.hpp"
#include "services/planner/goal_resolver.hpp"

namespace hecaton::services {

/// Time limit for the first states that a goal needs; equals the supervisor's limit for the start of a node.
constexpr std::chrono::seconds kLongestWait{10};

/// The progress of the active goal in one control period.
struct Progress {
  msg::GoalState state = msg::GoalState::GOAL_ACTIVE;  ///< active, blocked or reached
  msg::Cause cause;                                    ///< why the arm does not get nearer to the goal
  bool has_binding = false;
  std::string binding_own;
  std::string binding_other;
  double binding_distance = 0.0;                 ///< [m]
  std::string recovery_action;                   ///< for people
  bool obstructed = false;                       ///< the arm does not move freely to the goal
  std::uint32_t priority = 0;                    ///< in the right of way
  double distance = 0.0;                         ///< ‖q_goal − q‖ [rad | m]
  std::optional<planner::ToolError> tool_error;  ///< measured, of a pose goal

  /// Of a goal with a trajectory that the arm has begun.
  struct Trajectory {
    double time = 0.0;            ///< that the arm has come to [s]
    double rate = 0.0;            ///< of that time, 0 to 1
    planner::JointVector q_next;  ///< where the arm goes next [rad | m]
    msg::Cause left = {};         ///< why the goal ends: the arm has left the path
  };
  std::optional<Trajectory> trajectory;
};

/// The goals of an arm, for a planner that continues them: a value without clocks.
struct GoalSnapshot {
  static constexpr std::size_t kLongestName = 255;  ///< bytes of a goal's or client's name; longer names are rejected
  static constexpr std::size_t kHandled = 1024;     ///< digests; more than the bus delivers again
  static constexpr std::size_t kResults = 4;        ///< that are published again

  struct Active {
    std::string goal;
    std::string client;
    std::uint64_t sequence_number = 0;           ///< of the client
    double time_limit = 0.0;                     ///< [s]; 0: none
    double elapsed = 0.0;                        ///< since it was accepted [s]
    planner::JointVector q_goal;                 ///< [rad | m]
    std::optional<planner::ToolGoal> tool = {};  ///< of a pose goal
    /// Of a goal with a trajectory: the time that the arm had come to [s]; else negative. The trajectory itself comes
    /// from the goal's client again.
    double trajectory_time = -1.0;
    bool operator==(const Active&) const = default;
  };
  struct Result {
    std::string goal;
    msg::GoalState state = msg::GoalState::GOAL_REACHED;  ///< final
    bool operator==(const Result&) const = default;
  };

  std::optional<Active> active;
  std::vector<Result> results;         ///< of the last goals that have ended, oldest first
  std::vector<std::uint64_t> handled;  ///< digests of answered goals and cancellations, oldest first
  bool operator==(const GoalSnapshot&) const = default;
};

/// Goals that wait, the goal that is being resolved, the active goal, and the statuses for their clients. For one
/// thread.
class GoalManager {
 public:
  using Clock = std::chrono::steady_clock;

  GoalManager(std::string arm, std::string node);

  /// Takes a goal or a cancellation. Those of other arms, and repetitions, are ignored.
  void receive(const msg::Goal& goal, Clock::time_point now);

  /// The next goal to resolve, for which answer() must be called; empty while another goal is being resolved.
  [[nodiscard]] std::optional<msg::Goal> next_to_resolve();
  /// A standby planner rejects no goals and answers no unknown cancellations: their waiting time begins at `now`.
  void restart_waits(Clock::time_point now);
  /// Reports goals as cancelled of which only the cancellation has arrived: the bus keeps only the last message of a
  /// goal for a planner that starts later. Goals whose final status is known keep it. For the planner in charge, in
  /// each period; one answer in 20 ms, so that many do not displace the statuses that late clients need.
  void answer_unknown_cancellations(Clock::time_point now);
  /// Rejects goals that have waited longer than `limit`.
  void reject_expired(Clock::time_point now, Clock::duration limit, const msg::Cause& cause);
  /// Goals cannot be resolved: rejects all that wait and the one that is being resolved, whose answer is then ignored.
  void reject_all(const msg::Cause& cause);
  /// The arm's device has stopped: ends the active goal as cancelled, and rejects all others.
  void end_all(const msg::Cause& cause, Clock::time_point now);
  /// If `answer` has a target, the goal becomes active and replaces the active goal; otherwise it is rejected. True
  /// when the goal is now active.
  bool answer(const GoalAnswer& answer, Clock::time_point now);

  /// Takes a status of the planner in charge: an unknown active goal becomes active here, and a final status ends the
  /// goal here, both without a status of this planner. True when the goal is now active.
  bool follow(const msg::GoalStatus& status, Clock::time_point now);

  /// The goals without those that are not answered yet: their clients send them to any planner of the arm that appears.
  [[nodiscard]] GoalSnapshot snapshot(Clock::time_point now) const;
  /// Continues from a snapshot that is `ago` old, before any other call: handled goals are ignored, results and the
  /// active goal get a status again. True when there is an active goal.
  bool resume(const GoalSnapshot& snapshot, Clock::duration ago, Clock::time_point now);

  /// Replaces the results of the snapshot: the planner in charge has published all others.
  void keep_results(const std::vector<GoalSnapshot::Result>& results);

  [[nodiscard]] bool has_active() const { return active_.has_value(); }
  [[nodiscard]] const planner::JointVector& q_goal() const { return active_->q_goal; }  ///< of the active goal
  /// The active goal has a trajectory, which its client has not sent to this planner yet: the arm stands.
  [[nodiscard]] bool awaits_trajectory() const {
    return active_ && active_->trajectory_time >= 0.0 && !active_->trajectory;
  }
  /// Of the active goal; null: it is no pose goal.
  [[nodiscard]] const planner::ToolGoal* tool() const { return active_->tool ? &*active_->tool : nullptr; }

  /// Takes the progress of the active goal. Adds a status when the state changes and every 100 ms; ends the goal when
  /// it is reached or its time limit has passed.
  void progress(const Progress& progress, Clock::time_point now);

  /// The change of the active goal since the last call: a new goal, or none after the goal ended unreached. A reached
  /// goal stays the target of the planner, so that the arm keeps its place.
  [[nodiscard]] std::optional<planner::GoalChange> take_change() { return std::exchange(change_, std::nullopt); }
  /// Statuses to publish, oldest first, without term and stamp.
  [[nodiscard]] std::vector<msg::GoalStatus> take_statuses() { return std::exchange(statuses_, {}); }

 private:
  struct Waiting {
    msg::Goal goal;
    Clock::time_point since;
  };
  struct Active {
    msg::Goal goal;
    planner::JointVector q_goal;
    Clock::time_point since;
    Clock::time_point reported;
    msg::GoalState state = msg::GoalState::GOAL_ACCEPTED;
    Progress last;
    bool followed = false;  ///< known from the planner in charge only, not from its client
    std::optional<planner::ToolGoal> tool = {};
    std::string note = {};
    std::shared_ptr<const planner::TimedTrajectory> trajectory = {};
    double trajectory_time = -1.0;  ///< of a goal with a trajectory, as last known [s]; else negative
    std::optional<Clock::time_point> awaiting_since = {};
    std::optional<Clock::time_point> held_since = {};
    std::optional<Clock::time_point> free_since = {};
  };

  /// Of a goal that this planner does not know.
  struct UnknownCancellation {
    std::string goal;
    std::uint64_t digest;
    Clock::time_point since;
  };

  [[nodiscard]] bool handled_before(const msg::Goal& goal);
  [[nodiscard]] bool knows(const std::string& goal) const;
  void activate(Active active);
  /// Takes the trajectory of the active goal, of which this planner knows only that it has one.
  void take_trajectory(const msg::Goal& goal);
  /// False: no such goal is under way.
  [[nodiscard]] bool cancel(const std::string& goal, Clock::time_point now);
  [[nodiscard]] bool has_ended(const std::string& goal) const;
  void remember_end(const std::string& goal);
  /// Updates the time since which the arm is obstructed. A short free motion does not end it.
  void update_hold(bool obstructed, Clock::time_point now);
  void add_status(const msg::Goal& goal, msg::GoalState state, const msg::Cause& cause);
  void add_active_status(msg::GoalState state, const msg::Cause& cause, Clock::time_point now);
  void end_active(msg::GoalState state, const msg::Cause& cause, Clock::time_point now);

  std::string arm_;
  std::string node_;
  std::deque<std::uint64_t> handled_;         ///< digests, oldest first
  std::deque<std::string> activated_;         ///< goals that were active, oldest first
  std::deque<GoalSnapshot::Result> results_;  ///< the last ones, oldest first
  std::deque<std::string> ended_;             ///< goals with a final status of any planner, oldest first
  std::deque<Waiting> waiting_;
  std::deque<UnknownCancellation> unknown_;  ///< oldest first
  Clock::time_point answered_unknown_{};
  std::optional<msg::Goal> resolving_;
  bool resolving_cancelled_ = false;
  bool resolving_rejected_ = false;
  std::optional<Active> active_;
  std::optional<planner::GoalChange> change_;
  std::uint64_t sequence_ = 0;
  std::vector<msg::GoalStatus> statuses_;
};

}  // namespace hecaton::services
