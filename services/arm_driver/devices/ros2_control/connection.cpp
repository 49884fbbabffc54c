#include "services/arm_driver/devices/ros2_control/connection.hpp"

#include <algorithm>
#include <cmath>

#include "services/ros2_messages/cdr.hpp"

namespace hecaton::device::ros2_control {
namespace {

/// speed_scaling_state_broadcaster publishes at 100 Hz.
constexpr std::chrono::seconds kScalingSilence{1};

bus::ParticipantOptions participant_options(const Options& options) {
  bus::ParticipantOptions result = bus::ros2::participant_options();
  if (options.address) result.interfaces = {*options.address};
  return result;
}

/// The newest sample alone counts, and best effort matches each writer.
bus::ros2::Topic state_topic(const std::string& name, const ros2::TypeInfo& type) {
  bus::ros2::Topic topic;
  topic.name = name;
  topic.type = type.name;
  topic.hash = type.hash;
  topic.reliable = false;
  return topic;
}

bus::ros2::Topic command_topic(const Options& options) {
  const bool trajectory = options.interface == Interface::kTrajectory;
  const ros2::TypeInfo& type = trajectory ? ros2::type::kJointTrajectory : ros2::type::kFloat64MultiArray;
  bus::ros2::Topic topic = state_topic(options.controller + (trajectory ? "/joint_trajectory" : "/commands"), type);
  topic.reliable = true;
  topic.depth = 1;  // an older command is out of date
  return topic;
}

// The last factor that was published before this node joined counts, too.
bus::ros2::Topic scaling_input_topic(const Options& options) {
  bus::ros2::Topic topic = state_topic(options.controller + "/speed_scaling_input", ros2::type::kSpeedScalingFactor);
  topic.reliable = topic.transient_local = true;
  topic.depth = 1;
  return topic;
}

/// Its fields differ between distributions. They are not read.
bus::ros2::Topic controller_state_topic(const Options& options) {
  return state_topic(options.controller + "/controller_state", {"control_msgs/msg/JointTrajectoryControllerState", ""});
}

}  // namespace

Connection::Connection(const Options& options, Clock::duration silence_limit)
    : options_(options),
      participant_(options.domain, "/", participant_options(options)),
      joint_states_(participant_, state_topic(options.joint_states, ros2::type::kJointState), mailbox_),
      states_(silence_limit) {
  if (options.interface == Interface::kAction) {
    action_.emplace(participant_, options.controller + "/follow_joint_trajectory",
                    TrajectoryAction::Types{ros2::type::kSendTrajectory, ros2::type::kTrajectoryResult}, mailbox_);
  } else {
    commands_.emplace(participant_, command_topic(options));
  }
  if (options.gripper) gripper_.emplace(*options.gripper, silence_limit, participant_, mailbox_);
  if (options.interface == Interface::kTrajectory) {
    controller_state_.emplace(participant_, controller_state_topic(options), mailbox_);
  }
  if (has_trajectories(options.interface)) {
    scaling_input_.emplace(participant_, scaling_input_topic(options), mailbox_);
  }
  if (options.speed_scaling) {
    scaling_state_.emplace(participant_, state_topic(*options.speed_scaling, ros2::type::kFloat64), mailbox_);
  }
}

void Connection::update() {
  if (controller_state_) {
    for (const bus::ros2::Sample& sample : controller_state_->take()) states_.add(sample.received);
  }
  if (scaling_input_) {
    for (const bus::ros2::Sample& sample : scaling_input_->take()) {
      const auto message = ros2::decoded<ros2::SpeedScalingFactor>(sample.bytes);
      if (message && message->factor >= 0.0) scaling_of_controller_ = std::min(1.0, message->factor);
    }
  }
  if (scaling_state_) {
    for (const bus::ros2::Sample& sample : scaling_state_->take()) {
      const auto message = ros2::decoded<ros2::Float64>(sample.bytes);
      if (!message || !std::isfinite(message->data)) continue;
      scaling_of_hardware_ = std::clamp(message->data / 100.0, 0.0, 1.0);
      scaling_at_ = sample.received;
    }
  }
}

bool Connection::send(const ros2::Float64MultiArray& message) {
  ros2::encode(message, bytes_);
  return commands_->write(bytes_);
}

bool Connection::send(const ros2::JointTrajectory& message, Clock::time_point now) {
  if (action_) {
    ros2::TrajectoryGoal goal;
    goal.trajectory = message;
    return action_->send(goal, now);
  }
  ros2::encode(message, bytes_);
  return commands_->write(bytes_);
}

std::optional<double> Connection::speed_scaling(Clock::time_point now) const {
  if (scaling_state_ && (!scaling_at_ || now - *scaling_at_ > kScalingSilence)) return std::nullopt;
  return scaling_of_controller_ * scaling_of_hardware_;
}

}  // namespace hecaton::device::ros2_control
