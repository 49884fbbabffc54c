#pragma once
/// The interface between the driver node and an arm's controller. Above it, the same for every arm: lease, checks of
/// commands, interpolation, stop profile, modes, publishing. Below it: the protocol of one kind of controller.
/// docs/how-to/add-a-device.md shows how to add one. No DDS and no planner in this header.
///
/// The driver's life with a device, all of it on the thread of the driver's loop:
///
///     configure ─► (read until kReady) ─► activate ─► { read, write } each period ─► stop ─► deactivate
///
/// When the device is not ready any more, the driver calls deactivate() and goes on reading; when it is ready again,
/// the driver activates it again. When configure() fails, the driver calls it again once a second.

#include <chrono>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "planner/trajectory/set_point_interpolator.hpp"

namespace hecaton::device {

using planner::JointLimits;
using planner::JointState;
using planner::JointVector;
using Clock = std::chrono::steady_clock;

/// Whether the arm can be moved, and if not, why.
enum class DeviceMode {
  kReady,           ///< follows set-points when it is active
  kNotReady,        ///< off, booting, brakes on, in manual mode: a person has to do something
  kProtectiveStop,  ///< the controller stopped the arm by itself; a person has to release it
  kEmergencyStop,   ///< an emergency or safeguard stop
  kFailed,          ///< a fault of the controller or of the connection to it
};

struct DeviceState {
  /// Measured joint positions and velocities. Empty when the device has never measured any.
  JointState measured;
  std::chrono::nanoseconds age{0};  ///< of `measured`, transport included, on this machine's steady clock
  double speed_scaling = 1.0;  ///< 0 to 1: how fast the controller executes set-points, compared with what was asked
  DeviceMode mode = DeviceMode::kNotReady;
  std::string text;  ///< one sentence for people: why it is not kReady and what to do; else empty
};

/// Why a call failed, as one sentence.
struct DeviceFailure {
  std::string text;
};
/// Nothing: the call succeeded.
using DeviceResult = std::optional<DeviceFailure>;

/// No call may throw. Each returns within a period of the driver, except configure(), which may take up to a second.
/// A device need not be thread-safe.
class ArmDevice {
 public:
  virtual ~ArmDevice() = default;

  /// Opens connections and reads what the controller says of itself. Nothing moves. May be called again after a
  /// failure.
  [[nodiscard]] virtual DeviceResult configure() = 0;

  /// From now on set-points are followed; the first one that is written is the state that was read last, at rest.
  /// Called only when the last state was kReady.
  [[nodiscard]] virtual DeviceResult activate() = 0;

  /// The newest state that is known at `now`. Never waits for a new one: `age` says how old it is. The driver holds the
  /// arm as failed when that is more than the cell's `timing.command_timeout`.
  [[nodiscard]] virtual DeviceState read(Clock::time_point now) = 0;

  /// The arm has to be at `set_point` one period of the driver after the last read(). Called only while active. The
  /// device must stop the arm by itself when no further write() comes within `valid_for`. Ideally the controller does
  /// this, so that it also holds when this machine fails; describe in the device's documentation who does it.
  [[nodiscard]] virtual DeviceResult write(const JointState& set_point, std::chrono::nanoseconds valid_for) = 0;

  /// Stops the arm as fast as it may, on the device's own stop profile, and drops the set-point. `reason`: for the
  /// controller's log or screen. Safe at any time, also before configure() and when inactive.
  virtual void stop(std::string_view reason) = 0;

  /// Set-points are not followed any more. Safe at any time.
  virtual void deactivate() = 0;

  /// How far the measured state lags behind the set-points [s]. With 0 a stop begins from the measured state, else from
  /// the last set-point: otherwise the set-point would jump back by what the arm lags behind.
  [[nodiscard]] virtual double tracking_delay() const { return 0.0; }
};

/// What a device is made from.
struct DeviceSetup {
  std::string arm;                                         ///< its name in the cell
  JointLimits limits;                                      ///< as the cell file gives them
  JointVector start;                                       ///< where the cell expects it when it comes up
  std::chrono::nanoseconds period{0};                      ///< of the driver's loop
  std::string checkpoint;                                  ///< a file for what must survive the process; empty: none
  std::string where;                                       ///< "FILE: arms[0].device", with which messages begin
  std::map<std::string, std::string, std::less<>> values;  ///< the other keys of `device:` in the cell file
};

/// One kind of device: what `device: {type: …}` in the cell file may name.
struct DeviceType {
  std::string type;
  std::vector<std::string_view> keys;  ///< that `device:` may have besides `type`
  /// Throws std::runtime_error with a sentence (key, value, what is allowed) when a value cannot be used. Nothing is
  /// opened yet.
  std::unique_ptr<ArmDevice> (*make)(const DeviceSetup& setup);
};

/// The devices of this program, one line each.
[[nodiscard]] const std::vector<DeviceType>& device_types();

}  // namespace hecaton::device
