// A device plug-in with two types; neither moves anything.
#include <stdexcept>

#include "services/arm_driver/devices/plugin.hpp"

using namespace hecaton::device;

namespace {

class Nothing final : public ArmDevice {
 public:
  DeviceResult configure() override { return DeviceFailure{"moves nothing"}; }
  DeviceResult activate() override { return {}; }
  DeviceState read(Clock::time_point /*now*/) override { return {}; }
  DeviceResult write(const JointState& /*set_point*/, std::chrono::nanoseconds /*valid_for*/) override { return {}; }
  void stop(std::string_view /*reason*/) override {}
  void deactivate() override {}
};

std::unique_ptr<ArmDevice> make_nothing(const DeviceSetup& setup) {
  const auto port = setup.values.find("port");
  if (port == setup.values.end() || setup.values.size() != 1)
    throw std::runtime_error(setup.where + ".port is missing");
  return std::make_unique<Nothing>();
}

}  // namespace

HECATON_DEVICE_PLUGIN({"serial", {"port"}, make_nothing}, {"can_bus", {"port"}, make_nothing})
