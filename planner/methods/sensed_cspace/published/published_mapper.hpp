#pragma once
/// The C-space mapper of [Li96] as published: algorithms 1 and 2. It misses cells in which the arm collides
/// (docs/explanation/0011-sensed-cspace.md). `sensed.mapper: published` selects it.

#include <array>
#include <span>
#include <vector>

#include "planner/methods/sensed_cspace/cspace_map.hpp"
#include "planner/methods/sensed_cspace/planar_geometry.hpp"

namespace hecaton::planner::cspace {

/// FO_i (eq. 1 and 2): a grid point of the workspace next to the border of an obstacle.
///
/// differs from paper: φ = atan2(y, x), because arctan(y/x) loses the sign.
struct FundamentalObstacle {
  Point place;       ///< [m], both multiples of the grid's spacing
  double r = 0.0;    ///< [m]
  double phi = 0.0;  ///< [rad], −π … π
};

/// The fundamental obstacle next to a point [m].
[[nodiscard]] FundamentalObstacle fundamental_obstacle(const Point& point, double spacing);

/// The fundamental obstacles along the border of the polygon with these corners, each once. `spacing`: δ [m].
[[nodiscard]] std::vector<FundamentalObstacle> border(std::span<const Point> corners, double spacing);

/// Points of the border, including its corners; the border is within half of `spacing` [m] of them. Mapped exactly,
/// with widths grown by this distance, they block every cell in whose centre the arm touches the obstacle.
/// Precondition: the obstacle does not contain the arm's base. Sensors measure such points.
[[nodiscard]] std::vector<Point> border_points(std::span<const Point> corners, double spacing);

/// The number of images that [Li96] stores (section 2).
inline constexpr int kPublishedImages = 40;

/// CO_R(MFO_k) as in table 1 [rad]. For rows one pitch apart from θ₁min, it holds the least and the largest θ₂ that
/// touch the point. They are not wrapped.
struct PointImage {
  double theta1_min = 0.0;
  double theta1_max = -1.0;   ///< below θ₁min: the arm cannot touch it
  std::vector<double> lower;  ///< θ₂l(1) … θ₂l(t_v)
  std::vector<double> upper;  ///< θ₂u(1) … θ₂u(t_v)

  [[nodiscard]] bool empty() const { return lower.empty(); }
};

/// The images of fundamental obstacles on the positive x axis. [Li96] derives all other images from them.
class ImageDatabase {
 public:
  /// Computes the images for r = k δ, k = 1 … `images`, with δ = reach / images.
  ImageDatabase(const PlanarArm& arm, AngleGrid grid, int images = kPublishedImages);

  [[nodiscard]] const AngleGrid& grid() const { return grid_; }
  [[nodiscard]] double spacing() const { return spacing_; }  ///< δ [m]
  /// The image of MFO_n with n = ⌊r/δ⌋, at least 1, as in algorithm 1. Empty beyond the arm's reach.
  [[nodiscard]] const PointImage& at(double r) const;
  [[nodiscard]] int size() const { return static_cast<int>(images_.size()); }
  [[nodiscard]] std::size_t bytes() const;

 private:
  AngleGrid grid_;
  double spacing_;
  std::vector<PointImage> images_;  ///< MFO_1 …
};

/// The five critical points of an obstacle, as indices of fundamental obstacles. Indices may be equal.
struct CriticalPoints {
  int nearest = -1;              ///< G₁: least r
  int phi_min = -1;              ///< G₂
  int phi_max = -1;              ///< G₃
  int theta1_min = -1;           ///< G₄: its image begins first
  int theta1_max = -1;           ///< G₅: its image ends last
  double least_theta1 = 0.0;     ///< Θ₁min [rad]
  double largest_theta1 = -1.0;  ///< Θ₁max [rad]; below Θ₁min: the arm cannot touch the obstacle

  friend bool operator==(const CriticalPoints&, const CriticalPoints&) = default;
};

/// Algorithm 1. Precondition: `obstacles` is not empty. Angles are compared relative to the first φ, so that an
/// obstacle may cross the negative x axis.
[[nodiscard]] CriticalPoints find_critical_points(std::span<const FundamentalObstacle> obstacles,
                                                  const ImageDatabase& database);

/// Algorithm 2: fills `image` with the cells between Θ₂l(m) and Θ₂u(m).
void map_as_published(std::span<const FundamentalObstacle> obstacles, const CriticalPoints& critical,
                      const ImageDatabase& database, ObstacleImage& image);

/// Eq. 7: the same rows and interpolation, for each fundamental obstacle separately.
void map_union(std::span<const FundamentalObstacle> obstacles, const ImageDatabase& database, CspaceMap& map);

}  // namespace hecaton::planner::cspace
