#pragma once
/// The action FollowJointTrajectory of one arm, as rclcpp_action serves it: three services and two topics.

#include <array>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <hecaton/client.hpp>

#include "services/client/connection.hpp"
#include "services/ros2/action_checkpoint.hpp"
#include "services/ros2/cell_publisher.hpp"
#include "services/ros2/node_graph.hpp"
#include "services/ros2/publisher.hpp"
#include "services/ros2/trajectory.hpp"
#include "services/ros2/unreadable_log.hpp"
#include "services/ros2_messages/cell_view.hpp"

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

/// Cancellations for the planner of an arm, each repeated until it is sent: an arm must not go on along a trajectory
/// that has ended for its client.
class Cancellations {
 public:
  using Clock = bus::Clock;

  static constexpr std::chrono::seconds kPeriod{1};  ///< between attempts

  explicit Cancellations(std::string arm) : arm_(std::move(arm)) {}

  /// Sends a cancellation now. `send` throws Error when it cannot; the reason is logged.
  void add(const std::string& goal, std::function<void()> send, Clock::time_point now);
  /// Sends again what could not be sent. Call it in each period.
  void retry(Clock::time_point now);
  /// Goals whose cancellation could not be sent yet.
  [[nodiscard]] std::vector<std::string> unsent() const;

 private:
  struct Entry {
    std::string goal;
    std::function<void()> send;
  };
  [[nodiscard]] bool sent(const Entry& entry) const;

  std::string arm_;
  std::vector<Entry> unsent_;
  Clock::time_point tried_{};
};

/// For one thread.
class TrajectoryServer {
 public:
  using Clock = bus::Clock;

  /// Serves NAMESPACE/ARM/follow_joint_trajectory. `arm` and `mailbox` must outlive it. `connection` sends the goals to
  /// the planner. The file `checkpoint` has the goals and requests of an earlier process, which it continues; empty:
  /// none.
  TrajectoryServer(bus::Participant& participant, const std::string& ns, const planner::Arm& arm,
                   const std::shared_ptr<client::Connection>& connection, bus::Mailbox& mailbox,
                   const std::string& checkpoint);

  /// Answers requests and follows the trajectory. Call it in each period.
  void update(const ArmSnapshot& arm, Clock::time_point now);

  /// The path of the present trajectory; empty: none.
  [[nodiscard]] std::optional<OrderedPath> path() const;
  [[nodiscard]] NodeEndpoints endpoints() const;

 private:
  struct Active {
    ActionGoals::Id id;
    TrajectoryFollower follower;
    TrajectoryGoal order;  ///< as the client wrote it
    Goal goal;             ///< for the planner
    /// Which the planner goes on with if it rejects this one: then they are cancelled.
    std::vector<Goal> replaced = {};
    Clock::time_point begun{};
    Clock::time_point updated{};
    std::optional<CancellationWait> cancellation = {};  ///< empty: no client has cancelled it
    bool restored = false;                              ///< an earlier process has accepted it
  };
  struct CancelRequest {
    bus::ros2::RequestId id;
    GoalInfo goal;
  };

  void restore();
  /// False: the trajectory cannot go on.
  [[nodiscard]] bool restore(const SavedTrajectory& active, Clock::time_point now);
  void save();
  void take_goals(const ArmSnapshot& arm, Clock::time_point now);
  /// Carries out what has arrived but for requests that name an unknown goal, which it returns.
  [[nodiscard]] std::vector<CancelRequest> take_cancellations(Clock::time_point now);
  void carry_out(const CancelRequest& request, Clock::time_point now);
  void take_result_requests(Clock::time_point now);
  void accept(const SendGoalRequest& request, const ArmSnapshot& arm, Clock::time_point now);
  /// Earlier goals that the planner may still go on with when a later one comes: the active one, and before it accepts
  /// that, those which it replaces.
  [[nodiscard]] std::vector<Goal> replaceable() const;
  void follow(const ArmSnapshot& arm, Clock::time_point now);
  void await_cancellation(Clock::time_point now);
  /// Cancels the active goal, and those that it replaces, at the planner.
  void cancel_active(Clock::time_point now);
  void cancel(const Goal& goal, Clock::time_point now);
  [[nodiscard]] bool is_lost_since_restart(const std::optional<Progress>& progress, Clock::time_point now) const;
  /// Ends the active goal, saves and publishes that.
  void finish(std::int8_t status, TrajectoryCode code, const std::string& text, Clock::time_point now);
  void end_active(std::int8_t status, TrajectoryCode code, const std::string& text, Clock::time_point now);
  /// A goal for the planner, not sent yet. Throws Error.
  [[nodiscard]] Goal prepared(const planner::TimedTrajectory& from) const;
  void send_goal(Clock::time_point now);
  void send_results(Clock::time_point now);
  void publish_feedback(const ArmSnapshot& arm);

  const planner::Arm& arm_;
  std::shared_ptr<client::Connection> connection_;
  ActionCheckpoint checkpoint_;
  bus::ros2::Server send_goal_;
  bus::ros2::Server cancel_goal_;
  bus::ros2::Server get_result_;
  Publisher<FeedbackMessage> feedback_;
  Publisher<GoalStatusArray> status_;
  ActionGoals goals_;
  std::optional<Active> active_;
  ResultRequests waiting_;
  Cancellations cancellations_;
  Clock::time_point fed_back_{};
  Clock::time_point restored_{};  ///< when this process has continued those of an earlier one
  UnreadableLog unreadable_;      ///< requests of its services
};

}  // namespace hecaton::ros2
