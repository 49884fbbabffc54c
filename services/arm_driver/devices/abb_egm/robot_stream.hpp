#pragma once
/// The stream of messages between a robot and its device: order, joints and time of what the robot sends, and the
/// answers to it.

#include <cstdint>
#include <optional>
#include <string>

#include "services/arm_driver/devices/abb_egm/messages.hpp"
#include "services/arm_driver/devices/abb_egm/options.hpp"
#include "services/arm_driver/devices/abb_egm/udp_channel.hpp"
#include "services/arm_driver/devices/arm_device.hpp"

namespace hecaton::device::abb_egm {

/// Receives what the robot reports, and answers with positions. It believes the datagrams of one address: `robot_ip`,
/// else that of the first message, until the object ends. Damaged, repeated and overtaken messages, and those whose
/// joints cannot have moved so far, count as not sent. For one thread.
class RobotStream {
 public:
  /// `prismatic`: of each joint; empty: all are revolute.
  RobotStream(Options options, Eigen::Index joints, const std::vector<bool>& prismatic, DeviceLog log);

  /// Listens. Forgets what the robot has reported before.
  [[nodiscard]] DeviceResult open();
  /// Takes what has arrived.
  void receive(Clock::time_point now);
  /// The robot has reported since the last answer.
  [[nodiscard]] bool awaits_answer() const { return awaits_answer_; }
  /// Sends a position [rad | m]. Does nothing unless the robot awaits it: the controller takes one in its period.
  void answer(const JointVector& q);

  /// The last message; empty: none since open().
  [[nodiscard]] const std::optional<RobotMessage>& last() const { return last_; }
  [[nodiscard]] Clock::time_point received_at() const { return received_at_; }
  /// When the last answer was sent, or when open() was called.
  [[nodiscard]] Clock::time_point answered_at() const { return answered_at_; }
  /// Measured, with velocities from differences; its size is zero when the robot has not the joints of the arm.
  [[nodiscard]] const JointState& measured() const { return measured_; }
  /// EGM moves the arm to the answers, and has done so in each message that the last receive() has taken.
  [[nodiscard]] bool guided() const { return guided_; }
  /// The robot has sent a message since the object began.
  [[nodiscard]] bool was_heard() const { return was_heard_; }
  /// The robot's address; empty: not known yet.
  [[nodiscard]] const std::optional<std::string>& robot() const { return robot_; }
  /// Says what arrives instead of messages, for a failure's sentence; empty: nothing.
  [[nodiscard]] std::string what_arrives() const;

  /// Where an additional axis is that the arm does not have [° | mm], unless it stands at 0; empty: there is none.
  [[nodiscard]] std::optional<double> unknown_axis(const RobotMessage& message) const;

 private:
  void take(const RobotMessage& message, Clock::time_point now);
  [[nodiscard]] bool is_next(const RobotMessage& message) const;
  [[nodiscard]] JointVector positions(const RobotMessage& message) const;
  [[nodiscard]] double seconds_since_last(const RobotMessage& message) const;

  Options options_;
  JointVector scale_;  ///< units on the wire per rad or m
  DeviceLog log_;
  UdpChannel channel_;
  std::optional<std::string> robot_;
  std::optional<RobotMessage> last_;
  Clock::time_point received_at_;
  JointState measured_;
  bool awaits_answer_ = false;
  bool was_heard_ = false;
  bool guided_ = false;
  int unreadable_ = 0;  ///< datagrams since open()
  Clock::time_point opened_at_, answered_at_;
};

}  // namespace hecaton::device::abb_egm
