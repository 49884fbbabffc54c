#pragma once
/// A polyline in joint space whose corners are rounded by parabolas.
///
/// The blends' shape is [Kunz12]'s, in the way that their authors compare circles with: a corner between unit
/// directions u₁ and u₂ is left at distance l before it and joined again at l behind it by
///     q(s) = q_A + s u₁ + s²/(4l) (u₂ − u₁),   s in 0 … 2l,
/// which has the directions of the lines at its ends. It departs from the polyline by at most l ‖u₂ − u₁‖/4.
/// differs from paper: parabolas instead of circles. q′ is linear and q″ constant in s, so that what limits ask for
/// between two points of a grid follows from its ends (time_optimal.hpp).

#include <functional>
#include <vector>

#include <Eigen/Core>

namespace hecaton::planner {

/// q(s) = q + s d + s²/2 c for s in 0 … length. A line has a unit d and c = 0, a blend a unit d at both its ends.
struct PathPiece {
  Eigen::VectorXd q;  ///< where it begins [rad | m]
  Eigen::VectorXd d;  ///< q′ there
  Eigen::VectorXd c;  ///< q″
  double length = 0.0;
  bool blend = false;
  bool stop_behind = false;  ///< what follows begins in another direction: the arm must be at rest in between

  [[nodiscard]] Eigen::VectorXd at(double s) const { return q + s * d + (0.5 * s * s) * c; }
  [[nodiscard]] Eigen::VectorXd slope(double s) const { return d + s * c; }
};

struct BlendOptions {
  double deviation = 0.05;  ///< a blend departs from the polyline by no more, in joint space [rad | m]; 0: none
  int halvings = 6;         ///< a blend that is not free is made half as long so many times, then there is none
};

/// Whether the parabola (a quadratic Bézier curve with these control points) is free.
using CurveFree =
    std::function<bool(const Eigen::VectorXd& from, const Eigen::VectorXd& corner, const Eigen::VectorXd& to)>;

/// Waypoints that repeat one another or lie on the line through their neighbours are left out. No pieces for fewer than
/// two different waypoints. Blends take at most half of a line that another corner shares.
[[nodiscard]] std::vector<PathPiece> blended(const std::vector<Eigen::VectorXd>& waypoints, const CurveFree& free,
                                             const BlendOptions& options = {});

}  // namespace hecaton::planner
