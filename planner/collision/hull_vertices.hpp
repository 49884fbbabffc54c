#pragma once
/// The vertices of a convex polyhedron, laid out for the one question that GJK asks of them thousands of times a pass:
/// which is farthest along a direction?

#include <span>
#include <vector>

#include <Eigen/Core>

namespace hecaton::planner {

/// All vertices are compared, four at a time: no adjacency to trust, no worst case, and for the few dozen vertices
/// that a link's hull has, faster than walking its edges. Same result with and without AVX2.
class HullVertices {
 public:
  HullVertices() = default;
  explicit HullVertices(std::span<const Eigen::Vector3d> vertices);

  /// A vertex [m] with the greatest n·v; the first in order of four interleaved lists when several are. Not for an
  /// empty list.
  [[nodiscard]] Eigen::Vector3d farthest(const Eigen::Vector3d& n) const;

 private:
  std::vector<double> x_;  // padded to whole groups of four with copies of the first vertex
  std::vector<double> y_;
  std::vector<double> z_;
};

}  // namespace hecaton::planner
