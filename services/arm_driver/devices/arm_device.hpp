#pragma once
/// The interface between the driver node and an arm's controller. The driver handles lease, command checks,
/// interpolation, stop profile, modes and publishing for every arm. A device handles the protocol of one kind of
/// controller. docs/how-to/add-a-device.md shows how to add one. No DDS and no planner in this header.
///
/// Lifecycle of a device, all on the thread of the driver's loop:
///
///     configure ─► (read until kReady) ─► activate ─► (read while kStarting) ─► { read, write } each period ─► stop
///     ─► deactivate
///
/// The driver activates a device only while nothing holds the arm. When an active device is no longer ready, the driver
/// calls deactivate(), continues to read, and holds the arm until a person resumes it; then it activates the device
/// again. After a failure of any call the driver calls stop(), deactivate() and, a second later, configure() again. In
/// that second it still calls read() in each period, so that a device can go on with its stop, and ignores its modes.

#include <chrono>
#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "planner/trajectory/set_point_interpolator.hpp"

namespace hecaton::planner {
struct RobotModel;
}
namespace hecaton::bus {
class Participant;
}

namespace hecaton::device {

using planner::JointLimits;
using planner::JointState;
using planner::JointVector;
/// Steady clock of this machine.
using Clock = std::chrono::steady_clock;

/// Whether the arm can be moved, and if not, why.
enum class DeviceMode {
  kReady,             ///< follows set-points when it is active
  kStarting,          ///< connects, or begins to follow set-points; it becomes another mode within seconds
  kNotReady,          ///< off, booting, brakes on, in manual mode: an operator must act
  kRemoteControlOff,  ///< the controller takes no orders over the network
  kProgramStopped,    ///< the program on the controller, which follows the set-points, was stopped or paused
  kSafeguardStop,     ///< a safeguard stopped the arm: a light curtain, a door
  kProtectiveStop,    ///< the controller stopped the arm by itself; an operator must release it
  kEmergencyStop,     ///< an emergency stop
  kFailed,            ///< a fault of the controller or of the connection to it
};

/// What a device knows of its arm.
struct DeviceState {
  /// Measured joint positions and velocities. Empty when the device has never measured any.
  JointState measured;
  std::chrono::nanoseconds age{0};          ///< of `measured`, transport included, on this machine's steady clock
  double speed_scaling = 1.0;               ///< 0 to 1: executed speed relative to the commanded one
  DeviceMode mode = DeviceMode::kNotReady;  ///< whether the arm can be moved
  /// One sentence: why it is not kReady and what to do; else empty. Messages put the arm and its mode in front, as in
  /// "arm NAME: its device reports a failure: ".
  std::string text;
};

/// Why a call failed, as one sentence.
struct DeviceFailure {
  std::string text;  ///< what failed, and what to do
};
/// Empty: the call succeeded.
using DeviceResult = std::optional<DeviceFailure>;

/// What a person may order of a device. Nothing in a cell gives such an order by itself.
enum class DeviceOrder {
  kPowerOn,   ///< power on and release the brakes
  kPowerOff,  ///< brakes on, power off
  kUnlock,    ///< release a protective stop
};

/// Direction and values of a signal.
enum class SignalKind {
  kDigitalInput,   ///< 0 or 1
  kDigitalOutput,  ///< 0 or 1
  kAnalogInput,    ///< [V | A]
  kAnalogOutput,   ///< [V | A]
};

/// The end of an order: whether the controller has taken it.
struct OrderEnd {
  DeviceResult result;  ///< empty: taken; else why not
};

/// The controller of one arm, as the driver sees it. No call may throw. Each returns within a period of the driver,
/// except configure(), which may take up to a second. A device need not be thread-safe.
class ArmDevice {
 public:
  virtual ~ArmDevice() = default;

  /// Opens connections and reads the controller's own data. Nothing moves. May be called again after a failure; a stop
  /// that is under way then goes on.
  [[nodiscard]] virtual DeviceResult configure() = 0;

  /// The device shall follow set-points from now on. Called only when the last state was kReady. The device may need
  /// some seconds; meanwhile read() returns kStarting. The first set-point is the state of the first kReady, at rest.
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

  /// Begins an order. It runs while read() is called; order_end() reports its end. Fails for an order that the device
  /// does not have, and while another order runs.
  [[nodiscard]] virtual DeviceResult begin(DeviceOrder /*order*/) {
    return DeviceFailure{"its device takes no orders: switch it at its controller"};
  }
  /// The end of the order that begin() took, once; empty while it runs.
  [[nodiscard]] virtual std::optional<OrderEnd> order_end() { return {}; }

  /// Lag of the measured state behind the set-points [s]. With 0 a stop begins from the measured state. Otherwise it
  /// begins from the last set-point, because the set-point would else jump back by the lag.
  [[nodiscard]] virtual double tracking_delay() const { return 0.0; }

  /// The last value of DeviceSetup::signals[index], as the device reports it; empty: not known. Outputs, too: what the
  /// controller says, and not what was set last.
  [[nodiscard]] virtual std::optional<double> signal(std::size_t /*index*/) const { return {}; }
  /// Sets that signal. `value`: 0 or 1 of a digital one.
  [[nodiscard]] virtual DeviceResult set_signal(std::size_t /*index*/, double /*value*/) {
    return DeviceFailure{"its device sets no signals"};
  }

