#include "services/arm_driver/devices/ros2_control/options.hpp"

#include <algorithm>
#include <set>
#include <stdexcept>

#include "services/arm_driver/devices/option_reader.hpp"

namespace hecaton::device::ros2_control {
namespace {

/// The domains that ROS 2 can use on each machine.
constexpr int kLastDomain = 199;
constexpr double kUsualLookahead = 0.1;  // [s]
/// Each goal of an action needs an answer, and some servers keep ended goals for minutes: fewer goals [s].
constexpr double kActionLookahead = 0.2;
constexpr double kUsualEffort = 10.0;  // [N | N m]
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
  if (text == "velocity") return Interface::kVelocity;
  if (text == "action") return Interface::kAction;
  if (text != "trajectory") reader.fail("interface", text, "position, velocity, trajectory or action");
  return Interface::kTrajectory;
}

std::string usual_controller(Interface interface) {
  if (interface == Interface::kPosition) return "forward_position_controller";
  return interface == Interface::kVelocity ? "forward_velocity_controller" : "joint_trajectory_controller";
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

/// The fingers of the gripper, as the robot description names them.
std::vector<std::string> finger_names(const DeviceSetup& setup) {
  std::vector<std::string> names;
  for (std::size_t joint = 0; joint < setup.outside_names.size(); ++joint) {
    if (setup.fingers[joint]) names.push_back(setup.outside_names[joint]);
  }
  return names;
}

std::optional<GripperOptions> read_gripper(const DeviceSetup& setup, const OptionReader& reader, int domain,
                                           const std::string& ns) {
  GripperOptions gripper;
  gripper.domain = domain;
  gripper.joints = finger_names(setup);
  const std::size_t count = gripper.joints.size();
  const auto controller = reader.text("gripper_controller");
  if (count == 0 || !controller) {
    if (count > 0) {
      throw std::runtime_error(setup.where +
                               ".gripper_controller is missing: the name of the controller in ROS 2 that moves the "
                               "gripper of arm " +
                               setup.arm);
    }
    for (const std::string_view key : {"gripper_controller", "gripper_interface", "gripper_joints", "gripper_effort"}) {
      if (const auto given = reader.text(key)) {
        reader.fail(key, *given, "absent: arm " + setup.arm + " has no key gripper with a joint");
      }
    }
    return std::nullopt;
  }
  gripper.controller = name_of(reader, "gripper_controller", "gripper_controller", ns);
  const std::string interface = reader.text("gripper_interface").value_or("action");
  if (interface != "action" && interface != "position") {
    reader.fail("gripper_interface", interface, "action or position");
  }
  gripper.action = interface == "action";
  if (const auto given = reader.text("gripper_joints")) {
    gripper.joints = listed(*given);
    if (gripper.joints.size() != count) {
      reader.fail("gripper_joints", *given,
                  std::to_string(count) + (count == 1 ? " name" : " names between commas") +
                      ", for the fingers of arm " + setup.arm);
    }
  } else if (const auto prefix = reader.text("joint_prefix")) {
    for (std::string& joint : gripper.joints) joint.insert(0, *prefix);
  }
  if (gripper.action) {
    gripper.effort = reader.number("gripper_effort", kUsualEffort, 0.0, 1e4, "N or N m");
  } else if (const auto effort = reader.text("gripper_effort")) {
    reader.fail("gripper_effort", *effort, "absent beside gripper_interface: position");
  }
  return gripper;
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
  options.controller = name_of(reader, "controller", usual_controller(options.interface), ns);
  options.joint_states = name_of(reader, "joint_states", "joint_states", ns);
  if (reader.text("speed_scaling")) {
    options.speed_scaling = name_of(reader, "speed_scaling", "speed_scaling_state_broadcaster/speed_scaling", ns);
  }
  options.joints = read_joints(setup, reader);
  if (has_trajectories(options.interface)) {
    options.lookahead = reader.number(
        "lookahead", options.interface == Interface::kAction ? kActionLookahead : kUsualLookahead, 0.02, 0.5, "s");
  } else if (const auto lookahead = reader.text("lookahead")) {
    reader.fail("lookahead", *lookahead, "absent beside interface: " + *reader.text("interface"));
  }
  options.tracking_delay = reader.number("tracking_delay", options.lookahead + kUsualServo, 0.0, 1.0, "s");
  options.gripper = read_gripper(setup, reader, options.domain, ns);
  return options;
}

}  // namespace hecaton::device::ros2_control
