#pragma once
/// How a shared library offers its kinds of devices: docs/how-to/add-a-device.md. One source of the library has
///
///     HECATON_DEVICE_PLUGIN({"serial", {"port"}, make_serial_arm})
///
/// with one or several values of DeviceType, in namespace scope.

#include <cstddef>
#include <string>
#include <vector>

#include "services/arm_driver/devices/arm_device.hpp"

namespace hecaton::device {

/// Of this header and arm_device.hpp. It grows with each change of what programs and plug-ins share.
inline constexpr int kPluginInterface = 7;

/// Two objects of code can share a device when these texts are equal: the interface, and what compilers and options may
/// change of its memory. Options such as -march=native change the alignment of Eigen's vectors. Hidden, so that a
/// library has its own.
[[nodiscard]] __attribute__((visibility("hidden"))) inline std::string plugin_interface() {
  const auto size = [](const char* name, std::size_t bytes, std::size_t alignment) {
    return std::string(", ") + name + " " + std::to_string(bytes) + "/" + std::to_string(alignment);
  };
  return "interface " + std::to_string(kPluginInterface) + ", Eigen " + std::to_string(EIGEN_WORLD_VERSION) + "." +
         std::to_string(EIGEN_MAJOR_VERSION) + "." + std::to_string(EIGEN_MINOR_VERSION) +
         size("vector", sizeof(JointVector), alignof(JointVector)) +
         size("state", sizeof(DeviceState), alignof(DeviceState)) +
         size("setup", sizeof(DeviceSetup), alignof(DeviceSetup)) +
         size("type", sizeof(DeviceType), alignof(DeviceType));
}

}  // namespace hecaton::device

// The first function has C types only, so that programs can call it whatever the library was built with.
#define HECATON_DEVICE_PLUGIN(...)                                                                  \
  extern "C" __attribute__((visibility("default"))) const char* hecaton_device_plugin_interface() { \
    static const std::string text = hecaton::device::plugin_interface();                            \
    return text.c_str();                                                                            \
  }                                                                                                 \
  extern "C" __attribute__((visibility("default"))) void hecaton_device_plugin_types(               \
      std::vector<hecaton::device::DeviceType>& types) {                                            \
    types.insert(types.end(), {__VA_ARGS__});                                                       \
  }
