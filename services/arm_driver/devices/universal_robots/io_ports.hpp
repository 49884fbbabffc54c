#pragma once
/// Digital and analog ports of a controller and of the tool flange. Pure.

#include <optional>
#include <string_view>

#include "services/arm_driver/devices/arm_device.hpp"

namespace hecaton::device::universal_robots {

enum class IoBank {
  kDigitalInput,
  kConfigurableInput,
  kToolInput,
  kDigitalOutput,
  kConfigurableOutput,
  kToolOutput,
  kAnalogInput,
  kToolAnalogInput,
  kAnalogOutput,
};

struct IoPort {
  IoBank bank = IoBank::kDigitalInput;
  int pin = 0;
};

/// Reads "tool_output 0", a value of `signals` in the cell file. Empty: no such port.
[[nodiscard]] std::optional<IoPort> parse_port(std::string_view text);
[[nodiscard]] SignalKind kind_of(IoBank bank);
/// The bit of a digital port in the bits that RTDE has for all inputs or all outputs.
[[nodiscard]] int bit_of(const IoPort& port);

inline constexpr double kMostVolts = 10.0;  ///< of an analog output

}  // namespace hecaton::device::universal_robots
