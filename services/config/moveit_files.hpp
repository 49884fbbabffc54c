#pragma once
/// MoveIt's planning scenes and motion plan requests as YAML, as its benchmarks or ROS write them. Every key of these
/// messages is either read, or must be as if it were not given, or is harmless to leave out; those of the last kind
/// that somebody may miss are told. Anything else is refused: what is not understood must not be planned through.

#include <map>
#include <span>
#include <string>
#include <vector>

#include "world/model/scene.hpp"

namespace hecaton::config {

struct MoveItScene {
  std::vector<world::Obstacle> obstacles;  ///< in the order of world.collision_objects
  std::string robot;                       ///< robot_model_name; empty: none given
  std::vector<std::string> notes;          ///< sentences: what of the file does not matter here
};

/// world.collision_objects: boxes, spheres and cylinders that are added, in the planning frame, which is what an empty
/// frame_id and those in `frames` mean. Throws ConfigError, also for meshes, planes, cones, octomaps, objects attached
/// to the robot, padded links and a robot that stands elsewhere: to leave them out would be to plan through them.
[[nodiscard]] MoveItScene read_moveit_scene(const std::string& path, std::span<const std::string> frames);
/// The same with the frame `world`.
[[nodiscard]] MoveItScene read_moveit_scene(const std::string& path);

struct MoveItRequest {
  std::map<std::string, double> start;  ///< by joint name [rad | m]
  std::map<std::string, double> goal;
  std::string group;  ///< group_name; empty: none given
  std::vector<std::string> notes;
};

/// start_state.joint_state, and the only one of goal_constraints, which must be joint_constraints; their tolerances are
/// kept by going to the very position. Throws ConfigError, also for every other constraint and for a start that is a
/// difference: what that start carries is not known.
[[nodiscard]] MoveItRequest read_moveit_request(const std::string& path);

/// The names of the groups of joints in an SRDF, in its order. Throws planner::ModelError.
[[nodiscard]] std::vector<std::string> groups_of_srdf(const std::string& path);

}  // namespace hecaton::config
