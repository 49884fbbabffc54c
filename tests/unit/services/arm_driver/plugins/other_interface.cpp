// A device plug-in that was built against another release.
#include "services/arm_driver/devices/plugin.hpp"

extern "C" const char* hecaton_device_plugin_interface() {
  return "interface 0";
}
extern "C" void hecaton_device_plugin_types(std::vector<hecaton::device::DeviceType>& types) {
  types.clear();
}
