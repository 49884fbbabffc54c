#include "services/arm_driver/devices/ros2_control/options.hpp"

#include <algorithm>
#include <set>

#include "services/arm_driver/devices/option_reader.hpp"

namespace hecaton::device::ros2_control {
namespace {

/// The domains that ROS 2 can use on each machine.
constexpr int kLastDomain = 199;
constexpr double kUsualLookahead = 0.1;  // [s]
/// Lag of a servo behind its position command [s].
constexpr double kUsualServo = 0.05;
constexpr std::size_t kLongestName = 200;

bool is_word(std::string_view text) {
  const auto letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; };
  return !text.empty() && letter(text.front()) &&
         std::all_of(text.begin(), text.end(), [&](char c) { return letter(c) || (c >= '0' && c <= '9'); });
}

/// Names of ROS 2: words with a slash between them; `absolute`: and one in front.
bool is_name(std::string_view text, bool absolute) {
  if (text.size() > kLongestName || text.starts_with('/') != absolute) return false;
  if (absolute) text.remove_prefix(1);
  for (std::size_t slash = 0; slash != std::string_view::npos;) {
    slash = text.find('/');
    if (!is_word(text.substr(0, slash))) return false;
    if (slash != std::string_view::npos) text.remove_prefix(slash + 1);
  }
  return true;
}

/// A name in the namespace, or one with a full name.
std::string name_of(const OptionReader& reader, std::string_view key, const std::string& otherwise,
                    const std::string& ns) {
  const std::string name = reader.text(key).value_or(otherwise);
  const bool absolute = name.starts_with('/');
  if (!is_name(name, absolute)) {
    reader.fail(key, name, "a name of ROS 2, such as " + otherwise + " or /left/" + otherwise);
  }
  return absolute ? name : ns + "/" + name;
}

Interface read_interface(const OptionReader& reader) {
  const std::string text = reader.text("interface").value_or("trajectory");
  if (text == "position") return Interface::kPosition;
  if (text == "velocity") {
    reader.fail("interface", text,
                "position or trajectory: when commands cease, a velocity controller goes on at its last velocity");
  }
  if (text != "trajectory") reader.fail("interface", text, "position or trajectory");
  return Interface::kTrajectory;
}

/// Names between commas or spaces.
std::vector<std::string> listed(std::string_view text) {
  std::vector<std::string> names;
  while (true) {
    const std::size_t begin = text.find_first_not_of(", ");
    if (begin == std::string_view::npos) return names;
    const std::size_t end = std::min(text.size(), text.find_first_of(", ", begin));
    names.emplace_back(text.substr(begin, end - begin));
    text.remove_prefix(end);
  }
}

std::vector<std::string> read_joints(const DeviceSetup& setup, const OptionReader& reader) {
  const auto given = reader.text("joints");
  const auto prefix = reader.text("joint_prefix");
  if (given && prefix) reader.fail("joint_prefix", *prefix, "absent beside the key joints");
  std::vector<std::string> joints = setup.joint_names;
  const auto count = static_cast<std::size_t>(setup.limits.lower.size());
  if (given) {
    joints = listed(*given);
    if (joints.size() != count || std::set(joints.begin(), joints.end()).size() != count) {
      reader.fail("joints", *given,
                  std::to_string(count) + " different names between commas, for the joints of arm " + setup.arm +
                      " from base to tip");
    }
  } else if (prefix) {
    for (std::string& joint : joints) joint.insert(0, *prefix);
  }
  return joints;
}

}  // namespace

Options read_options(const DeviceSetup& setup) {
  const OptionReader reader(setup);
  Options options;
  options.domain = reader.whole_number("domain", 0, 0, kLastDomain);
  options.address = reader.address("address");
  options.interface = read_interface(reader);
  const std::string ns = reader.text("namespace").value_or("");
  if (!ns.empty() && !is_name(ns, true)) reader.fail("namespace", ns, "a namespace of ROS 2, such as /left");
  const bool trajectory = options.interface == Interface::kTrajectory;
  const std::string usual = trajectory ? "joint_trajectory_controller" : "forward_position_controller";
  options.controller = name_of(reader, "controller", usual, ns);
  options.joint_states = name_of(reader, "joint_states", "joint_states", ns);
  if (reader.text("speed_scaling")) {
    options.speed_scaling = name_of(reader, "speed_scaling", "speed_scaling_state_broadcaster/speed_scaling", ns);
  }
  options.joints = read_joints(setup, reader);
  if (trajectory) {
    options.lookahead = reader.number("lookahead", kUsualLookahead, 0.02, 0.5, "s");
  } else if (const auto lookahead = reader.text("lookahead")) {
    reader.fail("lookahead", *lookahead, "absent beside interface: position");
  }
  options.tracking_delay = reader.number("tracking_delay", options.lookahead + kUsualServo, 0.0, 1.0, "s");
  return options;
}

}  // namespace hecaton::device::ros2_control
