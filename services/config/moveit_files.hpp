#pragma once
/// MoveIt's planning scenes and motion plan requests as YAML, as its benchmarks write them. Only what says where
/// obstacles are and from where to where is read; the rest may be anything.

#include <map>
#include <string>
#include <vector>

#include "world/model/scene.hpp"

namespace hecaton::config {

/// world.collision_objects: boxes, spheres and cylinders, in the frame of the robot's root. Throws ConfigError, also
/// for meshes, planes, cones and objects attached to the robot: to leave them out would be to plan through them.
[[nodiscard]] std::vector<world::Obstacle> read_moveit_scene(const std::string& path);

struct MoveItRequest {
  std::map<std::string, double> start;  ///< by joint name [rad | m]
  std::map<std::string, double> goal;
};

/// start_state.joint_state, and the first of goal_constraints, which must be joint_constraints. Throws ConfigError.
[[nodiscard]] MoveItRequest read_moveit_request(const std::string& path);

}  // namespace hecaton::config
