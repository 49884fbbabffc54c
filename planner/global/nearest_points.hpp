#pragma once
/// The nearest of a growing set of points, by what is fastest at its size.

#include <optional>

#include "planner/global/kd_tree.hpp"
#include "planner/global/space.hpp"

namespace hecaton::planner::global {

/// Compares all of them while they are few, and goes by a tree when they are many: both say the same to the last bit.
/// In a closed space points are kept within half a turn of zero, and each is asked for from both sides: a query beyond
/// half a turn away from one is within that, a turn aside.
class NearestPoints {
 public:
  explicit NearestPoints(int dimensions) : dimensions_(dimensions), all_(dimensions) {}
  explicit NearestPoints(const Space& space)
      : dimensions_(space.dimensions), all_(space.dimensions), turns_(space.turns) {}

  void add(const float* q);
  [[nodiscard]] int size() const { return all_.size(); }
  /// The first of the nearest; none (−1) of no points.
  [[nodiscard]] Neighbour nearest(const float* q) const { return turns_.empty() ? ask(q) : nearest_of_copies(q); }
  /// The `count` > 0 nearest, or all where there are fewer: nearest first, of those just as near the first.
  void nearest(const float* q, int count, std::vector<Neighbour>& out) const;
  /// All points nearer than `radius`, in the order of their indices.
  void within(const float* q, float radius, std::vector<Neighbour>& out) const;

  /// From so many points on a tree is faster, as measured by `hecaton-bench-plan` (docs/global-planning.md).
  [[nodiscard]] static int worth_a_tree(int dimensions);

 private:
  [[nodiscard]] Neighbour ask(const float* q) const { return tree_ ? tree_->nearest(q) : all_.nearest(q); }
  void add_plain(const float* q);
  /// q with its turning joints within half a turn of zero.
  [[nodiscard]] std::vector<float> near_zero(const float* q) const;
  [[nodiscard]] Neighbour nearest_of_copies(const float* q) const;
  /// The copies of q a turn aside along joints from j on; nothing is nearer to them than by the root of `bound`.
  void visit_copies(int j, float bound, std::vector<float>& q, Neighbour& best) const;

  int dimensions_;
  PointGroups all_;
  std::optional<KdTree> tree_;
  std::vector<float> turns_;  ///< Space::turns
};

}  // namespace hecaton::planner::global
