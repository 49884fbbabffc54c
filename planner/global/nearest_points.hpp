#pragma once
/// Nearest neighbours in a growing set of points.

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "planner/global/nearest_kernel.hpp"
#include "planner/global/space.hpp"

namespace hecaton::planner::global {

/// Keeps the `count` > 0 nearest of the neighbours that it is offered.
class KNearest {
 public:
  KNearest(int count, std::vector<Neighbour>& out) : count_(static_cast<std::size_t>(count)), heap_(out) {
    heap_.clear();
  }

  /// Squared distance beyond which no neighbour is taken any more.
  [[nodiscard]] float limit() const { return heap_.size() < count_ ? HUGE_VALF : heap_.front().distance2; }
  void offer(const Neighbour& neighbour) {
    if (heap_.size() == count_) {
      if (!(neighbour < heap_.front())) return;
      std::pop_heap(heap_.begin(), heap_.end());
      heap_.back() = neighbour;
    } else {
      heap_.push_back(neighbour);
    }
    std::push_heap(heap_.begin(), heap_.end());
  }
  /// Sorts the output, nearest first.
  void sort() { std::sort_heap(heap_.begin(), heap_.end()); }

 private:
  std::size_t count_;
  std::vector<Neighbour>& heap_;
};

/// Points in groups of eight, searched exhaustively.
class PointGroups {
 public:
  explicit PointGroups(int dimensions) : dimensions_(dimensions) {}

  void add(const float* q);
  [[nodiscard]] int size() const { return size_; }
  [[nodiscard]] float coordinate(int i, int j) const {
    return groups_[static_cast<std::size_t>(i / kWidth * dimensions_ + j) * kWidth + i % kWidth];
  }
  /// The nearest point, the first one among equals; index −1 if there are no points.
  [[nodiscard]] Neighbour nearest(const float* q) const;
  /// The `count` > 0 nearest points, nearest first, or all if there are fewer. Among equals, smaller indices come
  /// first.
  void nearest(const float* q, int count, std::vector<Neighbour>& out) const;
  /// All points nearer than `radius`, by index.
  void within(const float* q, float radius, std::vector<Neighbour>& out) const;
  /// Squared distances of all points; `out` is padded to whole groups.
  void distances2(const float* q, std::vector<float>& out) const;

 private:
  int dimensions_;
  int size_ = 0;
  std::vector<float> groups_;  ///< coordinate by coordinate; padded with points far away
};

/// A k-d tree [Bentley75]: a bucket that overflows is split at the median of its widest coordinate. The tree grows with
/// each point and is never rebalanced, since points of trees and roadmaps come from the whole space. Results are equal
/// to those of PointGroups to the last bit. nanoflann's dynamic tree is 3 to 8 times slower
/// (docs/explanation/global-planning.md).
class KdTree {
 public:
  explicit KdTree(int dimensions);

  void add(const float* q);
  [[nodiscard]] int size() const { return size_; }
  [[nodiscard]] Neighbour nearest(const float* q) const;
  void nearest(const float* q, int count, std::vector<Neighbour>& out) const;
  void within(const float* q, float radius, std::vector<Neighbour>& out) const;

 private:
  struct Node {
    int axis = -1;  ///< −1: a leaf
    float cut = 0.0F;
    int below = -1;  ///< index into nodes_; of a leaf: into buckets_
    int above = -1;
  };
  struct Bucket {
    PointGroups points;
    std::vector<int> indices;
  };
  /// From the query to the box of the visited node, by coordinate.
  struct Offsets {
    float of[kMaxDimensions] = {};
  };

  void split(int node);
  /// Calls `look` for the buckets whose boxes are within limit(), a squared distance.
  template <typename Limit, typename Look>
  void visit(int node, const float* q, float bound, Offsets& offsets, const Limit& limit, const Look& look) const;

  int dimensions_;
  int size_ = 0;
  std::vector<Node> nodes_;
  std::vector<Bucket> buckets_;
};

/// Exhaustive for few points, a k-d tree for many; both give the same results to the last bit. In a periodic space,
/// points are wrapped to half a period about zero, and a query searches for its periodic images as well.
class NearestPoints {
 public:
  explicit NearestPoints(int dimensions) : dimensions_(dimensions), all_(dimensions) {}
  explicit NearestPoints(const Space& space)
      : dimensions_(space.dimensions), all_(space.dimensions), period_(space.period) {}

  void add(const float* q);
  [[nodiscard]] int size() const { return all_.size(); }
  /// The nearest point, the first one among equals; index −1 if there are no points.
  [[nodiscard]] Neighbour nearest(const float* q) const { return period_.empty() ? find(q) : nearest_of_images(q); }
  /// The `count` > 0 nearest points, nearest first, or all if there are fewer. Among equals, smaller indices come
  /// first.
  void nearest(const float* q, int count, std::vector<Neighbour>& out) const;
  /// All points nearer than `radius`, by index.
  void within(const float* q, float radius, std::vector<Neighbour>& out) const;

  /// Number of points from which the tree is faster, measured by `hecaton-bench-plan`
  /// (docs/explanation/global-planning.md).
  [[nodiscard]] static int tree_threshold(int dimensions);

 private:
  [[nodiscard]] Neighbour find(const float* q) const { return tree_ ? tree_->nearest(q) : all_.nearest(q); }
  void add_wrapped(const float* q);
  /// q with its continuous joints within half a period of zero.
  [[nodiscard]] std::vector<float> wrapped(const float* q) const;
  [[nodiscard]] Neighbour nearest_of_images(const float* q) const;
  /// Searches for the images of q that differ in coordinates from j on. `bound`: lower bound of their squared
  /// distances.
  void visit_images(int j, float bound, std::vector<float>& q, Neighbour& best) const;

  int dimensions_;
  PointGroups all_;
  std::optional<KdTree> tree_;
  std::vector<float> period_;  ///< Space::period
};

}  // namespace hecaton::planner::global
