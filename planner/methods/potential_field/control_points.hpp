#pragma once
/// The points of an arm that potentials act on [Cardenas10, "Combined field effect" and "Examples"].

#include <vector>

#include "planner/collision/cell_geometry.hpp"

namespace hecaton::planner::potential {

struct ControlPoint {
  int link = 0;                                   ///< of the own model
  Eigen::Vector3d p_L = Eigen::Vector3d::Zero();  ///< in the link's frame [m]
  double radius = 0.0;                            ///< a ball of the body around it; 0: a point of its surface [m]
};

/// Of all bodies that joints move, what the arm carries included: the vertices of boxes, points on the axes of round
/// bodies, both no farther apart than `spacing` [m].
[[nodiscard]] std::vector<ControlPoint> control_points(const CellGeometry& geometry, double spacing);

/// Three points of the tool, which pin down where it is and how it is turned: they are attracted, too.
[[nodiscard]] std::vector<ControlPoint> tool_points(const RobotModel& model, double spacing);

/// The same cell with an own arm that consists of nothing but these balls: own body i is points[i].
[[nodiscard]] CellGeometry control_geometry(const CellGeometry& geometry, const std::vector<ControlPoint>& points);

}  // namespace hecaton::planner::potential
