#include "planner/methods/sensed_cspace/published/published_mapper.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace hecaton::planner::cspace {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Where an image turned by φ meets the rows of the grid.
struct Turned {
  const PointImage& image;
  int first_row = 0;   ///< σ_min, not wrapped
  int rows = 0;        ///< ω
  double share = 0.0;  ///< of the way from one of the image's rows to the next, at which the grid's row lies

  // differs from paper: rows count from −π as the grid does; σ_max is rounded down, for a row beyond the image has no
  // second value; and s is the share by which the grid's row follows the image's, as v = (1 − s) θ(k) + s θ(k+1) needs
  // it, where the paper's remainder is 1 − s.
  Turned(const PointImage& turned, double phi, const AngleGrid& grid) : image(turned) {
    const double begin = grid.place(phi + turned.theta1_min);
    first_row = static_cast<int>(std::ceil(begin));
    rows = turned.empty() ? 0 : static_cast<int>(std::floor(grid.place(phi + turned.theta1_max))) - first_row + 1;
    share = static_cast<double>(first_row) - begin;
  }
  [[nodiscard]] double between(const std::vector<double>& values, int k) const {
    const std::size_t next = std::min(static_cast<std::size_t>(k) + 1, values.size() - 1);
    return (1.0 - share) * values[static_cast<std::size_t>(k)] + share * values[next];
  }
};

RowSpan cells_between(const AngleGrid& grid, double lower, double upper) {
  if (!(lower <= upper)) return {};
  const int first = static_cast<int>(std::ceil(grid.place(lower)));
  const int last = static_cast<int>(std::floor(grid.place(upper)));
  return {static_cast<std::int16_t>(grid.wrapped(first)),
          static_cast<std::int16_t>(std::clamp(last - first + 1, 0, grid.cells))};
}

}  // namespace

void map_as_published(std::span<const FundamentalObstacle> obstacles, const CriticalPoints& g,
                      const ImageDatabase& database, ObstacleImage& image) {
  image.clear();
  if (g.theta1_min < 0) return;
  const AngleGrid& grid = database.grid();
  // Step 1 and 2.
  const int p_min = static_cast<int>(std::ceil(grid.place(g.least_theta1)));
  const int p_max = static_cast<int>(std::floor(grid.place(g.largest_theta1)));
  const int M = std::max(0, p_max - p_min + 1);
  std::vector<double> lower(M, kInfinity);
  std::vector<double> upper(M, -kInfinity);
  const auto turned = [&](int i) {
    const double phi = obstacles[0].phi + std::remainder(obstacles[i].phi - obstacles[0].phi, 2.0 * kPi);
    return Turned(database.at(obstacles[i].r), phi, grid);
  };
  // Step 3: eq. 8.
  for (const int i : {g.nearest, g.phi_max, g.theta1_max}) {
    const Turned point = turned(i);
    for (int k = 0; k < point.rows; ++k) {
      double& at = upper[static_cast<std::size_t>(point.first_row - p_min + k)];
      at = std::max(at, point.between(point.image.upper, k));
    }
  }
  // Step 4: eq. 9.
  for (const int i : {g.nearest, g.phi_min, g.theta1_min}) {
    const Turned point = turned(i);
    for (int k = 0; k < point.rows; ++k) {
      double& at = lower[static_cast<std::size_t>(point.first_row - p_min + k)];
      at = std::min(at, point.between(point.image.lower, k));
    }
  }
  image.first_row = grid.wrapped(p_min);
  for (int m = 0; m < std::min(M, grid.cells); ++m) image.spans.push_back(cells_between(grid, lower[m], upper[m]));
}

void map_union(std::span<const FundamentalObstacle> obstacles, const ImageDatabase& database, CspaceMap& map) {
  const AngleGrid& grid = database.grid();
  for (const FundamentalObstacle& obstacle : obstacles) {
    const Turned point(database.at(obstacle.r), obstacle.phi, grid);
    for (int k = 0; k < point.rows; ++k) {
      map.block(grid.wrapped(point.first_row + k),
                cells_between(grid, point.between(point.image.lower, k), point.between(point.image.upper, k)));
    }
  }
}

}  // namespace hecaton::planner::cspace
