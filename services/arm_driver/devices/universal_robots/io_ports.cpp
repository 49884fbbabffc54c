#include "services/arm_driver/devices/universal_robots/io_ports.hpp"

#include <array>

namespace hecaton::device::universal_robots {
namespace {

struct Bank {
  std::string_view name;
  IoBank bank;
  SignalKind kind;
  int pins;
  int first_bit;  ///< of digital ones: 8 standard, 8 configurable, 2 at the tool
};

constexpr std::array<Bank, 9> kBanks{{
    {"digital_input", IoBank::kDigitalInput, SignalKind::kDigitalInput, 8, 0},
    {"configurable_input", IoBank::kConfigurableInput, SignalKind::kDigitalInput, 8, 8},
    {"tool_input", IoBank::kToolInput, SignalKind::kDigitalInput, 2, 16},
    {"digital_output", IoBank::kDigitalOutput, SignalKind::kDigitalOutput, 8, 0},
    {"configurable_output", IoBank::kConfigurableOutput, SignalKind::kDigitalOutput, 8, 8},
    {"tool_output", IoBank::kToolOutput, SignalKind::kDigitalOutput, 2, 16},
    {"analog_input", IoBank::kAnalogInput, SignalKind::kAnalogInput, 2, 0},
    {"tool_analog_input", IoBank::kToolAnalogInput, SignalKind::kAnalogInput, 2, 0},
    {"analog_output", IoBank::kAnalogOutput, SignalKind::kAnalogOutput, 2, 0},
}};

const Bank& row_of(IoBank bank) {
  return kBanks[static_cast<std::size_t>(bank)];
}

}  // namespace

std::optional<IoPort> parse_port(std::string_view text) {
  for (const Bank& row : kBanks) {
    const bool fits = text.size() == row.name.size() + 2 && text.starts_with(row.name) && text[row.name.size()] == ' ';
    const int pin = fits ? text.back() - '0' : -1;
    if (pin >= 0 && pin < row.pins) return IoPort{row.bank, pin};
  }
  return std::nullopt;
}

SignalKind kind_of(IoBank bank) {
  return row_of(bank).kind;
}

int bit_of(const IoPort& port) {
  return row_of(port.bank).first_bit + port.pin;
}

}  // namespace hecaton::device::universal_robots
