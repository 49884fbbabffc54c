#pragma once
/// Selects and creates the device that `device:` in the cell file names. `types`: those of the program; an arm whose
/// `device:` has the key `plugin` chooses among the types of that library instead.

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "planner/simulation/servo.hpp"
#include "services/arm_driver/devices/arm_device.hpp"
#include "services/config/cell_file.hpp"

namespace hecaton::services {

/// True: `device: {type: observed, source: TYPE, …}`. Others move the arm from the start, and a device of the type TYPE
/// measures it.
[[nodiscard]] bool starts_observed(const config::DeviceOptions& device);

/// Throws config::ConfigError when an arm's `device:` has a type that does not exist, a plug-in that cannot be used, or
/// a key or value that its type refuses. Two devices of one host must not listen on the same port, and two arms must
/// not have one controller. Call it before anything starts.
void require_known_devices(const config::CellFile& file,
                           std::span<const device::DeviceType> types = device::device_types());

/// What a person should know of the arms' devices, a sentence each, for `hecaton check`.
[[nodiscard]] std::vector<std::string> device_notes(const config::CellFile& file,
                                                    std::span<const device::DeviceType> types = device::device_types());

/// What a person does after `hecaton up` until all arms follow, a command of a shell or a comment each.
[[nodiscard]] std::vector<std::string> device_steps(const config::CellFile& file,
                                                    std::span<const device::DeviceType> types = device::device_types());

/// How each arm follows set-points in a simulation of the cell: as its device of type `simulated` says; perfectly when
/// it has another one. Throws as make_device().
[[nodiscard]] std::vector<planner::ServoParameters> simulated_servos(const config::CellFile& file);

/// Of each arm: its controller stops it when its driver's process or host fails, see DeviceType::goes_on. False of an
/// observed arm, of a plug-in, which is not loaded, and where require_known_devices() refuses the device.
[[nodiscard]] std::vector<bool> stop_without_driver(const config::CellFile& file,
                                                    std::span<const device::DeviceType> types = device::device_types());

/// The kinds of the arm's signals, in their order. Throws ConfigError for a port that the device does not have.
[[nodiscard]] std::vector<device::SignalKind> signal_kinds(
    const config::CellFile& file, int arm, std::span<const device::DeviceType> types = device::device_types());

/// The ports of its host on which the arm's device will listen. Throws as make_device().
[[nodiscard]] std::vector<device::ListeningPort> listening_ports(
    const config::CellFile& file, int arm, std::span<const device::DeviceType> types = device::device_types());

/// Creates the arm's device. `arm`: index in the cell. `checkpoint`: a file that the device may use to survive its
/// process; empty: none. Throws std::runtime_error with a sentence when a value cannot be used.
[[nodiscard]] std::unique_ptr<device::ArmDevice> make_device(const config::CellFile& file, int arm,
                                                             const std::string& checkpoint,
                                                             std::span<const device::DeviceType> types,
                                                             const device::DeviceLog& log = {},
                                                             const device::JoinCell& join = {});

}  // namespace hecaton::services
