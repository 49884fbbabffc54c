#pragma once
/// How the driver of an arm controls its device, from the cell file.

#include <memory>

#include "services/arm_driver/arm_control.hpp"
#include "services/bus/participant.hpp"
#include "services/config/cell_file.hpp"
#include "services/runtime/options.hpp"

namespace hecaton::services {

/// `arm`: index in the cell. The arm is neither latched nor observed.
[[nodiscard]] ArmControlSetup control_setup(const config::CellFile& file, int arm);

/// A participant for a device that uses topics. `options`: of the driver. Throws std::runtime_error with a sentence.
[[nodiscard]] std::unique_ptr<bus::Participant> join_as_device(const config::CellFile& file,
                                                               const ServiceOptions& options);

}  // namespace hecaton::services
