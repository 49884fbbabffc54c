#pragma once
/// MoveIt's planning scenes and motion plan requests as YAML, as its benchmarks or ROS write them. A reader reads a
/// key, or ignores it where that is safe (with a note if users may expect an effect), or refuses the file. A planner
/// must not plan through objects that the reader does not understand.

#include <map>
#include <span>
#include <string>
#include <vector>

#include "services/config/yaml_tree.hpp"
#include "world/model/scene.hpp"

namespace hecaton::config {

struct MoveItScene {
  std::vector<world::Obstacle> obstacles;  ///< in the order of world.collision_objects
  std::string robot;                       ///< robot_model_name; empty: none given
  std::vector<std::string> notes;          ///< ignored keys, a sentence each
};

/// Reads world.collision_objects: boxes, spheres and cylinders with the operation ADD in the planning frame, which an
/// empty frame_id and the names in `frames` mean. Throws ConfigError, also for meshes, planes, cones, octomaps,
/// attached objects, padded links and a robot away from the origin.
[[nodiscard]] MoveItScene read_moveit_scene(const std::string& path, std::span<const std::string> frames);
/// The same with the frame `world`.
[[nodiscard]] MoveItScene read_moveit_scene(const std::string& path);

struct MoveItRequest {
  std::map<std::string, double> start;  ///< by joint name [rad | m]
  std::map<std::string, double> goal;
  std::string group;  ///< group_name; empty: none given
  std::vector<std::string> notes;
};

/// Reads start_state.joint_state and the only entry of goal_constraints, which must be joint_constraints. The goal is
/// their exact position, which is within any tolerance. Throws ConfigError, also for all other constraints and for a
/// start that is a difference.
[[nodiscard]] MoveItRequest read_moveit_request(const std::string& path);

/// The names of the groups of joints in an SRDF, in its order. Throws planner::ModelError.
[[nodiscard]] std::vector<std::string> groups_of_srdf(const std::string& path);

}  // namespace hecaton::config
