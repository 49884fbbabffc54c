#pragma once
/// A polyline in joint space with corners rounded by parabolas [Kunz12].
///
/// A blend replaces a corner between the unit directions u₁ and u₂, from the distance l before it to l behind it:
///     q(s) = q_A + s u₁ + s²/(4l) (u₂ − u₁),   s in 0 … 2l.
/// It has the directions of the lines at its ends and deviates from the polyline by at most l ‖u₂ − u₁‖/4.
/// differs from paper: parabolas instead of circles. q′ is linear and q″ constant in s. The limits between two points
/// of a grid then follow from the values at these points (time_optimal.hpp).

#include <functional>
#include <vector>

#include <Eigen/Core>

namespace hecaton::planner {

/// q(s) = q + s d + s²/2 c for s in 0 … length. A line has a unit d and c = 0, a blend a unit d at both its ends.
struct PathPiece {
  Eigen::VectorXd q;  ///< start [rad | m]
  Eigen::VectorXd d;  ///< q′ at the start
  Eigen::VectorXd c;  ///< q″
  double length = 0.0;
  bool blend = false;
  bool stop_behind = false;  ///< the next piece has another direction: the arm must stop at the end

  [[nodiscard]] Eigen::VectorXd at(double s) const { return q + s * d + (0.5 * s * s) * c; }
  [[nodiscard]] Eigen::VectorXd slope(double s) const { return d + s * c; }
};

struct BlendOptions {
  double deviation = 0.05;  ///< largest deviation of a blend from the polyline [rad | m]; 0: no blends
  int halvings = 6;         ///< a blend that is not free is halved up to this many times, then dropped
};

/// True if the parabola is free of collisions. The arguments are the control points of a quadratic Bézier curve.
using CurveFree =
    std::function<bool(const Eigen::VectorXd& from, const Eigen::VectorXd& corner, const Eigen::VectorXd& to)>;

/// The path through `waypoints` [rad | m]. Repeated and collinear waypoints are dropped. Fewer than two different
/// waypoints give no pieces. A blend takes at most half of a line between two corners.
[[nodiscard]] std::vector<PathPiece> blended(const std::vector<Eigen::VectorXd>& waypoints, const CurveFree& free,
                                             const BlendOptions& options = {});

}  // namespace hecaton::planner
