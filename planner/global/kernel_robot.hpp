#pragma once
/// The planned arms as the collision kernel reads them.

#include <vector>

#include "planner/collision/cell_geometry.hpp"
#include "planner/collision/swept_core.hpp"
#include "planner/global/kernel_shapes.hpp"
#include "planner/global/validity_kernel.hpp"

namespace hecaton::planner::global {

/// Upper bounds of the motion of a body's points per unit of a joint [m/rad | 1]: row by row for every own body of the
/// geometries, one for each axis of all their own arms. They hold for any values of the other joints within their
/// limits. Rounded up.
[[nodiscard]] std::vector<float> body_levers(const std::vector<CellGeometry>& planned);

/// Distances to keep.
struct KernelPadding {
  double between_arms = 0.0;  ///< [m]
  double self = 0.0;          ///< between links of one arm [m]
};

/// A shape and its pose in its kernel frame; for bodies of the world, in O.
struct PlacedCore {
  SweptCore core;
  Pose X_FS = Pose::Identity();
};

struct BuiltRobot {
  KernelRobot robot;
  std::vector<PlacedCore> cores;                     ///< by body
  std::vector<int> arm_of_body;                      ///< index into the geometries
  std::vector<double> rounding_of_body;              ///< no point of the body is farther from where floats place it [m]
  std::vector<world::BoundingSphere> reach_of_link;  ///< contains the link in all configurations, in O; fixed links: 0
};

/// `X_OW`: the kernel's frame. Throws std::invalid_argument for more than kMaxDimensions joints, kMaxBodies bodies or
/// kMaxBalls balls.
[[nodiscard]] BuiltRobot kernel_robot(const std::vector<CellGeometry>& planned, const Pose& X_OW,
                                      const CoverOptions& cover, const KernelPadding& padding);

}  // namespace hecaton::planner::global
