// hecaton-arm-driver with an additional device type.
#include "examples/device/serial_arm.hpp"
#include "services/arm_driver/arm_driver.hpp"

int main(int argc, char** argv) {
  auto types = hecaton::device::device_types();
  types.push_back({"serial", {"port"}, make_serial_arm});  // registers the type
  return hecaton::services::run_arm_driver(argc, argv, types);
}
