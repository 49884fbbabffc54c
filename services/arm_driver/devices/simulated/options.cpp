#include "services/arm_driver/devices/simulated/options.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>

#include "services/arm_driver/devices/option_reader.hpp"

namespace hecaton::device {
namespace {

planner::ServoParameters preset(const OptionReader& reader) {
  const auto name = reader.text("servo");
  if (!name) return {};
  std::string names;
  for (const planner::ServoPreset& preset : planner::servo_presets()) {
    if (preset.name == *name) return preset.servo;
    names += (names.empty() ? "" : ", ") + std::string(preset.name);
  }
  reader.fail("servo", *name, "one of " + names);
}

}  // namespace

SimulatedOptions read_simulated_options(const DeviceSetup& setup) {
  const OptionReader reader(setup);
  SimulatedOptions options{preset(reader)};
  planner::ServoParameters& servo = options.servo;
  servo.period = reader.number("servo_period", servo.period, 0.0, 0.1, "s");
  servo.dead_time = reader.number("dead_time", servo.dead_time, 0.0, 0.3, "s");
  servo.jitter = reader.number("jitter", std::min(servo.jitter, servo.dead_time), 0.0, servo.dead_time, "s");
  servo.lag = reader.number("lag", servo.lag, 0.0, 0.2, "s");
  servo.damping = reader.number("damping", servo.damping, 0.0, 0.99);
  servo.noise = reader.number("noise", servo.noise, 0.0, 0.01);
  servo.resolution = reader.number("resolution", servo.resolution, 0.0, 0.01);
  options.protective_speed = reader.number("protective_speed", 0.0, 0.0, 1000.0);
  options.protective_effort = reader.number("protective_effort", 0.0, 0.0, 10.0);
  if (options.protective_effort > 0.0 && !setup.forces.of_motion) {
    throw std::runtime_error(setup.where + ".protective_effort needs masses and effort limits, but " +
                             setup.forces.reason + ": complete it, or leave the key out");
  }
  return options;
}

}  // namespace hecaton::device
