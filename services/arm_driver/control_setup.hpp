#pragma once
/// How the driver of an arm controls its device, from the cell file.

#include "services/arm_driver/arm_control.hpp"
#include "services/config/cell_file.hpp"

namespace hecaton::services {

/// `arm`: index in the cell. The arm is neither latched nor observed.
[[nodiscard]] ArmControlSetup control_setup(const config::CellFile& file, int arm);

}  // namespace hecaton::services
