#pragma once
/// The images of fundamental obstacles on the positive x axis, from which [Li96] makes those of all others.

#include <vector>

#include "planner/methods/sensed_cspace/angle_grid.hpp"
#include "planner/methods/sensed_cspace/planar_arm.hpp"

namespace hecaton::planner::cspace {

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

}  // namespace hecaton::planner::cspace
