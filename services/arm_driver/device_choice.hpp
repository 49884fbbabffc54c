#pragma once
/// From `device:` in the cell file to the device.

#include <memory>
#include <span>
#include <string>

#include "services/arm_driver/devices/arm_device.hpp"
#include "services/config/cell_file.hpp"

namespace hecaton::services {

/// Throws config::ConfigError when an arm's `device:` names a type that is not among `types`, or a key that the type
/// does not have: where the cell file is checked before anything starts.
void require_known_devices(const config::CellFile& file,
                           std::span<const device::DeviceType> types = device::device_types());

/// The device of the arm. `checkpoint`: a file for what must survive the process; empty: none. Throws
/// std::runtime_error with a sentence when it cannot be made.
[[nodiscard]] std::unique_ptr<device::ArmDevice> make_device(const config::CellFile& file, int arm,
                                                             const std::string& checkpoint,
                                                             std::span<const device::DeviceType> types);

}  // namespace hecaton::services
