#include "services/arm_driver/arm_driver.hpp"

int main(int argc, char** argv) {
  return hecaton::services::run_arm_driver(argc, argv, hecaton::device::device_types());
}
