#include "services/arm_driver/devices/ros2_control/gripper.hpp"

#include <cmath>
#include <utility>

namespace hecaton::device::ros2_control {
namespace {

/// In which a controller answers an order.
constexpr std::chrono::seconds kGripperAnswer{2};
/// Fingers that have not moved for this time have arrived, or something stops them.
constexpr std::chrono::milliseconds kStands{300};
/// A finger begins to move within this time.
constexpr std::chrono::seconds kBegins{1};
/// A smaller change of a finger is noise [rad | m].
constexpr double kNoise = 1e-4;
constexpr double kArrived = 1e-3;  // [rad | m]

bool within(const std::vector<double>& a, const std::vector<double>& b, double distance) {
  return a.size() == b.size() &&
         std::equal(a.begin(), a.end(), b.begin(), [&](double x, double y) { return std::abs(x - y) <= distance; });
}

bus::ros2::Topic commands_topic(const std::string& controller) {
  bus::ros2::Topic topic;
  topic.name = controller + "/commands";
  topic.type = ros2::type::kFloat64MultiArray.name;
  topic.hash = ros2::type::kFloat64MultiArray.hash;
  topic.depth = 1;  // an older command is out of date
  return topic;
}

}  // namespace

Gripper::Gripper(const GripperOptions& options, Clock::duration silence_limit, bus::Participant& participant,
                 bus::Mailbox& mailbox)
    : options_(options), silence_limit_(silence_limit), states_(options.joints, silence_limit) {
  if (options_.action) {
    action_.emplace(participant, options_.controller + "/gripper_cmd",
                    GripperAction::Types{ros2::type::kSendGripperCommand, ros2::type::kGripperCommandResult}, mailbox);
  } else {
    commands_.emplace(participant, commands_topic(options_.controller));
  }
}

void Gripper::take(const bus::ros2::Sample& sample) {
  states_.take(sample.bytes, sample.writer, sample.received);
}

std::vector<double> Gripper::positions(Clock::time_point now) const {
  const JointState state = states_.measured();
  if (state.q.size() == 0 || now - states_.received() >= silence_limit_) return {};
  return {state.q.begin(), state.q.end()};
}

DeviceResult Gripper::move(const std::vector<double>& positions, double effort, Clock::time_point now) {
  const std::string here = options_.controller + " in domain " + std::to_string(options_.domain) + " of ROS 2";
  target_ = positions;
  began_ = moved_ = now;
  last_ = this->positions(now);
  end_.reset();
  if (action_) {
    if (!action_->available()) {
      return DeviceFailure{"nothing serves the action " + options_.controller + "/gripper_cmd: activate " + here};
    }
    ros2::GripperGoal goal;
    goal.command = {positions.front(), effort >= 0.0 ? effort : options_.effort};
    if (!action_->send(goal, now)) return DeviceFailure{"the middleware refuses the order to its gripper"};
  } else {
    if (commands_->matched() == 0) return DeviceFailure{"nothing reads commands of its gripper: activate " + here};
    if (last_.empty()) {
      std::string joints;
      for (const std::string& joint : options_.joints) joints += (joints.empty() ? "" : ", ") + joint;
      return DeviceFailure{
          "no joint state of its fingers arrives, so the end of a motion would not be known: publish " + joints +
          ", or set gripper_joints in the cell file"};
    }
    ros2::Float64MultiArray message;
    message.data = positions;
    if (!commands_->write(ros2::encoded(message)))
      return DeviceFailure{"the middleware refuses the order to its gripper"};
  }
  moves_ = true;
  return {};
}

void Gripper::update(Clock::time_point now) {
  if (action_) {
    for (const GripperAction::End& end : action_->update()) {
      if (end.newest && moves_) take_result(end);
    }
    const auto since = action_->unanswered_since();
    if (moves_ && since && now - *since > kGripperAnswer) {
      finish(DeviceFailure{"the gripper's controller " + options_.controller +
                           " has not answered within 2 s: look at its log"});
    }
  } else if (moves_) {
    watch(now);
  }
}

void Gripper::take_result(const GripperAction::End& end) {
  if (!end.accepted) {
    finish(DeviceFailure{"the gripper's controller " + options_.controller +
                         " refuses the order: activate it in ROS 2, and look at its log"});
  } else if (end.status == GoalStatus::kSucceeded || end.result.stalled || end.result.reached_goal) {
    finish({});  // without allow_stalling, a controller aborts a goal when the fingers hold something
  } else {
    finish(DeviceFailure{std::string("the order to its gripper was ") +
                         (end.status == GoalStatus::kCanceled ? "cancelled by another node" : "aborted") +
                         ": look at the log of " + options_.controller});
  }
}

/// Without an answer of a controller: fingers that stand have arrived, or hold something.
void Gripper::watch(Clock::time_point now) {
  const std::vector<double> measured = positions(now);
  if (measured.empty()) {
    if (now - moved_ > kGripperAnswer) finish(DeviceFailure{"no joint state of its fingers arrives any more"});
    return;
  }
  const bool has_moved = moved_ > began_;
  if (!within(measured, last_, kNoise)) {
    last_ = measured;
    moved_ = now;
  } else if (now - moved_ > kStands && (within(measured, target_, kArrived) || has_moved)) {
    finish({});
  } else if (!has_moved && now - began_ > kBegins) {
    finish(DeviceFailure{"its fingers stand although they were ordered to move: activate " + options_.controller +
                         " in ROS 2"});
  }
}

void Gripper::finish(DeviceResult result) {
  moves_ = false;
  end_ = OrderEnd{std::move(result)};
}

std::optional<OrderEnd> Gripper::end() {
  return std::exchange(end_, std::nullopt);
}

}  // namespace hecaton::device::ros2_control
