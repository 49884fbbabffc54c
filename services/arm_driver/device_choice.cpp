#include "services/arm_driver/device_choice.hpp"

#include <algorithm>
#include <chrono>
#include <map>
#include <stdexcept>
#include <utility>
#include <vector>

#include "planner/model/dynamics.hpp"
#include "planner/model/outside_joints.hpp"
#include "planner/model/robot_model.hpp"
#include "services/arm_driver/device_plugin.hpp"
#include "services/arm_driver/devices/simulated/options.hpp"
#include "services/config/text.hpp"

namespace hecaton::services {
namespace {

using config::ConfigError;

constexpr std::string_view kObserved = "observed";
constexpr std::string_view kSource = "source";
constexpr std::string_view kPlugin = "plugin";

/// The kind that `device:` of the arm names: of its plug-in, or else of `types`.
const device::DeviceType& type_of(const config::CellFile& file, int arm, std::span<const device::DeviceType> types) {
  const config::DeviceOptions& wanted = file.devices[arm];
  const auto plugin = wanted.values.find(kPlugin);
  if (plugin != wanted.values.end()) {
    types = load_device_plugin(plugin_file(plugin->second, file.path), wanted.where + ".plugin");
  }
  std::vector<std::string_view> names;
  for (const device::DeviceType& type : types) names.push_back(type.type);
  const bool observed = starts_observed(wanted);
  const auto source = wanted.values.find(kSource);
  if (observed && source == wanted.values.end()) {
    throw ConfigError(wanted.where + ".source is missing: the type of the device that measures the observed arm, " +
                      config::alternatives(names));
  }
  const std::string& name = observed ? source->second : wanted.type;
  const auto found = std::find_if(types.begin(), types.end(), [&](const auto& type) { return type.type == name; });
  if (found == types.end()) {
    if (!observed) names.push_back(kObserved);
    throw ConfigError(wanted.where + (observed ? ".source = " : ".type = ") + config::printable(name) + " must be " +
                      config::alternatives(names) +
                      (plugin == wanted.values.end()
                           ? ""
                           : ": its plug-in " + config::printable_path(plugin->second) + " has no other"));
  }
  std::vector<std::string_view> keys = {"type"};
  if (observed) keys.push_back(kSource);
  if (plugin != wanted.values.end()) keys.push_back(kPlugin);
  keys.insert(keys.end(), found->keys.begin(), found->keys.end());
  for (const auto& [key, value] : wanted.values) {
    if (std::find(keys.begin(), keys.end(), key) != keys.end()) continue;
    throw ConfigError(wanted.where + "." + config::printable(key) + " is not a known key; did you mean '" +
                      std::string(config::nearest_word(key, keys)) + "'? A device of type " + name + " may have " +
                      config::listed(keys));
  }
  return *found;
}

/// A gripper starts open. Other joints start where the model's shapes are in the middle.
void add_outside(const planner::Arm& arm, const std::optional<config::Gripper>& gripper, device::DeviceSetup& setup) {
  if (!arm.model->outside) return;
  for (const planner::OutsideJoint& joint : arm.model->outside->joints) {
    const bool finger =
        gripper && std::find(gripper->joints.begin(), gripper->joints.end(), joint.name) != gripper->joints.end();
    setup.outside_names.push_back(joint.name);
    setup.fingers.push_back(finger);
    setup.outside.push_back(finger ? gripper->opened : 0.5 * (joint.range.lower + joint.range.upper));
  }
  if (gripper) setup.outside_speed = gripper->speed;
}

device::DriveForces forces_of(const planner::Arm& arm) {
  device::DriveForces forces;
  forces.reason = planner::why_no_forces(*arm.model);
  if (!forces.reason.empty()) return forces;
  constexpr double kGravity = 9.80665;  // [m/s²]
  const Eigen::Vector3d gravity_B = arm.X_WB.linear().transpose() * Eigen::Vector3d(0.0, 0.0, -kGravity);
  forces.limits = arm.model->masses->effort;
  forces.of_motion = [model = arm.model, gravity_B](const auto& q, const auto& qd, const auto& qdd) {
    return planner::inverse_dynamics(*model, gravity_B, q, qd, qdd);
  };
  return forces;
}

/// Refuses what the type of a device does not have.
void check_gripper(const config::ToolOptions& tools, const std::vector<device::SignalKind>& kinds,
                   const device::DeviceType& type) {
  if (!tools.gripper) return;
  const config::Gripper& gripper = *tools.gripper;
  if (gripper.close.empty() && !type.moves_outside) {
    throw ConfigError(gripper.where + ".close and open are missing: a device of type " + std::string(type.type) +
                      " moves no fingers by itself; name the signals that close and open the gripper");
  }
  for (const config::SignalValues* values : {&gripper.close, &gripper.open}) {
    for (const auto& [name, value] : *values) {
      std::size_t index = 0;
      while (tools.signals[index].name != name) ++index;
      const device::SignalKind kind = kinds[index];
      const bool output = kind == device::SignalKind::kDigitalOutput || kind == device::SignalKind::kAnalogOutput;
      const bool fits = kind != device::SignalKind::kDigitalOutput || value == 0.0 || value == 1.0;
      if (output && fits) continue;
      throw ConfigError(gripper.where + (values == &gripper.close ? ".close." : ".open.") + name +
                        (output ? " must be 0 or 1: it is digital" : " must be an output, and not an input"));
    }
  }
}

device::DeviceSetup setup_of(const config::CellFile& file, int arm, const std::string& checkpoint) {
  const auto nanoseconds = [](double seconds) {
    return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::duration<double>(seconds));
  };
  const planner::PlannedArm& planned = file.cell.arms[arm];
  device::DeviceSetup setup;
  setup.arm = planned.arm.name;
  setup.index = arm;
  setup.limits = planned.arm.limits;
  setup.start = planned.start.size() > 0 ? planned.start : planned.arm.home();
  setup.period = nanoseconds(file.cell.timing.driver_period);
  setup.command_timeout = nanoseconds(file.cell.timing.command_timeout);
  setup.checkpoint = checkpoint;
  setup.where = file.devices[arm].where;
  setup.values = file.devices[arm].values;
  if (starts_observed(file.devices[arm])) setup.values.erase(std::string(kSource));
  setup.values.erase(std::string(kPlugin));
  setup.joint_names = planned.arm.model->joint_names;
  setup.model = planned.arm.model;
  for (const config::SignalOptions& signal : file.tools[arm].signals) setup.signals.push_back(signal.port);
  add_outside(planned.arm, file.tools[arm].gripper, setup);
  setup.forces = forces_of(planned.arm);
  setup.robot_names = {planned.arm.model->name};
  for (const auto& [argument, value] : file.robots[arm].xacro_arguments) setup.robot_names.push_back(value);
  for (int joint = 0; joint < setup.limits.lower.size(); ++joint) {
    setup.prismatic.push_back(planner::joint_type(*planned.arm.model, joint) == planner::JointType::kPrismatic);
  }
  return setup;
}

/// The devices of one host cannot listen on the same port.
void require_own_ports(const config::CellFile& file, std::span<const device::DeviceType> types) {
  std::map<std::pair<std::string, int>, std::string> owners;
  for (int arm = 0; arm < static_cast<int>(file.devices.size()); ++arm) {
    for (const device::ListeningPort& port : listening_ports(file, arm, types)) {
      const std::string& name = file.cell.arms[arm].arm.name;
      const auto [owner, is_free] = owners.try_emplace({file.arm_hosts[arm].host, port.number}, name);
      if (is_free) continue;
      throw ConfigError(file.devices[arm].where + "." + port.key + " = " + std::to_string(port.number) +
                        " must be a port of its own: the device of arm " + owner->second + " on host " +
                        file.arm_hosts[arm].host + " listens on it");
    }
  }
}

/// Two drivers that command the same controller would move one arm against each other.
void require_own_claims(const config::CellFile& file, std::span<const device::DeviceType> types) {
  std::map<std::string, std::string> owners;
  for (int arm = 0; arm < static_cast<int>(file.devices.size()); ++arm) {
    const device::DeviceType& type = type_of(file, arm, types);
    if (type.claims == nullptr) continue;
    for (const device::Claim& claim : type.claims(setup_of(file, arm, {}))) {
      const std::string& name = file.cell.arms[arm].arm.name;
      const auto [owner, is_free] = owners.try_emplace(claim.what, name);
      if (is_free) continue;
      throw ConfigError(file.devices[arm].where + "." + claim.key + " must be another one: " + claim.what +
                        " moves arm " + owner->second + " already");
    }
  }
}

}  // namespace

