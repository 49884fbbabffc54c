#include <array>
#include <string_view>

#include <tinyxml2.h>

#include "planner/model/xml_checks.hpp"
#include "services/config/moveit_files.hpp"
#include "services/config/moveit_values.hpp"

namespace hecaton::config {
namespace {

using namespace moveit;

constexpr std::array<std::string_view, 17> kRequestKeys = {"workspace_parameters",
                                                           "start_state",
                                                           "goal_constraints",
                                                           "path_constraints",
                                                           "trajectory_constraints",
                                                           "reference_trajectories",
                                                           "pipeline_id",
                                                           "planner_id",
                                                           "group_name",
                                                           "num_planning_attempts",
                                                           "allowed_planning_time",
                                                           "max_velocity_scaling_factor",
                                                           "max_acceleration_scaling_factor",
                                                           "cartesian_speed_end_effector_link",
                                                           "cartesian_speed_limited_link",
                                                           "max_cartesian_speed",
                                                           "smoothness_level"};
constexpr std::array<std::string_view, 5> kGoalKeys = {"name", "joint_constraints", "position_constraints",
                                                       "orientation_constraints", "visibility_constraints"};
constexpr std::array<std::string_view, 5> kJointKeys = {"joint_name", "position", "tolerance_above", "tolerance_below",
                                                        "weight"};
constexpr Bounds kTolerance{0.0, 1e6, "rad"};

/// 0 is MoveIt's way to say 1.
void check_scaling(const YamlView& root, std::string_view key) {
  const auto found = root.entry(key);
  if (!found || !is_given(*found)) return;
  const double value = found->number({0.0, 1.0, ""});
  if (value != 0.0 && value != 1.0)
    found->fail("0 or 1: shares of limits are not read; a cell file has arms' own limits");
}

std::map<std::string, double> goal_of(const YamlView& goal) {
  check_keys(goal, kGoalKeys);
  refuse_given(goal, {"position_constraints", "orientation_constraints", "visibility_constraints"},
               "are not read; give joint_constraints");
  std::map<std::string, double> result;
  for (const YamlView& item : required(goal, "joint_constraints").items(1, kMost, "joint constraints")) {
    check_keys(item, kJointKeys);
    for (const char* key : {"tolerance_above", "tolerance_below"}) {
      if (const auto tolerance = item.entry(key)) static_cast<void>(tolerance->number(kTolerance));
    }
    const YamlView name = required(item, "joint_name");
    if (!result.emplace(name.text(), required(item, "position").number(kAngle)).second) {
      name.fail("a joint that is constrained once");
    }
  }
  return result;
}

}  // namespace

MoveItRequest read_moveit_request(const std::string& path) {
  planner::SourceFiles sources;
  const YamlNode tree = read_yaml_file(path, sources);
  const YamlSource source{path, sources};
  const YamlView root(tree, source, "");
  check_keys(root, kRequestKeys);
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
  const std::string why = "the options of the command say how it is planned; workspaces are for robots that drive";
  if (const std::string note = note_of(
          root, {"workspace_parameters", "pipeline_id", "planner_id", "num_planning_attempts", "allowed_planning_time"},
          why);
      !note.empty()) {
    request.notes.push_back(note);
  }
  return request;
}

std::vector<std::string> groups_of_srdf(const std::string& path) {
  tinyxml2::XMLDocument document;
  planner::SourceFiles sources;
  planner::load_xml(path, "SRDF", document, sources);
  std::vector<std::string> names;
  const tinyxml2::XMLElement* robot = document.RootElement();
  if (robot == nullptr) return names;
  // Groups within groups refer to those beside them.
  for (const auto* e = robot->FirstChildElement("group"); e != nullptr; e = e->NextSiblingElement("group")) {
    names.push_back(planner::text_attribute(*e, "name", path));
  }
  return names;
}

}  // namespace hecaton::config
