#pragma once
/// Exact signed distances with nearest points between all kinds of shapes, and the planner's distance pass over them.

#include <memory>
#include <span>

#include "planner/collision/cell_geometry.hpp"
#include "planner/collision/convex_distance.hpp"
#include "planner/collision/pass_input.hpp"
#include "planner/collision/shape_distance.hpp"

namespace hecaton::planner {

/// The distance pass of one CellGeometry: pairs, prepared shapes and scratch storage, one per thread.
/// Rebuild after set_obstacles(). `clearances` does not allocate.
///
/// Accuracy: spheres and capsules against each other and against boxes, and spheres against cylinders, are exact up to
/// rounding, others within 1e-6 m. No clearance is larger than the true one, but for rounding. Nearest points lie on
/// the shapes within 1e-6 m, with a cylinder within 1e-4 m.
class ExactDistance {
 public:
  /// `kernel`: one of the compilations in pass_kernels.hpp, to compare them.
  explicit ExactDistance(const CellGeometry& geometry, PassKernel kernel = fastest_pass());
  ~ExactDistance();
  ExactDistance(ExactDistance&&) noexcept;
  ExactDistance& operator=(ExactDistance&&) noexcept;

  /// Takes over a changed geometry (obstacles added, removed, attached). Allocates.
  void rebuild(const CellGeometry& geometry);

  /// All pairs that are nearer than their influence distance, with nearest points, ordered: self pairs, then other
  /// bodies in cell order, each with own bodies in order. Writes at most out.size(); when more are near, the nearest
  /// ones are kept. Returns how many. A function of its arguments alone.
  /// Own bodies that no joint moves appear only against moving bodies of other arms: no own motion changes those.
  int clearances(const CellPoses& poses, const InfluenceDistances& influence, std::span<Clearance> out);

  /// Of the own body from all that the obstacle's body sweeps, for a clearance that `clearances` found at these poses.
  /// Not above 0 where they overlap: then the normal is none. Does not allocate.
  [[nodiscard]] ShapeDistance sweep_distance(const Clearance& obstacle, const CellPoses& poses,
                                             const Sweep& sweep) const;

 private:
  struct Storage;
  std::unique_ptr<Storage> storage_;
};

/// One pair, for tests, checks and goal validation. Prepares both shapes: allocates for convex hulls.
[[nodiscard]] ShapeDistance shape_distance(const world::Shape& a, const Pose& X_WA, const world::Shape& b,
                                           const Pose& X_WB);

}  // namespace hecaton::planner
