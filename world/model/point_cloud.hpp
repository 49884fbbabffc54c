#pragma once
/// Balls of one radius about many points, such as those that a depth camera sees, with a tree to search them.

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "world/model/point_nodes.hpp"

namespace hecaton::world {

/// An axis-aligned box [m].
struct PointBox {
  float low[3];
  float high[3];
};

/// Immutable, therefore safe to share between threads. Single precision keeps a coordinate within 6·10⁻⁸ of its value.
class PointCloud {
 public:
  static constexpr std::size_t kMostPoints = 100'000;

  /// Points in the frame S of the shape [m], in any order: the result does not depend on it. Drops repeated points.
  /// Throws std::invalid_argument with a sentence when there are none or too many, when a coordinate is not finite, or
  /// when the radius [m] is not finite and above 0.
  PointCloud(std::vector<Eigen::Vector3f> points, double radius);

  [[nodiscard]] double radius() const { return radius_; }  ///< of the balls [m]
  [[nodiscard]] std::size_t size() const { return points_.size(); }
  [[nodiscard]] std::span<const Eigen::Vector3f> points() const { return points_; }  ///< leaf by leaf
  /// The box around the points, without the balls.
  [[nodiscard]] const PointBox& box() const { return box_; }
  [[nodiscard]] Eigen::Vector3d centre() const { return centre_; }           ///< of the box [m]
  [[nodiscard]] double bounding_radius() const { return bounding_radius_; }  ///< of a ball about it around all balls

  [[nodiscard]] std::span<const PointNode> nodes() const { return nodes_; }  ///< the first one is the root
  [[nodiscard]] std::span<const PointLeaf> leaves() const { return leaves_; }

 private:
  /// Makes the node of points [first, end) and those below. Returns what names it in `child`.
  int build(int first, int end);
  int make_leaf(int first, int end);
  void put_child(int node, int place, int child, const PointBox& box);
  [[nodiscard]] PointBox box_of(int first, int end) const;

  double radius_;
  std::vector<Eigen::Vector3f> points_;
  std::vector<PointNode> nodes_;
  std::vector<PointLeaf> leaves_;
  PointBox box_{};
  Eigen::Vector3d centre_;
  double bounding_radius_ = 0.0;
};

/// Squared gaps between a box and those of the node's children, rounded down [m²].
void squared_gaps(const PointNode& node, const PointBox& box, float (&out)[kPointFan]);

}  // namespace hecaton::world
