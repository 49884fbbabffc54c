#pragma once
/// The interface between the driver node and an arm's controller. The driver handles lease, command checks,
/// interpolation, stop profile, modes and publishing for every arm. A device handles the protocol of one kind of
/// controller. docs/how-to/add-a-device.md shows how to add one. No DDS and no planner in this header.
///
/// Lifecycle of a device, all on the thread of the driver's loop:
///
///     configure ─► (read until kReady) ─► activate ─► { read, write } each period ─► stop ─► deactivate
///
/// When the device is no longer ready, the driver calls deactivate() and continues to read; when it is ready again, the
/// driver activates it again. After a failure of any call the driver calls stop(), deactivate() and, a second later,
/// configure() again.

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
  kNotReady,        ///< off, booting, brakes on, in manual mode: an operator must act
  kProtectiveStop,  ///< the controller stopped the arm by itself; an operator must release it
  kEmergencyStop,   ///< an emergency or safeguard stop
  kFailed,          ///< a fault of the controller or of the connection to it
};

struct DeviceState {
  /// Measured joint positions and velocities. Empty when the device has never measured any.
  JointState measured;
  std::chrono::nanoseconds age{0};  ///< of `measured`, transport included, on this machine's steady clock
  double speed_scaling = 1.0;       ///< 0 to 1: executed speed relative to the commanded one
  DeviceMode mode = DeviceMode::kNotReady;
  std::string text;  ///< one sentence: why it is not kReady and what to do; else empty
};

/// Why a call failed, as one sentence.
struct DeviceFailure {
  std::string text;
};
/// Empty: the call succeeded.
using DeviceResult = std::optional<DeviceFailure>;

/// No call may throw. Each returns within a period of the driver, except configure(), which may take up to a second.
/// A device need not be thread-safe.
class ArmDevice {
 public:
  virtual ~ArmDevice() = default;

  /// Opens connections and reads the controller's own data. Nothing moves. May be called again after a failure.
  [[nodiscard]] virtual DeviceResult configure() = 0;

  /// The device follows set-points from now on; the first one is the state that was read last, at rest. Called only
  /// when that state was kReady.
  [[nodiscard]] virtual DeviceResult activate() = 0;

  /// The newest state known at `now`, with its `age`. Never waits for a new one. The driver treats the arm as failed
  /// when the age exceeds the cell's `timing.command_timeout`.
  [[nodiscard]] virtual DeviceState read(Clock::time_point now) = 0;

  /// Sends a set-point that the arm shall reach one driver period after the last read(). Called only while active. The
  /// device must stop the arm by itself when no further write() follows within `valid_for`. Preferably the controller
  /// does this, so that it also works when this machine fails; the device's documentation must say which one does it.
  [[nodiscard]] virtual DeviceResult write(const JointState& set_point, std::chrono::nanoseconds valid_for) = 0;

  /// Stops the arm on the device's own stop profile and drops the set-point. `reason` is for the controller's log or
  /// screen. May be called at any time, also before configure() and when inactive.
  virtual void stop(std::string_view reason) = 0;

  /// The device no longer follows set-points. May be called at any time.
  virtual void deactivate() = 0;

  /// Lag of the measured state behind the set-points [s]. With 0 a stop begins from the measured state. Otherwise it
  /// begins from the last set-point, because the set-point would else jump back by the lag.
  [[nodiscard]] virtual double tracking_delay() const { return 0.0; }
};

/// The data from which a device is created.
struct DeviceSetup {
  std::string arm;                                         ///< its name in the cell
  JointLimits limits;                                      ///< as the cell file gives them
  JointVector start;                                       ///< position at which the cell starts
  std::chrono::nanoseconds period{0};                      ///< of the driver's loop
  std::string checkpoint;                                  ///< a file that survives the process; empty: none
  std::string where;                                       ///< "FILE: arms[0].device", the prefix of messages
  std::map<std::string, std::string, std::less<>> values;  ///< the other keys of `device:` in the cell file
};

/// One kind of device, which `device: {type: …}` in the cell file may name.
struct DeviceType {
  std::string type;
  std::vector<std::string_view> keys;  ///< allowed in `device:` beside `type`
  /// Opens nothing yet. Throws std::runtime_error with a sentence (key, value, what is allowed) when a value cannot be
  /// used.
  std::unique_ptr<ArmDevice> (*make)(const DeviceSetup& setup);
};

/// The kinds of devices of this program.
[[nodiscard]] const std::vector<DeviceType>& device_types();

}  // namespace hecaton::device
