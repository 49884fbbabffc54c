#include "services/arm_driver/devices/abb_egm/abb_egm_arm.hpp"
#include "services/arm_driver/devices/arm_device.hpp"
#include "services/arm_driver/devices/program/program_arm.hpp"
#include "services/arm_driver/devices/ros2_control/ros2_control_arm.hpp"
#include "services/arm_driver/devices/simulated/options.hpp"
#include "services/arm_driver/devices/simulated/simulated_arm.hpp"
#include "services/arm_driver/devices/universal_robots/universal_robots_arm.hpp"

namespace hecaton::device {

const std::vector<DeviceType>& device_types() {
  static const std::vector<DeviceType> types = {
      {"simulated",
       kSimulatedKeys,
       make_simulated_arm,
       nullptr,
       nullptr,
       {},
       nullptr,
       simulated_signal,
       kSimulatedPorts,
       true},
      {"universal_robots",
       kUniversalRobotsKeys,
       make_universal_robots_arm,
       universal_robots_ports,
       universal_robots_notes,
       {"hecaton device ARM on", "hecaton resume ARM", "# the real arm ARM moves now: stand at its emergency stop"},
       universal_robots_claims,
       universal_robots_signal,
       kUniversalRobotsPorts},
      {"abb_egm",
       kAbbEgmKeys,
       make_abb_egm_arm,
       abb_egm_ports,
       abb_egm_notes,
       {"# at the FlexPendant of ARM: switch the motors on and start the RAPID program", "hecaton resume ARM",
        "# the real arm ARM moves now: stand at its emergency stop"}},
      {"ros2_control",
       ros2_control::kKeys,
       make_ros2_control_arm,
       nullptr,
       ros2_control_notes,
       {"# on the machine of ARM: start its driver of ros2_control and activate the controller", "hecaton resume ARM",
        "# the real arm ARM moves now: stand at its emergency stop"},
       ros2_control_claims,
       nullptr,
       {},
       true,
       ros2_control_goes_on},
      {"program",
       {},
       make_program_arm,
       nullptr,
       program_notes,
       {"# start the program of ARM", "hecaton resume ARM",
        "# the real arm ARM moves now: stand at its emergency stop"}},
  };
  return types;
}

}  // namespace hecaton::device