bool starts_observed(const config::DeviceOptions& device) {
  return device.type == kObserved;
}

void require_known_devices(const config::CellFile& file, std::span<const device::DeviceType> types) {
  // Each device is created once, because its factory checks the values of its keys. It opens nothing yet.
  try {
    for (int arm = 0; arm < static_cast<int>(file.devices.size()); ++arm) {
      (void)make_device(file, arm, {}, types);
      check_gripper(file.tools[arm], signal_kinds(file, arm, types), type_of(file, arm, types));
    }
    require_own_ports(file, types);
    require_own_claims(file, types);
  } catch (const std::runtime_error& error) {
    throw ConfigError(error.what());
  }
}

std::vector<std::string> device_notes(const config::CellFile& file, std::span<const device::DeviceType> types) {
  std::vector<std::string> notes;
  for (int arm = 0; arm < static_cast<int>(file.devices.size()); ++arm) {
    const device::DeviceType& type = type_of(file, arm, types);
    if (type.notes == nullptr) continue;
    for (std::string& note : type.notes(setup_of(file, arm, {}), *file.cell.arms[arm].arm.model)) {
      notes.push_back(std::move(note));
    }
  }
  return notes;
}

std::vector<std::string> device_steps(const config::CellFile& file, std::span<const device::DeviceType> types) {
  constexpr std::string_view kArm = "ARM";
  std::vector<std::string> steps;
  for (int arm = 0; arm < static_cast<int>(file.devices.size()); ++arm) {
    if (starts_observed(file.devices[arm])) continue;
    for (const std::string_view step : type_of(file, arm, types).steps) {
      std::string& own = steps.emplace_back(step);
      const std::size_t place = own.find(kArm);
      if (place != std::string::npos) own.replace(place, kArm.size(), file.cell.arms[arm].arm.name);
    }
  }
  return steps;
}

