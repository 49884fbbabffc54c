#include "services/arm_driver/devices/arm_device.hpp"
#include "services/arm_driver/devices/simulated/simulated_arm.hpp"

namespace hecaton::device {

const std::vector<DeviceType>& device_types() {
  static const std::vector<DeviceType> types = {
      {"simulated", {}, make_simulated_arm},
  };
  return types;
}

}  // namespace hecaton::device
