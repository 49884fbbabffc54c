#include "services/config/moveit_files.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <iterator>
#include <optional>
#include <set>
#include <string_view>

#include <tinyxml2.h>

#include "planner/model/xml_checks.hpp"
#include "services/config/text.hpp"
#include "services/config/yaml_view.hpp"

namespace hecaton::config {
namespace {

constexpr std::size_t kMostKeys = 1000;
constexpr std::size_t kMostItems = 10'000;  // of a list
constexpr double kUnit = 1e-3;              // deviation of a quaternion's length from 1, because files round
constexpr double kSame = 1e-9;              // deviation of a pose from the origin

/// The value of a key that must exist.
YamlView required(const YamlView& map, std::string_view key) {
  const auto found = map.entry(key);
  if (!found) map.fail_with("has no key '" + std::string(key) + "'");
  return *found;
}

/// False for an empty value, text or list, and for a map of only such values.
bool is_given(const YamlView& view) {
  if (view.is_sequence()) return !view.items(0, std::size_t(-1), "items").empty();
  if (!view.is_map()) return !view.is_empty();
  for (const auto& [key, item] : view.named_items(kMostKeys)) {
    if (is_given(item)) return true;
  }
  return false;
}

/// The value of a key if it is given.
std::optional<YamlView> given(const YamlView& map, std::string_view key) {
  auto found = map.entry(key);
  return found && is_given(*found) ? found : std::nullopt;
}

std::string text_if_given(const YamlView& map, std::string_view key) {
  const auto found = given(map, key);
  return found ? found->text() : std::string();
}

/// Refuses keys that the message does not have. An empty value may replace any message.
void check_keys(const YamlView& map, std::vector<std::string_view> keys) {
  if (!is_given(map)) return;
  const Section section{"", std::move(keys)};
  static_cast<void>(map.map(section));
}

/// Refuses is_diff = true; `what` names the message.
void refuse_diff(const YamlView& map, const std::string& what) {
  const auto diff = map.entry("is_diff");
  if (diff && diff->boolean()) diff->fail("false: the " + what + " that it differs from is not known");
}

/// Refuses keys that are given: "…: has KEY = VALUE, which …"; `which` ends the sentence.
void refuse_given(const YamlView& map, std::initializer_list<std::string_view> keys, std::string_view which) {
  for (const std::string_view key : keys) {
    if (const auto found = given(map, key)) {
      map.fail_with("has " + std::string(key) + " = " + found->value() + ", which " + std::string(which));
    }
  }
}

/// Adds "scene.yaml: a, b are not read: WHY" to `notes` if some of the keys are given.
void note_given(const YamlView& map, std::initializer_list<std::string_view> keys, std::string_view why,
                std::vector<std::string>& notes) {
  std::vector<std::string_view> found;
  std::copy_if(keys.begin(), keys.end(), std::back_inserter(found),
               [&](std::string_view key) { return given(map, key).has_value(); });
  if (found.empty()) return;
  notes.push_back(map.file() + ": " + (map.path().empty() ? "" : map.path() + ": ") + listed(found) +
                  (found.size() > 1 ? " are not read: " : " is not read: ") + std::string(why));
}

/// Numbers as a list, or as a map with `names` as keys.
std::vector<double> components(const YamlView& view, const std::vector<std::string_view>& names, const Bounds& bounds,
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

/// [m]
Eigen::Vector3d position(const YamlView& view) {
  const auto p = components(view, {"x", "y", "z"}, kCoordinate, "numbers [x, y, z] in m");
  return {p[0], p[1], p[2]};
}

/// A unit quaternion, as a list [x, y, z, w] or as a map.
Eigen::Quaterniond orientation(const YamlView& view) {
  const auto q = components(view, {"x", "y", "z", "w"}, {-2.0, 2.0, ""}, "numbers [x, y, z, w]");
  const Eigen::Quaterniond turn(q[3], q[0], q[1], q[2]);
  if (std::abs(turn.norm() - 1.0) > kUnit) view.fail("a quaternion x, y, z, w of length 1");
  return turn.normalized();
}

/// {position, orientation}
world::Pose pose(const YamlView& view) {
  check_keys(view, {"position", "orientation"});
  world::Pose result = world::Pose::Identity();
  result.translation() = position(required(view, "position"));
  result.linear() = orientation(required(view, "orientation")).toRotationMatrix();
  return result;
}

/// Refuses a transform {translation, rotation} other than the identity.
void require_identity(const YamlView& transform, const std::string& why) {
  const YamlView translation = required(transform, "translation");
  const YamlView rotation = required(transform, "rotation");
  if (position(translation).norm() > kSame) translation.fail("[0, 0, 0]: " + why);
  if (orientation(rotation).vec().norm() > kSame) rotation.fail("[0, 0, 0, 1]: " + why);
}

/// Joint positions of a RobotState at rest, by name [rad | m]. Refuses attached bodies, a base away from the origin,
/// and a state that is a difference, because the state that it refers to may carry an object.
std::map<std::string, double> robot_state(const YamlView& view) {
  check_keys(view, {"joint_state", "multi_dof_joint_state", "attached_collision_objects", "is_diff"});
  refuse_diff(view, "state");
  refuse_given(view, {"attached_collision_objects"}, "is not read: give it to an arm of a cell file as an obstacle");
  if (const auto multi = given(view, "multi_dof_joint_state")) {
    check_keys(*multi, {"header", "joint_names", "transforms", "twist", "wrench"});
    if (const auto transforms = given(*multi, "transforms")) {
      for (const YamlView& transform : transforms->items(0, kMostItems, "transforms")) {
        check_keys(transform, {"translation", "rotation"});
        require_identity(transform, "a base away from the robot's root is not read");
      }
    }
  }
  const YamlView joints = required(view, "joint_state");
  check_keys(joints, {"header", "name", "position", "velocity", "effort"});
  std::map<std::string, double> result;
  const auto names = required(joints, "name").items(0, kMostItems, "joint names");
  const auto values = required(joints, "position").items(names.size(), names.size(), "numbers, one for each name");
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (!result.emplace(names[i].text(), values[i].number(kAngle)).second) names[i].fail("a joint that is named once");
  }
  if (const auto rates = given(joints, "velocity")) {
    constexpr Bounds kRest{0.0, 0.0, "rad/s: plans begin at rest"};
    for (const YamlView& rate : rates->items(0, kMostItems, "numbers")) static_cast<void>(rate.number(kRest));
  }
  return result;
}

/// Names of the planning frame.
using Frames = std::span<const std::string>;

bool contains(Frames frames, const std::string& frame) {
  return std::find(frames.begin(), frames.end(), frame) != frames.end();
}

void check_header(const YamlView& header, Frames frames) {
  check_keys(header, {"seq", "stamp", "frame_id"});
  const auto frame = given(header, "frame_id");
  if (!frame || contains(frames, frame->text())) return;
  const std::vector<std::string_view> words(frames.begin(), frames.end());
  frame->fail("empty or " + alternatives(words) + ": other frames are not read");
}

/// Reads a SolidPrimitive. Its type is a word or the message's number for it.
world::Shape primitive(const YamlView& view) {
  check_keys(view, {"type", "dimensions", "polygon"});
  const YamlView dimensions = required(view, "dimensions");
  const auto values = [&](std::size_t count, std::string_view of) {
    std::vector<double> result;
    for (const YamlView& item : dimensions.items(count, count, of)) result.push_back(item.number(kLength));
    return result;
  };
  constexpr std::array<std::string_view, 3> kNames = {"box", "sphere", "cylinder"};
  constexpr std::array<std::string_view, 3> kNumbers = {"1", "2", "3"};
  const YamlView type = required(view, "type");
  const auto number = std::find(kNumbers.begin(), kNumbers.end(), type.value());
  const auto kind =
      number != kNumbers.end() ? static_cast<std::size_t>(number - kNumbers.begin()) : type.choice(kNames);
  if (kind == 0) {
    const auto size = values(3, "numbers [x, y, z] in m");
    return world::Box{0.5 * Eigen::Vector3d(size[0], size[1], size[2])};
  }
  if (kind == 1) return world::Sphere{values(1, "numbers [radius] in m")[0]};
  const auto size = values(2, "numbers [height, radius] in m");
  return world::Cylinder{size[1], 0.5 * size[0]};
}

world::Obstacle collision_object(const YamlView& view, Frames frames) {
  check_keys(view, {"header", "pose", "id", "type", "primitives", "primitive_poses", "meshes", "mesh_poses", "planes",
                    "plane_poses", "subframe_names", "subframe_poses", "operation"});
  refuse_given(view, {"meshes", "mesh_poses", "planes", "plane_poses"}, "are not read; give primitives");
  if (const auto header = given(view, "header")) check_header(*header, frames);
  if (const auto operation = view.entry("operation"); operation && operation->value() != "0") {
    operation->fail("0 (ADD), because the scene has no objects to remove, append to or move");
  }
  world::Obstacle obstacle;
  obstacle.name = required(view, "id").text();
  if (const auto own = given(view, "pose")) obstacle.X_WO = pose(*own);
  const YamlView poses = required(view, "primitive_poses");
  const auto shapes = required(view, "primitives").items(1, kMostItems, "primitives");
  const auto places = poses.items(shapes.size(), shapes.size(), "poses, one for each primitive");
  for (std::size_t i = 0; i < shapes.size(); ++i) obstacle.shapes.push_back({primitive(shapes[i]), pose(places[i])});
  return obstacle;
}

/// Frames of objects must coincide with the planning frame; other frames do not matter.
void check_fixed_frame(const YamlView& view, Frames frames) {
  check_keys(view, {"header", "child_frame_id", "transform"});
  const YamlView child = required(view, "child_frame_id");
  if (!is_given(child) || !contains(frames, child.text())) return;
  require_identity(required(view, "transform"), "objects are read in the robot's root frame");
}

/// Refuses links whose value is not `plain`.
void check_links(const YamlView& root, std::string_view list, std::string_view key, double plain) {
  const auto links = given(root, list);
  if (!links) return;
  for (const YamlView& link : links->items(0, kMostItems, "links")) {
    const YamlView value = required(link, key);
    if (value.number(kCoordinate) != plain) {
      value.fail(number_text(plain) + ": padding and scale of links are not read; use --clearance");
    }
  }
}

/// In MoveIt 0 means 1.
void check_scaling(const YamlView& root, std::string_view key) {
  const auto found = given(root, key);
  if (!found) return;
  const double value = found->number({0.0, 1.0, ""});
  if (value != 0.0 && value != 1.0) {
    found->fail("0 or 1: shares of limits are not read; a cell file has arms' own limits");
  }
}

std::map<std::string, double> goal_of(const YamlView& goal) {
  check_keys(
      goal, {"name", "joint_constraints", "position_constraints", "orientation_constraints", "visibility_constraints"});
  refuse_given(goal, {"position_constraints", "orientation_constraints", "visibility_constraints"},
               "are not read; give joint_constraints");
  std::map<std::string, double> result;
  for (const YamlView& item : required(goal, "joint_constraints").items(1, kMostItems, "joint constraints")) {
    check_keys(item, {"joint_name", "position", "tolerance_above", "tolerance_below", "weight"});
    for (const char* key : {"tolerance_above", "tolerance_below"}) {
      if (const auto tolerance = item.entry(key)) static_cast<void>(tolerance->number({0.0, 1e6, "rad"}));
    }
    const YamlView name = required(item, "joint_name");
    if (!result.emplace(name.text(), required(item, "position").number(kAngle)).second) {
      name.fail("a joint that is constrained once");
    }
  }
  return result;
}

}  // namespace

MoveItScene read_moveit_scene(const std::string& path, std::span<const std::string> frames) {
  planner::SourceFiles sources;
  const YamlNode tree = read_yaml_file(path, sources);
  const YamlSource source{path, sources};
  const YamlView root(tree, source, "");
  check_keys(root, {"name", "robot_state", "robot_model_name", "fixed_frame_transforms", "allowed_collision_matrix",
                    "link_padding", "link_scale", "object_colors", "world", "is_diff"});
  refuse_diff(root, "scene");
  MoveItScene scene;
  scene.robot = text_if_given(root, "robot_model_name");
  if (const auto state = given(root, "robot_state")) static_cast<void>(robot_state(*state));
  if (const auto fixed = given(root, "fixed_frame_transforms")) {
    for (const YamlView& item : fixed->items(0, kMostItems, "transforms")) check_fixed_frame(item, frames);
  }
  check_links(root, "link_padding", "padding", 0.0);
  check_links(root, "link_scale", "scale", 1.0);
  const YamlView world = required(root, "world");
  check_keys(world, {"collision_objects", "octomap"});
  if (const auto outer = given(world, "octomap")) {
    if (const auto inner = given(*outer, "octomap")) {
      refuse_given(*inner, {"data"}, "is not read; give primitives");
    }
  }
  std::set<std::string> names;
  for (const YamlView& item : required(world, "collision_objects").items(0, kMostItems, "objects")) {
    scene.obstacles.push_back(collision_object(item, frames));
    if (!names.insert(scene.obstacles.back().name).second) required(item, "id").fail("a name that no other object has");
    note_given(item, {"subframe_names"}, "goals are joint values", scene.notes);
  }
  note_given(root, {"allowed_collision_matrix", "robot_state"},
             "the robot description and its SRDF define allowed collisions, the request defines the start",
             scene.notes);
  return scene;
}

MoveItScene read_moveit_scene(const std::string& path) {
  const std::array<std::string, 1> frames = {"world"};
  return read_moveit_scene(path, frames);
}

MoveItRequest read_moveit_request(const std::string& path) {
  planner::SourceFiles sources;
  const YamlNode tree = read_yaml_file(path, sources);
  const YamlSource source{path, sources};
  const YamlView root(tree, source, "");
  check_keys(root, {"workspace_parameters", "start_state", "goal_constraints", "path_constraints",
                    "trajectory_constraints", "reference_trajectories", "pipeline_id", "planner_id", "group_name",
                    "num_planning_attempts", "allowed_planning_time", "max_velocity_scaling_factor",
                    "max_acceleration_scaling_factor", "cartesian_speed_end_effector_link",
                    "cartesian_speed_limited_link", "max_cartesian_speed", "smoothness_level"});
  refuse_given(root, {"path_constraints", "trajectory_constraints", "reference_trajectories"}, "are not read");
  for (const char* key : {"max_velocity_scaling_factor", "max_acceleration_scaling_factor"}) check_scaling(root, key);
  if (const auto speed = root.entry("max_cartesian_speed"); speed && speed->number() != 0.0) {
    speed->fail("0: limits of a link's speed are not read");
  }
  MoveItRequest request;
  request.group = text_if_given(root, "group_name");
  request.start = robot_state(required(root, "start_state"));
  const YamlView goals = required(root, "goal_constraints");
  request.goal = goal_of(goals.items(1, 1, "constraints; goals to choose from are not read").front());
  note_given(root,
             {"workspace_parameters", "pipeline_id", "planner_id", "num_planning_attempts", "allowed_planning_time"},
             "the options of the command define the planner; workspaces are for mobile robots", request.notes);
  return request;
}

std::vector<std::string> groups_of_srdf(const std::string& path) {
  tinyxml2::XMLDocument document;
  planner::SourceFiles sources;
  planner::load_xml(path, "SRDF", document, sources);
  std::vector<std::string> names;
  const tinyxml2::XMLElement* robot = document.RootElement();
  if (robot == nullptr) return names;
  // Groups inside groups are references to groups at this level.
  for (const auto* e = robot->FirstChildElement("group"); e != nullptr; e = e->NextSiblingElement("group")) {
    names.push_back(planner::text_attribute(*e, "name", path));
  }
  return names;
}

}  // namespace hecaton::config
