/// `signals` and `gripper` of an arm.

#include <algorithm>

#include "planner/model/outside_joints.hpp"
#include "services/config/readers.hpp"
#include "services/config/text.hpp"

namespace hecaton::config {
namespace {

constexpr std::size_t kMostSignals = 64;
constexpr std::size_t kMostFingers = planner::kMaxJoints;
constexpr Bounds kSignalValue{-1e3, 1e3, "(0 or 1 for a digital signal)"};

std::vector<SignalOptions> read_signals(const ArmView& arm) {
  std::vector<SignalOptions> signals;
  const auto map = arm.find("signals");
  if (!map) return signals;
  for (const auto& [name, port] : map->named_items(kMostSignals)) {
    signals.push_back({name, port.text(), port.file() + ": " + port.path()});
  }
  std::sort(signals.begin(), signals.end(), [](const auto& a, const auto& b) { return a.name < b.name; });
  return signals;
}

/// A joint outside the chain whose links are fixed to the tool's body.
std::string read_finger(const YamlView& view, const planner::RobotModel& model) {
  const std::string name = view.text();
  std::vector<std::string_view> names;
  if (model.outside) {
    for (const planner::OutsideJoint& joint : model.outside->joints) {
      if (!joint.of_tool) continue;
      if (joint.name == name) return name;
      names.push_back(joint.name);
    }
  }
  if (names.empty()) {
    view.fail("a joint that moves links at the tool: give its range with joints: {" + name + ": [LOWEST, HIGHEST]}");
  }
  view.fail("a joint that moves links at the tool and has a range in joints: " + alternatives(names));
}

std::vector<std::string> read_fingers(const YamlView& view, const planner::RobotModel& model) {
  if (!view.is_sequence()) return {read_finger(view, model)};
  std::vector<std::string> joints;
  for (const YamlView& item : view.items(1, kMostFingers, "joints")) joints.push_back(read_finger(item, model));
  return joints;
}

/// A position within the ranges of all fingers.
double read_position(const YamlView& view, const Gripper& gripper, const planner::RobotModel& model) {
  double lower = -1e6;
  double upper = 1e6;
  for (const planner::OutsideJoint& joint : model.outside->joints) {
    if (std::find(gripper.joints.begin(), gripper.joints.end(), joint.name) == gripper.joints.end()) continue;
    lower = std::max(lower, joint.range.lower);
    upper = std::min(upper, joint.range.upper);
  }
  return view.number({lower, upper, "rad or m, within the range of the joint"});
}

SignalValues read_values(const MapView& map, std::string_view key, const std::vector<SignalOptions>& signals) {
  SignalValues values;
  const auto view = map.find(key);
  if (!view) return values;
  std::vector<std::string_view> names;
  for (const SignalOptions& signal : signals) names.push_back(signal.name);
  for (const auto& [name, value] : view->named_items(kMostSignals)) {
    if (std::find(names.begin(), names.end(), name) == names.end()) {
      value.fail_with(names.empty() ? "the arm has no signals" : "the arm has the signals " + alternatives(names));
    }
    values[name] = value.number(kSignalValue);
  }
  return values;
}

Gripper read_gripper(const YamlView& view, const planner::RobotModel& model,
                     const std::vector<SignalOptions>& signals) {
  const MapView map = view.map(section::kGripper);
  Gripper gripper;
  gripper.where = view.file() + ": " + view.path();
  if (const auto joint = map.find("joint")) {
    gripper.joints = read_fingers(*joint, model);
    gripper.closed = read_position(map.at("closed"), gripper, model);
    gripper.opened = read_position(map.at("opened"), gripper, model);
    if (gripper.closed == gripper.opened) map.at("opened").fail("another position than closed");
  } else {
    for (const char* key : {"closed", "opened", "speed"}) {
      if (const auto given = map.find(key)) given->fail("left out, because joint is missing");
    }
  }
  read_number(map, "width", {0.0, 10.0, "m", true}, gripper.width);
  read_number(map, "speed", {0.0, 100.0, "m/s or rad/s", true}, gripper.speed);
  gripper.close = read_values(map, "close", signals);
  gripper.open = read_values(map, "open", signals);
  if (gripper.close.empty() != gripper.open.empty()) {
    map.fail_missing(gripper.close.empty() ? "close" : "open", "given, because the other one is");
  }
  if (gripper.joints.empty() && gripper.close.empty()) map.fail_missing("joint", "given, or close and open");
  double time = std::chrono::duration<double>(gripper.time).count();
  read_seconds(map, "time", {0.0, 60.0, "s"}, time);
  gripper.time = std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::duration<double>(time));
  return gripper;
}

}  // namespace

ToolOptions read_tools(const ArmView& arm, const planner::RobotModel& model) {
  ToolOptions tools;
  tools.signals = read_signals(arm);
  if (const auto view = arm.find("gripper")) tools.gripper = read_gripper(*view, model, tools.signals);
  return tools;
}

}  // namespace hecaton::config
