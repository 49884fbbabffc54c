#pragma once
/// A Universal Robots arm for tests: its description, and what a driver sets up.

#include <chrono>
#include <map>
#include <memory>
#include <string>

#include "planner/model/robot_model.hpp"
#include "planner/model/urdf_loader.hpp"
#include "services/arm_driver/devices/arm_device.hpp"

namespace hecaton::test {

inline constexpr std::chrono::milliseconds kUrPeriod{2};

/// Of a type of the catalogue, such as ur5e.
inline std::shared_ptr<const planner::RobotModel> ur_description(const std::string& type) {
  return planner::load_urdf(HECATON_SOURCE_DIR "/deploy/robots/" + type + ".urdf");
}

inline device::DeviceSetup ur_setup(const std::string& address, const std::map<std::string, std::string>& keys = {}) {
  device::DeviceSetup setup;
  setup.arm = "north";
  setup.limits.lower = device::JointVector::Constant(6, -6.28);
  setup.limits.upper = device::JointVector::Constant(6, 6.28);
  setup.limits.velocity = device::JointVector::Constant(6, 3.0);
  setup.limits.acceleration = device::JointVector::Constant(6, 10.0);
  setup.period = kUrPeriod;
  setup.command_timeout = std::chrono::seconds(10);
  setup.where = "cell.yaml: arms[0].device";
  // A busy machine may stop this process, or the robot's, for longer than the default time-outs.
  setup.values = {{"robot_ip", address}, {"timeout", "0.3"}};
  for (const auto& [key, value] : keys) setup.values[key] = value;
  return setup;
}

}  // namespace hecaton::test