  /// Measured positions of DeviceSetup::outside [rad | m]; empty: the device measures none.
  [[nodiscard]] virtual std::vector<double> outside() const { return {}; }
  /// Moves these joints to `positions` at DeviceSetup::outside_speed [rad | m], and stays there. `force`: of the
  /// fingers at most [N]; negative: as the device chooses. A device may ignore it.
  [[nodiscard]] virtual DeviceResult move_outside(const std::vector<double>& /*positions*/, double /*force*/) {
    return DeviceFailure{"its device moves no joint outside the chain"};
  }
  /// True: something between the fingers stops them, and outside_end() reports the end of a motion. False: a motion
  /// ends when outside() is at its target.
  [[nodiscard]] virtual bool fingers_yield() const { return false; }
  /// The end of the motion that move_outside() began, once; empty while it runs.
  [[nodiscard]] virtual std::optional<OrderEnd> outside_end() { return {}; }

  /// True: the arm may move again without a person after a restart of the driver's process.
  [[nodiscard]] virtual bool continues_after_restart() const { return false; }
};

/// Writes a line to the driver's log: what happened, and its details. Thread-safe. May be empty.
using DeviceLog = std::function<void(std::string_view event, std::string_view details)>;

/// Joins the cell's DDS domain with the keys of a driver. Throws std::runtime_error with a sentence.
using JoinCell = std::function<std::unique_ptr<bus::Participant>()>;

/// The forces that an arm's drives need [N m | N], by the masses of its robot description: for simulated arms.
struct DriveForces {
  /// Of each joint, for the velocity and acceleration at a position; without friction and payload. Empty: not known.
  std::function<JointVector(const JointVector& q, const JointVector& qd, const JointVector& qdd)> of_motion = {};
  JointVector limits;  ///< of each joint, > 0
  std::string reason;  ///< why they are not known: a clause such as "link wrist has no mass"
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
  int index = 0;                                           ///< of the arm in the cell, for default ports
  std::chrono::nanoseconds command_timeout{0};             ///< silence of commands after which the driver stops the arm
  DeviceLog log = {};                                      ///< for events of the device; empty: none are logged
  std::vector<bool> prismatic = {};                        ///< of each joint; empty: all are revolute
  std::vector<std::string> joint_names = {};               ///< of each joint in the robot description
  JoinCell join = {};                                      ///< for devices that use topics; empty in checks
  std::vector<std::string> signals = {};                   ///< ports of the signals, as DeviceType::signal accepts them
  std::vector<double> outside = {};             ///< start of each joint outside the chain that has a range [rad | m]
  double outside_speed = 0.0;                   ///< of these joints, when a gripper moves them [rad/s | m/s]
  std::vector<std::string> outside_names = {};  ///< of the same joints, in the robot description
  std::vector<bool> fingers = {};               ///< which of them belong to the gripper
  DriveForces forces = {};                      ///< of a simulated arm
  std::vector<std::string> robot_names = {};    ///< that the robot description and its xacro arguments give the robot
  std::shared_ptr<const planner::RobotModel> model = {};  ///< the robot description; null: not known
};

/// A port of this machine on which a device listens.
struct ListeningPort {
  int number = 0;    ///< 1 to 65535
  std::string key;   ///< of `device:` that sets it
  bool udp = false;  ///< of UDP, else of TCP
};

/// Something that moves one arm only, such as a controller on the network.
struct Claim {
  std::string what;  ///< the same text for the same thing, on all hosts
  std::string key;   ///< of `device:` that names it
};

/// One kind of device, which `device: {type: …}` in the cell file may name.
struct DeviceType {
  std::string type;                    ///< its name in the cell file
  std::vector<std::string_view> keys;  ///< allowed in `device:` beside `type`
  /// Opens nothing yet. Throws std::runtime_error with a sentence (key, value, what is allowed) when a value cannot be
  /// used.
  std::unique_ptr<ArmDevice> (*make)(const DeviceSetup& setup);
  /// The ports on which the device will listen. Two devices of one host must not share one. Null: none. Throws as make.
  std::vector<ListeningPort> (*ports)(const DeviceSetup& setup) = nullptr;
  /// What `hecaton check` says about the arm beside errors, a sentence each. Null: nothing. Throws as make.
  std::vector<std::string> (*notes)(const DeviceSetup& setup, const planner::RobotModel& model) = nullptr;
  /// What a person does after `hecaton up` until the arm follows: commands, or comments that begin with #. ARM stands
  /// for the name of the arm. Empty: the arm follows by itself.
  std::vector<std::string_view> steps{};
  /// What no other arm of the cell may use. Null: nothing. Throws as make.
  std::vector<Claim> (*claims)(const DeviceSetup& setup) = nullptr;
  /// The kind of a port such as "digital_output 3", a value of `signals` in the cell file; empty: no such port. Null:
  /// the device has no signals.
  std::optional<SignalKind> (*signal)(std::string_view port) = nullptr;
  std::string_view signal_ports{};  ///< for messages: "digital_input 0 to 7 or digital_output 0 to 7"
  bool moves_outside = false;       ///< move_outside() works for fingers
  /// True: the arm moves on when the driver's process or host fails, because its controller does not stop it. Null: its
  /// controller does. Throws as make.
  bool (*goes_on)(const DeviceSetup& setup) = nullptr;
};

/// The kinds of devices of this program.
[[nodiscard]] const std::vector<DeviceType>& device_types();

}  // namespace hecaton::device
