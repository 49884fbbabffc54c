#pragma once
/// The client of an action of ROS 2, for one newest goal at a time: a new goal replaces the one before.
///
///     send() ─► accepted ─► get_result ─► result          or ─► refused
///
/// A server ends the goal that a newer one replaces. Its end is reported, too, because it may have failed before.

#include <algorithm>
#include <array>
#include <cstring>
#include <deque>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "services/arm_driver/devices/arm_device.hpp"
#include "services/bus/ros2_endpoint.hpp"
#include "services/ros2_messages/cdr.hpp"
#include "services/ros2_messages/ros2_types.hpp"

namespace hecaton::device::ros2_control {

/// Status of action_msgs/msg/GoalStatus.
enum class GoalStatus : std::int8_t { kUnknown = 0, kSucceeded = 4, kCanceled = 5, kAborted = 6 };

/// For one thread.
template <class Goal, class Result>
class ActionClient {
 public:
  struct Types {
    ros2::TypeInfo send_goal, get_result;
  };
  struct End {
    bool newest = false;    ///< no later goal had been sent
    bool accepted = false;  ///< else the server has refused the goal, and the rest is empty
    GoalStatus status = GoalStatus::kUnknown;
    Result result;
  };

  /// `action`: its full name. `mailbox` must outlive the client. Throws std::runtime_error with a sentence.
  ActionClient(bus::Participant& participant, const std::string& action, const Types& types, bus::Mailbox& mailbox)
      : send_goal_(participant, service(action, "send_goal", types.send_goal), mailbox),
        get_result_(participant, service(action, "get_result", types.get_result), mailbox),
        cancel_goal_(participant, service(action, "cancel_goal", ros2::type::kCancelGoal), mailbox),
        random_(std::random_device{}()) {}

  /// A server is there. A goal that is sent earlier has no answer.
  [[nodiscard]] bool available() const {
    return send_goal_.available() && get_result_.available() && cancel_goal_.available();
  }

  /// False: the middleware refuses the goal.
  bool send(const Goal& goal, Clock::time_point now) {
    ros2::ActionGoalRequest<Goal> request{{new_id()}, goal};
    ros2::encode(request, bytes_);
    const auto number = send_goal_.send(bytes_);
    if (!number) return false;
    if (open_.size() >= kMostOpen) open_.pop_front();
    open_.push_back({request.goal_id, *number, std::nullopt, now});
    newest_ = request.goal_id;
    return true;
  }

  /// Cancels the newest goal if it has not ended. Ends of goals until now are not reported any more.
  void cancel() {
    if (newest_is_open()) {
      ros2::encode(ros2::CancelGoalRequest{{*newest_, {}}}, bytes_);
      (void)cancel_goal_.send(bytes_);
    }
    open_.clear();
    newest_.reset();
  }

  /// Takes answers and asks for results. The ends since the last call, oldest first.
  [[nodiscard]] std::vector<End> update() {
    std::vector<End> ends;
    for (const bus::ros2::Reply& reply : send_goal_.take()) take_answer(reply, ends);
    for (const bus::ros2::Reply& reply : get_result_.take()) take_result(reply, ends);
    (void)cancel_goal_.take();
    return ends;
  }

  /// When the newest goal was sent whose answer is missing.
  [[nodiscard]] std::optional<Clock::time_point> unanswered_since() const {
    if (!newest_is_open() || open_.back().result_request) return std::nullopt;
    return open_.back().sent_at;
  }
  /// A goal has been sent since the last cancel(), and the server has accepted the newest one.
  [[nodiscard]] bool accepted() const { return newest_ && !unanswered_since(); }

 private:
  struct Open {
    ros2::UUID id;
    std::int64_t request = 0;
    std::optional<std::int64_t> result_request;  ///< the goal is accepted
    Clock::time_point sent_at;
  };
  /// Replaced goals of a server that does not report their ends.
  static constexpr std::size_t kMostOpen = 64;

  static bus::ros2::Service service(const std::string& action, const char* name, const ros2::TypeInfo& type) {
    return {action + "/_action/" + name, std::string(type.name), std::string(type.hash)};
  }
  [[nodiscard]] bool newest_is_open() const {
    return newest_ && !open_.empty() && open_.back().id.uuid == newest_->uuid;
  }
  /// A random UUID, RFC 4122 section 4.4.
  ros2::UUID new_id() {
    ros2::UUID id;
    for (std::uint8_t& byte : id.uuid) byte = static_cast<std::uint8_t>(random_());
    id.uuid[6] = static_cast<std::uint8_t>((id.uuid[6] & 0x0FU) | 0x40U);
    id.uuid[8] = static_cast<std::uint8_t>((id.uuid[8] & 0x3FU) | 0x80U);
    return id;
  }
  void take_answer(const bus::ros2::Reply& reply, std::vector<End>& ends) {
    const auto found =
        std::find_if(open_.begin(), open_.end(), [&](const Open& goal) { return goal.request == reply.number; });
    const auto answer = ros2::decoded<ros2::SendGoalResponse>(reply.bytes);
    if (found == open_.end() || !answer || found->result_request) return;
    if (answer->accepted) {
      ros2::encode(ros2::GetResultRequest{found->id}, bytes_);
      found->result_request = get_result_.send(bytes_);
      if (found->result_request) return;
    }
    ends.push_back({newest_ && found->id.uuid == newest_->uuid, false, GoalStatus::kUnknown, {}});
    open_.erase(found);
  }
  void take_result(const bus::ros2::Reply& reply, std::vector<End>& ends) {
    const auto found =
        std::find_if(open_.begin(), open_.end(), [&](const Open& goal) { return goal.result_request == reply.number; });
    auto response = ros2::decoded<ros2::ActionResultResponse<Result>>(reply.bytes);
    if (found == open_.end() || !response) return;
    ends.push_back({newest_ && found->id.uuid == newest_->uuid, true, static_cast<GoalStatus>(response->status),
                    std::move(response->result)});
    open_.erase(found);
  }

  bus::ros2::Client send_goal_;
  bus::ros2::Client get_result_;
  bus::ros2::Client cancel_goal_;
  std::mt19937 random_;
  std::deque<Open> open_;
  std::optional<ros2::UUID> newest_;
  ros2::Bytes bytes_;
};

using TrajectoryAction = ActionClient<ros2::TrajectoryGoal, ros2::TrajectoryResult>;
using GripperAction = ActionClient<ros2::GripperGoal, ros2::GripperResult>;

}  // namespace hecaton::device::ros2_control
