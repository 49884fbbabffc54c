#include "services/arm_driver/devices/universal_robots/options.hpp"

#include <algorithm>
#include <stdexcept>

#include "services/arm_driver/devices/option_reader.hpp"
#include "services/arm_driver/devices/universal_robots/robot_type.hpp"

namespace hecaton::device::universal_robots {
namespace {

constexpr int kUrJoints = 6;
constexpr int kFirstReversePort = 50001;

}  // namespace

Options read_options(const DeviceSetup& setup) {
  const OptionReader reader(setup);
  if (setup.limits.lower.size() != kUrJoints) {
    reader.fail(
        "type", "universal_robots",
        "of an arm with six joints, but arm " + setup.arm + " has " + std::to_string(setup.limits.lower.size()));
  }
  Options options;
  const auto robot = reader.address("robot_ip");
  if (!robot) throw std::runtime_error(setup.where + ".robot_ip is missing; it must be the IPv4 address of the robot");
  options.robot_ip = *robot;
  options.command_timeout = setup.command_timeout;
  options.pc_ip = reader.address("pc_ip");
  options.reverse_port = reader.whole_number("reverse_port", kFirstReversePort + setup.index, 1024, 65535);
  const double period = std::chrono::duration<double>(setup.period).count();
  const double timeout = std::chrono::duration<double>(setup.command_timeout).count();
  options.timeout = std::chrono::round<std::chrono::nanoseconds>(
      std::chrono::duration<double>(reader.number("timeout", std::min(1.0, timeout), 2.0 * period, 1.0, "s")));
  options.lookahead_time = reader.number("lookahead_time", options.lookahead_time, 0.03, 0.2, "s");
  options.gain = reader.number("gain", options.gain, 100, 2000);
  options.tracking_delay = reader.number("tracking_delay", options.lookahead_time, 0.0, 0.5, "s");
  if (reader.text("speed_slider")) options.speed_slider = reader.number("speed_slider", 1.0, 0.01, 1.0);
  options.model = reader.text("model");
  if (options.model && !is_robot_type(*options.model)) reader.fail("model", *options.model, robot_types());
  if (!options.model) options.model = mentioned_type(setup.robot_names);
  return options;
}

}  // namespace hecaton::device::universal_robots
