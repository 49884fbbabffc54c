// What a controller of Universal Robots sends on its primary port, as the driver takes it: package after package.

#include <cmath>

#include "services/arm_driver/devices/universal_robots/primary.hpp"
#include "tests/fuzz/fuzz.hpp"

extern "C" int HECATON_FUZZ_TARGET(ur_primary)(const std::uint8_t* data, std::size_t size) {
  using namespace hecaton;
  using namespace hecaton::device::universal_robots;
  const std::string bytes(reinterpret_cast<const char*>(data), size);
  std::string_view left = bytes;
  while (true) {
    const PrimaryPackage next = next_primary_package(left);
    fuzz::require(next.size <= left.size(), "a package ends within its bytes");
    fuzz::require(next.size == 0 || next.broken.empty(), "what is broken is no package");
    if (!next.broken.empty()) fuzz::require_sentence(next.broken);
    if (next.kinematics) {
      for (const auto& values :
           {next.kinematics->theta, next.kinematics->a, next.kinematics->d, next.kinematics->alpha}) {
        for (const double value : values) fuzz::require(std::isfinite(value), "parameters are finite");
      }
    }
    if (next.size == 0) return 0;
    left.remove_prefix(next.size);
  }
}
