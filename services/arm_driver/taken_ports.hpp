#pragma once
/// The ports of this machine on which the devices of a cell will listen, and which other programs hold. Linux.

#include <span>
#include <string>
#include <vector>

#include "services/arm_driver/devices/arm_device.hpp"
#include "services/config/cell_file.hpp"

namespace hecaton::services {

/// A port that an arm needs and another program holds.
struct TakenPort {
  std::string text;        ///< one sentence: key, value, the program that holds it, what to do
  bool by_driver = false;  ///< a driver of Hecaton holds it, perhaps of the same cell
};

/// For the arms whose host is this machine; in a cell with one host, for all. Looks by binding each port for a moment.
/// Throws as make_device().
[[nodiscard]] std::vector<TakenPort> taken_ports(const config::CellFile& file,
                                                 std::span<const device::DeviceType> types = device::device_types());

}  // namespace hecaton::services