std::vector<planner::ServoParameters> simulated_servos(const config::CellFile& file) {
  std::vector<planner::ServoParameters> servos(file.devices.size());
  for (int arm = 0; arm < static_cast<int>(file.devices.size()); ++arm) {
    if (file.devices[arm].type != "simulated" || file.devices[arm].values.contains(kPlugin)) continue;
    servos[arm] = device::read_simulated_options(setup_of(file, arm, {})).servo;
  }
  return servos;
}

std::vector<bool> stop_without_driver(const config::CellFile& file, std::span<const device::DeviceType> types) {
  std::vector<bool> stop(file.devices.size(), false);
  for (int arm = 0; arm < static_cast<int>(stop.size()); ++arm) {
    const config::DeviceOptions& wanted = file.devices[arm];
    if (starts_observed(wanted) || wanted.values.contains(kPlugin)) continue;
    try {
      const device::DeviceType& type = type_of(file, arm, types);
      stop[arm] = type.goes_on == nullptr || !type.goes_on(setup_of(file, arm, {}));
    } catch (const std::runtime_error&) {  // the driver says why it cannot start
    }
  }
  return stop;
}

std::vector<device::SignalKind> signal_kinds(const config::CellFile& file, int arm,
                                             std::span<const device::DeviceType> types) {
  std::vector<device::SignalKind> kinds;
  const device::DeviceType& type = type_of(file, arm, types);
  for (const config::SignalOptions& signal : file.tools[arm].signals) {
    if (type.signal == nullptr) {
      throw ConfigError(signal.where + ": a device of type " + std::string(type.type) + " has no signals");
    }
    const auto kind = type.signal(signal.port);
    if (!kind) {
      throw ConfigError(signal.where + " = " + config::printable(signal.port) + " must be " +
                        std::string(type.signal_ports));
    }
    kinds.push_back(*kind);
  }
  return kinds;
}

std::vector<device::ListeningPort> listening_ports(const config::CellFile& file, int arm,
                                                   std::span<const device::DeviceType> types) {
  const device::DeviceType& type = type_of(file, arm, types);
  return type.ports == nullptr ? std::vector<device::ListeningPort>() : type.ports(setup_of(file, arm, {}));
}

std::unique_ptr<device::ArmDevice> make_device(const config::CellFile& file, int arm, const std::string& checkpoint,
                                               std::span<const device::DeviceType> types, const device::DeviceLog& log,
                                               const device::JoinCell& join) {
  device::DeviceSetup setup = setup_of(file, arm, checkpoint);
  setup.log = log;
  setup.join = join;
  return type_of(file, arm, types).make(setup);
}

}  // namespace hecaton::services
