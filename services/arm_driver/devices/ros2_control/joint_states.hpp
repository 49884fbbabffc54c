#pragma once
/// What joint_state_broadcaster reports of an arm, from messages of sensor_msgs/msg/JointState. No network.

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "services/arm_driver/devices/arm_device.hpp"
#include "services/bus/mailbox.hpp"
#include "services/ros2_messages/ros2_types.hpp"

namespace hecaton::device::ros2_control {

/// Collects positions and velocities of an arm's joints by their names. Messages may have the joints in any order,
/// joints of other arms, or some of the joints only. A joint without a velocity in the messages gets one from
/// differences of its positions. For one thread.
class JointStates {
 public:
  /// `joints`: names in the messages, in the order of the arm's joints. `silence_limit`: after it, a joint may come
  /// from another writer than before.
  JointStates(std::vector<std::string> joints, Clock::duration silence_limit);

  /// A serialised message with its encapsulation.
  void take(std::span<const std::uint8_t> bytes, const bus::EndpointId& writer, Clock::time_point received);
  void forget();

  /// Of all joints; its size is zero until the position and the velocity of each are known.
  [[nodiscard]] JointState measured() const;
  /// When the oldest position in measured() was received. Precondition: measured() is not empty.
  [[nodiscard]] Clock::time_point received() const;
  /// A message arrived since the object began or forgot.
  [[nodiscard]] bool was_heard() const { return heard_; }
  /// Why positions are missing or not used, one sentence part for a fault; empty: nothing is wrong with the messages.
  [[nodiscard]] std::string complaint() const;
  /// Two writers publish a joint: its name. Empty: none did in the last seconds before `now`.
  [[nodiscard]] std::optional<std::string> twice_published(Clock::time_point now) const;

 private:
  struct Joint {
    bus::EndpointId writer;
    std::optional<Clock::time_point> received;  ///< empty: no position yet
    double stamp = 0.0;                         ///< of the message, on the clock of its sender [s]
    double q = 0.0;
    std::optional<double> qd;
    bool is_number = true;  ///< in the last message with this joint
  };
  struct Message {
    const ros2::JointState& content;
    bus::EndpointId writer;
    Clock::time_point received;
  };

  void take(Joint& joint, const Message& message, std::size_t place);
  [[nodiscard]] std::optional<double> velocity(const Joint& joint, const Message& message, std::size_t place) const;

  std::vector<std::string> names_;
  Clock::duration silence_limit_;
  std::vector<Joint> joints_;
  bool heard_ = false;
  bool malformed_ = false;               ///< the last message
  std::vector<std::string> last_names_;  ///< in the last message that was well-formed
  struct Conflict {
    std::size_t joint = 0;
    Clock::time_point at;
  };
  std::optional<Conflict> conflict_;
};

}  // namespace hecaton::device::ros2_control
