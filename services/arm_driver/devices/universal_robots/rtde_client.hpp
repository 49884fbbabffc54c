#pragma once
/// A client of RTDE (port 30004): the state of a robot in each of its cycles, and its speed slider, its inputs and
/// outputs.

#include <array>
#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "services/arm_driver/devices/arm_device.hpp"
#include "services/arm_driver/devices/universal_robots/io_ports.hpp"
#include "services/arm_driver/devices/universal_robots/rtde.hpp"
#include "services/arm_driver/devices/universal_robots/tcp.hpp"
#include "services/runtime/sender_clock.hpp"

namespace hecaton::device::universal_robots {

/// What a robot reports in a cycle. The numbers of states are those of the controller (robot_state.hpp).
struct RobotData {
  double timestamp = 0.0;      ///< robot's clock [s]
  std::array<double, 6> q{};   ///< [rad]
  std::array<double, 6> qd{};  ///< [rad/s]
  double speed_scaling = 1.0;
  double target_speed_fraction = 1.0;  ///< of the speed slider
  std::uint32_t runtime_state = 0;
  std::int32_t robot_mode = 0;
  std::int32_t safety_mode = 0;
  // Inputs and outputs, if the client was asked for them and the controller has them.
  std::optional<std::uint64_t> digital_inputs, digital_outputs;                                  ///< bits: io_ports.hpp
  std::array<std::optional<double>, 2> analog_inputs{}, tool_analog_inputs{}, analog_outputs{};  ///< [V | A]
};

struct RtdeSetup {
  std::string address;
  double frequency = 500.0;            ///< of data wanted [Hz]; a CB3 sends 125 Hz at most
  std::optional<double> speed_slider;  ///< to be set at the start, 0 to 1; empty: the client does not write it
  std::vector<IoPort> ports = {};      ///< inputs and outputs to read, and the outputs to write
};

/// Connects, agrees on version and recipes, then takes data. No call waits. For one thread.
class RtdeClient {
 public:
  /// `log`: for the version of the controller and its messages; may be empty.
  RtdeClient(RtdeSetup setup, DeviceLog log) : setup_(std::move(setup)), log_(std::move(log)) {}

  void open(Clock::time_point now);
  void close();
  /// Call it once a period.
  void update(Clock::time_point now);

  /// Sets an output of RtdeSetup::ports: 0 or 1, or [V]. Fails before the first data and beyond 10 V.
  [[nodiscard]] DeviceResult set_output(const IoPort& port, double value);

  /// Why there are no data any more, as one sentence; empty: no failure.
  [[nodiscard]] const std::string& error() const { return error_; }
  [[nodiscard]] bool failed() const { return step_ == Step::kFailed; }
  /// The newest data; empty before the first.
  [[nodiscard]] const std::optional<RobotData>& data() const { return data_; }
  /// When they were measured, on this machine's clock.
  [[nodiscard]] Clock::time_point measured_at() const { return measured_at_; }
  /// The address of this machine as the robot sees it.
  [[nodiscard]] std::string own_address() const { return connection_.own_address(); }
  /// Major version of the controller: 3 of a CB3, 5 of an e-Series; 0: not known yet.
  [[nodiscard]] std::uint32_t major_version() const { return major_version_; }

 private:
  enum class Step { kClosed, kConnecting, kVersion, kController, kOutputs, kInputs, kStart, kData, kFailed };
  struct Recipe {
    std::uint8_t id = 0;
    std::vector<std::size_t> fields;  ///< indices of the known output fields
  };

  void fail(std::string sentence);
  [[nodiscard]] std::string advice() const;
  void take(const Package& package, Clock::time_point now);
  void take_version(std::string_view payload);
  void take_controller(std::string_view payload);
  void take_outputs(std::string_view payload);
  void take_inputs(std::string_view payload);
  void take_start(std::string_view payload);
  void take_data(std::string_view payload, Clock::time_point now);
  void ask_version(std::uint16_t version);
  void ask_outputs();
  void ask_inputs_or_start();
  [[nodiscard]] bool wants(std::size_t field) const;
  [[nodiscard]] std::vector<std::string> inputs() const;
  void write_inputs(const std::map<std::string, double, std::less<>>& values);

  RtdeSetup setup_;
  DeviceLog log_;
  TcpConnection connection_;
  Step step_ = Step::kClosed;
  std::string error_;
  Clock::time_point deadline_;  ///< of the handshake, then of the next data
  int version_ = 1;
  std::uint32_t major_version_ = 0;
  Recipe outputs_;
  std::uint8_t inputs_id_ = 0;  ///< of the recipe of inputs()
  std::optional<RobotData> data_;
  bool has_worked_ = false;  ///< this or an earlier connection had data
  Clock::time_point measured_at_;
  /// The clock of a simulated controller stands still while its machine stalls: a short window forgets that soon.
  static constexpr std::chrono::seconds kClockWindow{2};
  services::SenderClock clock_{kClockWindow};
};

}  // namespace hecaton::device::universal_robots
