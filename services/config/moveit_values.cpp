#include "services/config/moveit_values.hpp"

#include <array>
#include <cmath>

#include "services/config/fields.hpp"
#include "services/config/text.hpp"

namespace hecaton::config::moveit {
namespace {

constexpr std::size_t kMostKeys = 1000;
/// Of a quaternion's length from 1: files round.
constexpr double kUnit = 1e-3;
/// Of a pose that is to be the origin.
constexpr double kSame = 1e-9;

constexpr std::array<std::string_view, 4> kStateKeys = {"joint_state", "multi_dof_joint_state",
                                                        "attached_collision_objects", "is_diff"};
constexpr std::array<std::string_view, 5> kJointKeys = {"header", "name", "position", "velocity", "effort"};
constexpr std::array<std::string_view, 5> kMultiKeys = {"header", "joint_names", "transforms", "twist", "wrench"};
constexpr std::array<std::string_view, 2> kTransformKeys = {"translation", "rotation"};

/// A list of them, or a map of the names.
std::vector<double> components(const YamlView& view, std::span<const std::string_view> names, const Bounds& bounds,
                               std::string_view of) {
  std::vector<double> result;
  if (view.is_map()) {
    check_keys(view, names);
    for (const std::string_view name : names) result.push_back(required(view, name).number(bounds));
  } else {
    for (const YamlView& item : view.items(names.size(), names.size(), of)) result.push_back(item.number(bounds));
  }
  return result;
}

void check_base(const YamlView& transform) {
  check_keys(transform, kTransformKeys);
  const YamlView translation = required(transform, "translation");
  const YamlView rotation = required(transform, "rotation");
  const std::string where = "what the robot's root is at: a base that stands elsewhere is not read";
  if (position(translation).norm() > kSame) translation.fail("[0, 0, 0], " + where);
  if (orientation(rotation).vec().norm() > kSame) rotation.fail("[0, 0, 0, 1], " + where);
}

}  // namespace

YamlView required(const YamlView& map, std::string_view key) {
  const auto found = map.entry(key);
  if (!found) map.fail_with("has no key '" + std::string(key) + "'");
  return *found;
}

void check_keys(const YamlView& map, std::span<const std::string_view> keys) {
  if (!is_given(map)) return;
  const Section section{"", keys};
  static_cast<void>(map.map(section));
}

bool is_given(const YamlView& view) {
  if (view.is_sequence()) return !view.items(0, std::size_t(-1), "items").empty();
  if (!view.is_map()) return !view.is_empty();
  for (const auto& [key, item] : view.named_items(kMostKeys)) {
    if (is_given(item)) return true;
  }
  return false;
}

std::string text_if_given(const YamlView& map, std::string_view key) {
  const auto found = map.entry(key);
  return found && is_given(*found) ? found->text() : std::string();
}

void refuse_diff(const YamlView& map, const std::string& what) {
  const auto diff = map.entry("is_diff");
  if (!diff || !diff->boolean()) return;
  diff->fail("false: what this " + what + " is different from is not known");
}

void refuse_given(const YamlView& map, std::initializer_list<std::string_view> keys, std::string_view which) {
  for (const std::string_view key : keys) {
    const auto found = map.entry(key);
    if (found && is_given(*found)) {
      map.fail_with("has " + std::string(key) + " = " + found->value() + ", which " + std::string(which));
    }
  }
}

Eigen::Vector3d position(const YamlView& view) {
  constexpr std::array<std::string_view, 3> kNames = {"x", "y", "z"};
  const auto p = components(view, kNames, kCoordinate, "numbers [x, y, z] in m");
  return {p[0], p[1], p[2]};
}

Eigen::Quaterniond orientation(const YamlView& view) {
  constexpr std::array<std::string_view, 4> kNames = {"x", "y", "z", "w"};
  const auto q = components(view, kNames, {-2.0, 2.0, ""}, "numbers [x, y, z, w]");
  const Eigen::Quaterniond turn(q[3], q[0], q[1], q[2]);
  if (std::abs(turn.norm() - 1.0) > kUnit) view.fail("a quaternion x, y, z, w of length 1");
  return turn.normalized();
}

world::Pose pose(const YamlView& view) {
  constexpr std::array<std::string_view, 2> kKeys = {"position", "orientation"};
  check_keys(view, kKeys);
  world::Pose result = world::Pose::Identity();
  result.translation() = position(required(view, "position"));
  result.linear() = orientation(required(view, "orientation")).toRotationMatrix();
  return result;
}

std::map<std::string, double> robot_state(const YamlView& view) {
  check_keys(view, kStateKeys);
  refuse_diff(view, "state");
  refuse_given(view, {"attached_collision_objects"}, "is not read: give it to an arm of a cell file as an obstacle");
  if (const auto multi = view.entry("multi_dof_joint_state"); multi && is_given(*multi)) {
    check_keys(*multi, kMultiKeys);
    if (const auto transforms = multi->entry("transforms"); transforms && is_given(*transforms)) {
      for (const YamlView& transform : transforms->items(0, kMost, "transforms")) check_base(transform);
    }
  }
  const YamlView joints = required(view, "joint_state");
  check_keys(joints, kJointKeys);
  std::map<std::string, double> result;
  const auto names = required(joints, "name").items(0, kMost, "joint names");
  const YamlView positions = required(joints, "position");
  const auto values = positions.items(names.size(), names.size(), "numbers, one for each name");
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (!result.emplace(names[i].text(), values[i].number(kAngle)).second) names[i].fail("a joint that is named once");
  }
  if (const auto rates = joints.entry("velocity"); rates && is_given(*rates)) {
    constexpr Bounds kRest{0.0, 0.0, "rad/s: plans begin at rest"};
    for (const YamlView& rate : rates->items(0, kMost, "numbers")) static_cast<void>(rate.number(kRest));
  }
  return result;
}

std::string note_of(const YamlView& map, std::initializer_list<std::string_view> keys, std::string_view why) {
  std::string given;
  int count = 0;
  for (const std::string_view key : keys) {
    const auto found = map.entry(key);
    if (!found || !is_given(*found)) continue;
    given += (count++ > 0 ? ", " : "") + std::string(key);
  }
  if (count == 0) return {};
  return map.file() + ": " + (map.path().empty() ? "" : map.path() + ": ") + given +
         (count > 1 ? " are not read: " : " is not read: ") + std::string(why);
}

}  // namespace hecaton::config::moveit
