#pragma once
/// The messages of ABB's Externally Guided Motion (EGM), in the wire format of protocol buffers. Pure.
///
/// A decoder of our own for the few fields that the device needs: bounded, without allocation in the driver's loop, and
/// without a code generator and a library whose versions must match. It skips fields that it does not know.

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

namespace hecaton::device::abb_egm {

/// Joints of the robot and of its additional axes: the messages have room for six of each.
inline constexpr std::size_t kMostJoints = 6;

enum class MotorState : std::uint8_t { kUndefined = 0, kOn = 1, kOff = 2 };
/// Of the motion that EGM guides ("MCI").
enum class GuidanceState : std::uint8_t { kUndefined = 0, kError = 1, kStopped = 2, kRunning = 3 };
enum class RapidState : std::uint8_t { kUndefined = 0, kStopped = 1, kRunning = 2 };

/// Values of up to six joints: [deg] for rotating axes, [mm] for linear ones.
struct JointValues {
  std::array<double, kMostJoints> values{};
  std::size_t count = 0;

  [[nodiscard]] std::span<const double> get() const { return {values.data(), count}; }
  /// False: there is no room.
  bool add(double value) {
    if (count == kMostJoints) return false;
    values[count++] = value;
    return true;
  }
};

/// What a controller sends (EgmRobot).
struct RobotMessage {
  std::uint32_t sequence_number = 0;
  std::uint32_t sent_ms = 0;              ///< clock of the controller
  JointValues joints;                     ///< measured
  JointValues external;                   ///< measured, of additional axes
  std::optional<std::uint64_t> clock_us;  ///< of the measurement; RobotWare before 6.07 has none
  MotorState motors = MotorState::kUndefined;
  GuidanceState guidance = GuidanceState::kUndefined;
  RapidState rapid = RapidState::kUndefined;
  bool converged = false;  ///< the arm is at its set-point
};

/// Nullopt: damaged, a joint value is not finite, or number, time, measured joints or one of the states is missing.
[[nodiscard]] std::optional<RobotMessage> decode(std::string_view bytes);

/// What a controller takes (EgmSensor): a position that the arm shall reach.
struct SensorMessage {
  std::uint32_t sequence_number = 0;
  std::uint32_t sent_ms = 0;
  JointValues joints;
  JointValues external;
};

inline constexpr std::size_t kLargestSensorMessage = 160;
using SensorBuffer = std::array<char, kLargestSensorMessage>;

/// Writes the message into `buffer` and returns its bytes there.
[[nodiscard]] std::string_view encode(const SensorMessage& message, SensorBuffer& buffer);

}  // namespace hecaton::device::abb_egm
