#include "planner/methods/sensed_cspace/published/published_mapper.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace hecaton::planner::cspace {

FundamentalObstacle fundamental_obstacle(const Point& point, double spacing) {
  const Point place{spacing * std::round(point.x / spacing), spacing * std::round(point.y / spacing)};
  return {place, std::hypot(place.x, place.y), std::atan2(place.y, place.x)};
}

std::vector<FundamentalObstacle> border(std::span<const Point> corners, double spacing) {
  constexpr double kStepsPerSpacing = 4.0;
  std::vector<FundamentalObstacle> found;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Point& from = corners[i];
    const Point& to = corners[(i + 1) % corners.size()];
    const double length = std::hypot(to.x - from.x, to.y - from.y);
    const int steps = std::max(1, static_cast<int>(std::ceil(kStepsPerSpacing * length / spacing)));
    for (int k = 0; k < steps; ++k) {
      const double share = static_cast<double>(k) / steps;
      const FundamentalObstacle next =
          fundamental_obstacle({from.x + share * (to.x - from.x), from.y + share * (to.y - from.y)}, spacing);
      const bool known = std::any_of(found.begin(), found.end(), [&](const FundamentalObstacle& other) {
        return other.place.x == next.place.x && other.place.y == next.place.y;
      });
      if (!known) found.push_back(next);
    }
  }
  return found;
}

std::vector<Point> border_points(std::span<const Point> corners, double spacing) {
  std::vector<Point> points;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Point& from = corners[i];
    const Point& to = corners[(i + 1) % corners.size()];
    const int steps = std::max(1, static_cast<int>(std::ceil(std::hypot(to.x - from.x, to.y - from.y) / spacing)));
    for (int k = 0; k < steps; ++k) {
      const double share = static_cast<double>(k) / steps;
      points.push_back({from.x + share * (to.x - from.x), from.y + share * (to.y - from.y)});
    }
  }
  return points;
}

namespace {

/// The largest angle between θ₁ and the direction of a point at distance r for a contact [rad]; negative: no contact.
/// [Li96] eq. 3 with s = l₂, extended by the first link.
double widest_theta1(const PlanarArm& arm, double r) {
  const double l1 = arm.length1;
  const double l2 = arm.length2;
  double widest = r <= l1 ? std::asin(std::min(1.0, arm.width1 / r)) : -1.0;
  if (r <= l1 + l2 && r >= std::abs(l1 - l2)) {
    widest = std::max(widest, std::acos(std::clamp((r * r + l1 * l1 - l2 * l2) / (2.0 * l1 * r), -1.0, 1.0)));
  } else if (r < l2 - l1) {
    widest = kPi;
  }
  return widest;
}

}  // namespace

// [Li96] eq. 3–6 for a point at (r, 0), row by row. From the elbow at θ₁, the point has the distance s and the
// direction θ₂. The second link touches it from θ₂ − asin(w/s) to θ₂ + asin(w/s). Each row is
// blocked completely if the first link touches the point ("very simple" in the paper), or if the elbow is within w of
// it.
//
// differs from paper: eq. 4 lacks l₂ and the rule for the sign. Here θ₂ follows from the elbow's position.
ImageDatabase::ImageDatabase(const PlanarArm& arm, AngleGrid grid, int images)
    : grid_(grid), spacing_(arm.reach() / images) {
  for (int k = 1; k <= images; ++k) {
    const double r = k * spacing_;
    PointImage& image = images_.emplace_back();
    const double widest = widest_theta1(arm, r);
    if (widest < 0.0) continue;
    image.theta1_min = -widest;
    image.theta1_max = widest;
    const int rows = static_cast<int>(std::ceil(2.0 * widest / grid.pitch())) + 1;
    for (int row = 0; row < rows; ++row) {
      const double theta1 = std::min(image.theta1_min + row * grid.pitch(), widest);
      const double x = r * std::cos(theta1) - arm.length1;
      const double y = -r * std::sin(theta1);
      const double s = std::hypot(x, y);
      const bool first_link = r <= arm.length1 && std::abs(y) <= arm.width1 && x <= 0.0 && std::cos(theta1) > 0.0;
      const double theta2 = std::atan2(y, x);
      const double half = s > arm.width2 ? std::asin(arm.width2 / s) : kPi;
      const bool all = first_link || half == kPi;
      image.lower.push_back(all ? -kPi : theta2 - half);
      image.upper.push_back(all ? kPi : theta2 + half);
    }
  }
}

const PointImage& ImageDatabase::at(double r) const {
  static const PointImage kOutOfReach;
  const double n = std::max(1.0, std::floor(r / spacing_));
  return n > size() ? kOutOfReach : images_[static_cast<std::size_t>(n) - 1];
}

std::size_t ImageDatabase::bytes() const {
  std::size_t bytes = images_.size() * sizeof(PointImage);
  for (const PointImage& image : images_) bytes += (image.lower.size() + image.upper.size()) * sizeof(double);
  return bytes;
}

// differs from paper: its text assigns G₂ and G₃ to Θ₁, and G₄ and G₅ to φ. Its algorithm exchanges them, as this code
// does. Eq. 8 and 9 treat both pairs alike.
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

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// An image turned by φ, resampled at the rows of the grid.
struct Turned {
  const PointImage& image;
  int first_row = 0;   ///< σ_min, not wrapped
  int rows = 0;        ///< ω
  double share = 0.0;  ///< of the way from one of the image's rows to the next, at which the grid's row lies

  // differs from paper: rows count from −π as in the grid. The row σ_max is rounded down, because a row beyond the
  // image has no second value. The offset of the grid's row from the image's row is s in v = (1 − s) θ(k) + s θ(k+1).
  // It is 1 − s in the paper.
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
