#include "services/arm_driver/devices/abb_egm/options.hpp"

#include <algorithm>

#include "services/arm_driver/devices/option_reader.hpp"

namespace hecaton::device::abb_egm {
namespace {

constexpr Eigen::Index kRobotJoints = 6;
constexpr int kFirstPort = 6510;
/// Of the seventh joint of the YuMi, between its second and its third one, from 1.
constexpr int kUsualPlace = 3;
/// Filter and servo of a controller with the RAPID program of docs/how-to/abb-egm.md [s].
constexpr double kUsualDelay = 0.05;

// An additional axis may be linear, such as a track. The joints of the robot turn.
void require_robot(const DeviceSetup& setup, const Options& options, const OptionReader& reader) {
  for (std::size_t joint = 0; joint < setup.prismatic.size(); ++joint) {
    if (!setup.prismatic[joint] || options.external_axis == static_cast<Eigen::Index>(joint)) continue;
    reader.fail("type", "abb_egm",
                "of an arm whose joints turn, except its additional axis, but joint " + std::to_string(joint + 1) +
                    " of arm " + setup.arm + " is prismatic");
  }
}

}  // namespace

Options read_options(const DeviceSetup& setup) {
  const OptionReader reader(setup);
  const Eigen::Index joints = setup.limits.lower.size();
  if (joints != kRobotJoints && joints != kRobotJoints + 1) {
    reader.fail("type", "abb_egm",
                "of an arm with six or seven joints, but arm " + setup.arm + " has " + std::to_string(joints));
  }
  Options options;
  options.port = reader.whole_number("port", std::min(65535, kFirstPort + setup.index), 1024, 65535);
  options.robot_ip = reader.address("robot_ip");
  if (joints > kRobotJoints) {
    options.external_axis = reader.whole_number("external_axis", kUsualPlace, 1, static_cast<int>(joints)) - 1;
  } else if (const auto place = reader.text("external_axis")) {
    reader.fail("external_axis", *place, "of an arm with seven joints, but arm " + setup.arm + " has six");
  }
  options.tracking_delay = reader.number("tracking_delay", kUsualDelay, 0.0, 0.5, "s");
  require_robot(setup, options, reader);
  return options;
}

}  // namespace hecaton::device::abb_egm
