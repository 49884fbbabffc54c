#pragma once
/// Pictures like [Cardenas10] figures 2, 5 and 6: an arm among obstacles on its way, and the potential field around.

#include <span>
#include <string>
#include <vector>

#include "planner/cell.hpp"

namespace hecaton::services::cli {

/// Pictures are made of squares of so many pixels a side.
inline constexpr double kPanel = 480.0;

struct PathPicture {
  const planner::PlannedArm& planned;
  std::span<const world::Obstacle> obstacles;     ///< where they are at the beginning
  const std::vector<planner::JointVector>& path;  ///< from the start on; drawn faintly but for its end [rad | m]
  const planner::JointVector& goal;               ///< drawn in pale green
  std::string title;
  bool field = false;                    ///< also where the arm's potential field draws a point of its tool
  std::vector<std::string> panels = {};  ///< shown beside, each a square of SVG
};

/// An SVG. From above (x to the right, y upwards), beside it from the side (x to the right, z upwards) unless the arm
/// stays at one height; with `field` the field from above, at the height of the tool at the goal.
[[nodiscard]] std::string plot_path(const PathPicture& picture);

}  // namespace hecaton::services::cli
