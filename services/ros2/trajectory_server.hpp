#pragma once
/// The action FollowJointTrajectory of one arm, as rclcpp_action serves it: three services and two topics.

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <hecaton/client.hpp>

#include "services/client/connection.hpp"
#include "services/ros2/action_checkpoint.hpp"
#include "services/ros2/action_goals.hpp"
#include "services/ros2/cancellations.hpp"
#include "services/ros2/cell_publisher.hpp"
#include "services/ros2/node_graph.hpp"
#include "services/ros2/publisher.hpp"
#include "services/ros2/trajectory.hpp"
#include "services/ros2/unreadable_log.hpp"
#include "services/ros2_messages/cell_view.hpp"

namespace hecaton::ros2 {

/// What the service knows of an arm besides its newest messages.
struct ArmReadiness {
  bool planner_heard = false;                  ///< a planner of the arm runs
  std::optional<std::string> latched_by = {};  ///< see latched_by(); empty: it may move
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
  void update(const ArmSnapshot& arm, const ArmReadiness& readiness, Clock::time_point now);

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
  void take_goals(const ArmSnapshot& arm, const ArmReadiness& readiness, Clock::time_point now);
  /// Carries out what has arrived but for requests that name an unknown goal, which it returns.
  [[nodiscard]] std::vector<CancelRequest> take_cancellations(Clock::time_point now);
  void carry_out(const CancelRequest& request, Clock::time_point now);
  void take_result_requests(Clock::time_point now);
  void accept(const SendGoalRequest& request, const ArmSnapshot& arm, const ArmReadiness& readiness,
              Clock::time_point now);
  /// Earlier goals that the planner may still go on with when a later one comes: the active one, and before it accepts
  /// that, those which it replaces.
  [[nodiscard]] std::vector<Goal> replaceable() const;
  void follow(const ArmSnapshot& arm, bool planner_heard, Clock::time_point now);
  void await_cancellation(bool planner_heard, Clock::time_point now);
  /// Cancels the active goal, and those that it replaces, at the planner.
  void cancel_active(Clock::time_point now);
  void cancel(const Goal& goal, Clock::time_point now);
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
