#include "services/arm_driver/control_setup.hpp"

#include "services/runtime/join.hpp"
#include "services/runtime/periodic_loop.hpp"

namespace hecaton::services {

// The driver sends a set-point in each of its periods. It is valid for a control period, as a planner's is, plus a
// driver period.
ArmControlSetup control_setup(const config::CellFile& file, int arm) {
  const planner::Timing& timing = file.cell.timing;
  const planner::Arm& planned = file.cell.arms[arm].arm;
  return {planned.name, planned.limits, timing.command_timeout, nanoseconds(timing.driver_period),
          nanoseconds(timing.control_period + timing.driver_period)};
}

std::unique_ptr<bus::Participant> join_as_device(const config::CellFile& file, const ServiceOptions& options) {
  return std::make_unique<bus::Participant>(make_participant(file, options, Role::kDriver, "device/" + options.arm));
}

}  // namespace hecaton::services
