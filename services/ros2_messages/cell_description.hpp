#pragma once
/// A cell in the terms of ROS 2: names of joints and frames, and its robot descriptions (URDF).
///
/// Joints and links of arm `north` have the prefix "north_" in everything that describes the whole cell. Descriptions
/// come from the models that the planners use. They show the collision shapes: boxes, spheres and cylinders as they
/// are, a capsule as a cylinder with two spheres, a convex hull as its bounding box.

#include <string>
#include <vector>

#include "planner/cell.hpp"

namespace hecaton::ros2 {

inline constexpr const char* kWorldFrame = "world";

/// "north", "forearm" → "north_forearm".
[[nodiscard]] inline std::string prefixed(const std::string& arm, const std::string& name) {
  return arm + "_" + name;
}

/// The URDF of one arm, with the names of its own model.
[[nodiscard]] std::string arm_urdf(const planner::Arm& arm);
/// The URDF of all arms at their bases in the frame `world`.
[[nodiscard]] std::string cell_urdf(const planner::Cell& cell);

/// A transform of TF between two links of one arm, as indices into its model.
struct LinkFrame {
  int parent;
  int link;
  bool moves;  ///< a joint of the arm, or one outside its chain, moves it
};
/// All links of the model but the root.
[[nodiscard]] std::vector<LinkFrame> link_frames(const planner::RobotModel& model);

}  // namespace hecaton::ros2
