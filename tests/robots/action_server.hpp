#pragma once
/// Actions of ROS 2 as rclcpp_action serves them over rmw_fastrtps. Cyclone DDS cannot: it has no access to the
/// identity in the inline QoS of a request, so these services run on Fast DDS. Fast CDR serialises, from idl/ros2.

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <idl/ros2/ros2PubSubTypes.h>

#include "tests/cell/ros2/ros_peer.hpp"

namespace hecaton::test {

/// One goal at a time: a new one replaces the one before.
template <class SendRequest, class SendResponse, class GetRequest, class GetResponse>
class ActionServer {
 public:
  using Id = std::array<std::uint8_t, 16>;
  using Request = typename SendRequest::type;
  using Response = typename GetResponse::type;
  using Result = std::remove_cvref_t<decltype(std::declval<Response>().result())>;

  // action_msgs/msg/GoalStatus
  static constexpr std::int8_t kSucceeded = 4;
  static constexpr std::int8_t kCanceled = 5;
  static constexpr std::int8_t kAborted = 6;

  ActionServer(int domain, const std::string& action)
      : peer_(domain, -1),
        send_goal_(peer_, action + "/_action/send_goal"),
        get_result_(peer_, action + "/_action/get_result"),
        cancel_goal_(peer_, action + "/_action/cancel_goal") {}

  /// `accept`: whether the server takes the goal; what ran before ends with `replaced`. `cancel`: the goal is
  /// cancelled.
  void serve(const std::function<bool(const Request&)>& accept, const Result& replaced,
             const std::function<Result()>& cancel) {
    for (const auto& call : send_goal_.take()) {
      if (deaf) continue;
      const bool accepted = accept(call.request);
      if (accepted) {
        end(kCanceled, replaced);
        running_ = call.request.goal_id().uuid();
        results_[*running_] = std::nullopt;
      }
      typename SendResponse::type response;
      response.accepted(accepted);
      send_goal_.reply(response, call.identity);
    }
    for (const auto& call : cancel_goal_.take()) {
      const auto& wanted = call.request.goal_info().goal_id().uuid();
      action_msgs::srv::CancelGoal_Response response;
      if (running_ && (wanted == *running_ || wanted == Id{})) {
        ++cancels;
        response.goals_canceling().push_back(call.request.goal_info());
        end(kCanceled, cancel());
      } else {
        response.return_code(results_.contains(wanted) ? 3 : 2);
      }
      cancel_goal_.reply(response, call.identity);
    }
    for (const auto& call : get_result_.take()) waiting_.push_back({call.request.goal_id().uuid(), call.identity});
    answer();
  }
  /// The goal that runs ends; without one, nothing happens.
  void end(std::int8_t status, const Result& result) {
    if (!running_) return;
    Response response;
    response.status(status);
    response.result(result);
    results_[*running_] = response;
    running_.reset();
    answer();
  }
  [[nodiscard]] bool runs() const { return running_.has_value(); }

  bool deaf = false;  ///< it takes goals and does not answer
  int cancels = 0;    ///< goals that a client has cancelled

 private:
  void answer() {
    std::erase_if(waiting_, [&](const auto& waiting) {
      const auto found = results_.find(waiting.first);
      if (found != results_.end() && !found->second) return false;
      get_result_.reply(found == results_.end() ? Response() : *found->second, waiting.second);
      return true;
    });
  }

  RosPeer peer_;
  PeerServer<SendRequest, SendResponse> send_goal_;
  PeerServer<GetRequest, GetResponse> get_result_;
  PeerServer<action_msgs::srv::CancelGoal_RequestPubSubType, action_msgs::srv::CancelGoal_ResponsePubSubType>
      cancel_goal_;
  std::optional<Id> running_;
  std::map<Id, std::optional<Response>> results_;  ///< empty: the goal runs
  std::vector<std::pair<Id, rtps::SampleIdentity>> waiting_;
};

using TrajectoryServer = ActionServer<control_msgs::action::FollowJointTrajectory_SendGoal_RequestPubSubType,
                                      control_msgs::action::FollowJointTrajectory_SendGoal_ResponsePubSubType,
                                      control_msgs::action::FollowJointTrajectory_GetResult_RequestPubSubType,
                                      control_msgs::action::FollowJointTrajectory_GetResult_ResponsePubSubType>;
using GripperServer = ActionServer<control_msgs::action::GripperCommand_SendGoal_RequestPubSubType,
                                   control_msgs::action::GripperCommand_SendGoal_ResponsePubSubType,
                                   control_msgs::action::GripperCommand_GetResult_RequestPubSubType,
                                   control_msgs::action::GripperCommand_GetResult_ResponsePubSubType>;

}  // namespace hecaton::test
