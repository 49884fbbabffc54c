#include "planner/methods/sensed_cspace/published/critical_points.hpp"

#include <cmath>
#include <limits>

namespace hecaton::planner::cspace {

// differs from paper: its text calls G₂ and G₃ the points of Θ₁min and Θ₁max and G₄ and G₅ those of φ; the algorithm
// has them the other way round, and so have we. Nothing depends on it: eq. 8 and 9 treat them alike.
CriticalPoints find_critical_points(std::span<const FundamentalObstacle> obstacles, const ImageDatabase& database) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  double r_min = kInfinity;
  double phi_min = kInfinity;
  double phi_max = -kInfinity;
  double theta1_min = kInfinity;
  double theta1_max = -kInfinity;
  CriticalPoints g;
  for (int j = 0; j < static_cast<int>(obstacles.size()); ++j) {
    const FundamentalObstacle& obstacle = obstacles[j];
    if (obstacle.r < r_min) {
      r_min = obstacle.r;
      g.nearest = j;
    }
    const double phi = obstacles[0].phi + std::remainder(obstacle.phi - obstacles[0].phi, 2.0 * kPi);
    if (phi < phi_min) {
      phi_min = phi;
      g.phi_min = j;
    }
    if (phi > phi_max) {
      phi_max = phi;
      g.phi_max = j;
    }
    const PointImage& image = database.at(obstacle.r);
    if (image.empty()) continue;
    if (phi + image.theta1_min < theta1_min) {
      theta1_min = phi + image.theta1_min;
      g.theta1_min = j;
    }
    if (phi + image.theta1_max > theta1_max) {
      theta1_max = phi + image.theta1_max;
      g.theta1_max = j;
    }
  }
  if (g.theta1_min >= 0) {
    g.least_theta1 = theta1_min;
    g.largest_theta1 = theta1_max;
  }
  return g;
}

}  // namespace hecaton::planner::cspace
