#pragma once
/// Exact signed distances with nearest points between all kinds of shapes, and the planner's distance pass over them.

#include <memory>
#include <span>

#include "planner/collision/cell_geometry.hpp"
#include "planner/collision/clearance.hpp"
#include "planner/collision/convex_distance.hpp"
#include "planner/collision/pass_input.hpp"

namespace hecaton::planner {

/// The distance pass of one CellGeometry: pairs, prepared shapes and scratch storage. Use one object per thread, and
/// rebuild() it after set_obstacles(). `clearances` does not allocate.
///
/// Accuracy: exact up to rounding for spheres and capsules against each other and against boxes, and for spheres
/// against cylinders; within 1e-9 m for capsules whose segment is outside a cylinder; within 1e-6 m for other pairs. Up
/// to rounding no clearance exceeds the true one. Nearest points lie on the shapes within 1e-6 m, for cylinders within
/// 1e-4 m (docs/explanation/0002-distances.md).
class ExactDistance {
 public:
  /// `kernel`: one of the compilations in pass_kernels.hpp, to compare them.
  explicit ExactDistance(const CellGeometry& geometry, PassKernel kernel = fastest_pass());
  ~ExactDistance();
  ExactDistance(ExactDistance&&) noexcept;
  ExactDistance& operator=(ExactDistance&&) noexcept;

  /// Takes over a changed geometry (obstacles added, removed, attached). Allocates.
  void rebuild(const CellGeometry& geometry);

  /// Writes all pairs nearer than their influence distance, with nearest points, and returns their number. A cloud of
  /// points has up to kMostBallPairs with one body (see nearest_balls()). Order: self
  /// pairs, then other bodies in cell order, each with own bodies in order. When more than out.size() are near, it
  /// keeps the nearest. Depends on its arguments only. Own bodies that no joint moves appear only against moving bodies
  /// of other arms: own motion changes no other pair.
  int clearances(const CellPoses& poses, const InfluenceDistances& influence, std::span<Clearance> out);

  /// Distance of the own body from the volume that the obstacle's body sweeps, for a clearance that `clearances` found
  /// at these poses. When they overlap, and always for points, it is at most 0 and the normal is undefined. Does not
  /// allocate.
  [[nodiscard]] ShapeDistance sweep_distance(const Clearance& obstacle, const CellPoses& poses,
                                             const Sweep& sweep) const;

 private:
  struct Storage;
  std::unique_ptr<Storage> storage_;
};

/// Distance of one pair of shapes, for checks outside the tick. Prepares both shapes: allocates for convex hulls. Of
/// points, the nearest ball's. Throws std::logic_error for two clouds.
[[nodiscard]] ShapeDistance shape_distance(const world::Shape& a, const Pose& X_WA, const world::Shape& b,
                                           const Pose& X_WB);

/// The same for cores that the caller prepared with make_swept_core(). Does not allocate.
[[nodiscard]] ShapeDistance prepared_distance(const SweptCore& a, const Pose& X_WA, const SweptCore& b,
                                              const Pose& X_WB);

}  // namespace hecaton::planner
