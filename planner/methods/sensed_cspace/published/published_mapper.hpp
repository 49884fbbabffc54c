#pragma once
/// The C-space mapper of [Li96] as published: algorithms 1 and 2. For comparison only: it misses cells in which the arm
/// collides (docs/design/0011-sensed-cspace.md).

#include <array>
#include <span>
#include <vector>

#include "planner/methods/sensed_cspace/cspace_map.hpp"
#include "planner/methods/sensed_cspace/planar_geometry.hpp"

namespace hecaton::planner::cspace {

/// FO_i with its two parameters, eq. 1 and 2. differs from paper: φ needs both signs, arctan(y/x) has one.
struct FundamentalObstacle {
  Point place;       ///< [m], both multiples of the grid's spacing
  double r = 0.0;    ///< [m]
  double phi = 0.0;  ///< [rad], −π … π
};

/// Those nearest to the border of the polygon through `corners`, in order along it, each once. `spacing`: δ [m].
[[nodiscard]] std::vector<FundamentalObstacle> border(std::span<const Point> corners, double spacing);

/// Points of the border itself, its corners among them: none of it is farther than half of `spacing` [m] from the
/// nearest of them. Each mapped exactly with that added to the widths (ObstacleMapper), they block every cell in whose
/// centre the arm touches the obstacle, if that is clear of the arm's base: who touches it and is not all inside of it
/// touches its border. What sensors see is such points.
[[nodiscard]] std::vector<Point> border_points(std::span<const Point> corners, double spacing);

/// How many images [Li96] stores (section 2).
inline constexpr int kPublishedImages = 40;

/// CO_R(MFO_k) as in table 1: for rows one pitch apart, from θ₁min on, the least and the largest θ₂ that touch it. Not
/// wrapped to a full turn: θ₂ beyond ±π belongs to the other end. [rad]
struct PointImage {
  double theta1_min = 0.0;
  double theta1_max = -1.0;   ///< below θ₁min: the arm cannot touch it
  std::vector<double> lower;  ///< θ₂l(1) … θ₂l(t_v)
  std::vector<double> upper;  ///< θ₂u(1) … θ₂u(t_v)

  [[nodiscard]] bool empty() const { return lower.empty(); }
};

class ImageDatabase {
 public:
  /// The images of the obstacles at r = k δ, k = 1 … `images`; δ = reach / images. In memory; nothing else is kept.
  ImageDatabase(const PlanarArm& arm, AngleGrid grid, int images = kPublishedImages);

  [[nodiscard]] const AngleGrid& grid() const { return grid_; }
  [[nodiscard]] double spacing() const { return spacing_; }  ///< δ [m]
  /// Of MFO_n, n = ⌊r/δ⌋ as in algorithm 1; the innermost nearer than δ; empty where the arm does not reach.
  [[nodiscard]] const PointImage& at(double r) const;
  [[nodiscard]] int size() const { return static_cast<int>(images_.size()); }
  [[nodiscard]] std::size_t bytes() const;

 private:
  AngleGrid grid_;
  double spacing_;
  std::vector<PointImage> images_;  ///< MFO_1 …
};

/// Indices of fundamental obstacles, of which several may be the same.
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

/// Of at least one fundamental obstacle. Angles are compared relative to the first one's φ, so that an obstacle may lie
/// across the negative x axis.
[[nodiscard]] CriticalPoints find_critical_points(std::span<const FundamentalObstacle> obstacles,
                                                  const ImageDatabase& database);

/// Fills `image` with what lies between Θ₂l(m) and Θ₂u(m).
void map_as_published(std::span<const FundamentalObstacle> obstacles, const CriticalPoints& critical,
                      const ImageDatabase& database, ObstacleImage& image);

/// The same rows and interpolation, but of all fundamental obstacles, each for itself: eq. 7.
void map_union(std::span<const FundamentalObstacle> obstacles, const ImageDatabase& database, CspaceMap& map);

}  // namespace hecaton::planner::cspace
