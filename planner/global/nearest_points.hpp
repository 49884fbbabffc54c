#pragma once
/// The nearest of a growing set of points, by what is fastest at its size.

#include <optional>

#include "planner/global/kd_tree.hpp"

namespace hecaton::planner::global {

/// Compares all of them while they are few, and goes by a tree when they are many: both say the same to the last bit.
class NearestPoints {
 public:
  explicit NearestPoints(int dimensions) : dimensions_(dimensions), all_(dimensions) {}

  void add(const float* q);
  [[nodiscard]] int size() const { return all_.size(); }
  /// The first of the nearest; none (−1) of no points.
  [[nodiscard]] Neighbour nearest(const float* q) const { return tree_ ? tree_->nearest(q) : all_.nearest(q); }
  /// The `count` > 0 nearest, or all where there are fewer: nearest first, of those just as near the first.
  void nearest(const float* q, int count, std::vector<Neighbour>& out) const {
    tree_ ? tree_->nearest(q, count, out) : all_.nearest(q, count, out);
  }
  /// All points nearer than `radius`, in the order of their indices.
  void within(const float* q, float radius, std::vector<Neighbour>& out) const {
    tree_ ? tree_->within(q, radius, out) : all_.within(q, radius, out);
  }

  /// From so many points on a tree is faster, as measured by `hecaton-bench-plan` (docs/global-planning.md).
  [[nodiscard]] static int worth_a_tree(int dimensions);

 private:
  int dimensions_;
  PointGroups all_;
  std::optional<KdTree> tree_;
};

}  // namespace hecaton::planner::global
