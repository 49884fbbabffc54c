#include "services/arm_driver/device_choice.hpp"

#include <algorithm>
#include <vector>

#include "services/config/text.hpp"

namespace hecaton::services {
namespace {

using config::ConfigError;

const device::DeviceType& type_of(const config::DeviceOptions& wanted, std::span<const device::DeviceType> types) {
  const auto found =
      std::find_if(types.begin(), types.end(), [&](const auto& type) { return type.type == wanted.type; });
  if (found == types.end()) {
    std::vector<std::string_view> names;
    for (const device::DeviceType& type : types) names.push_back(type.type);
    throw ConfigError(wanted.where + ".type = " + config::printable(wanted.type) + " must be " +
                      config::alternatives(names));
  }
  std::vector<std::string_view> keys = {"type"};
  keys.insert(keys.end(), found->keys.begin(), found->keys.end());
  for (const auto& [key, value] : wanted.values) {
    if (std::find(keys.begin(), keys.end(), key) != keys.end()) continue;
    throw ConfigError(wanted.where + "." + config::printable(key) + " is not a known key; did you mean '" +
                      std::string(config::nearest_word(key, keys)) + "'? A device of type " + wanted.type +
                      " may have " + config::listed(keys));
  }
  return *found;
}

}  // namespace

void require_known_devices(const config::CellFile& file, std::span<const device::DeviceType> types) {
  for (const config::DeviceOptions& wanted : file.devices) (void)type_of(wanted, types);
}

std::unique_ptr<device::ArmDevice> make_device(const config::CellFile& file, int arm, const std::string& checkpoint,
                                               std::span<const device::DeviceType> types) {
  const planner::PlannedArm& planned = file.cell.arms[arm];
  device::DeviceSetup setup;
  setup.arm = planned.arm.name;
  setup.limits = planned.arm.limits;
  setup.start = planned.start.size() > 0 ? planned.start : planned.arm.home();
  setup.period = std::chrono::duration_cast<std::chrono::nanoseconds>(
      std::chrono::duration<double>(file.cell.timing.driver_period));
  setup.checkpoint = checkpoint;
  setup.where = file.devices[arm].where;
  setup.values = file.devices[arm].values;
  return type_of(file.devices[arm], types).make(setup);
}

}  // namespace hecaton::services
