#pragma once
/// The nearest of many points, by a tree over them.

#include <vector>

#include "planner/global/nearest.hpp"

namespace hecaton::planner::global {

/// Points in buckets that are cut in halves at the median of their widest coordinate when they overflow [Bentley75].
/// Built as points come; not balanced again: those of trees and roadmaps come from all over the space. Not nanoflann:
/// its dynamic tree takes 3 to 8 times as long for a query (docs/global-planning.md), and among points just as near it
/// does not name the first.
class KdTree {
 public:
  explicit KdTree(int dimensions);

  void add(const float* q);
  [[nodiscard]] int size() const { return size_; }
  /// The first of the nearest; none (−1) of no points. As the scan of NearestPoints says it, to the last bit.
  [[nodiscard]] Neighbour nearest(const float* q) const;
  /// The same of the `count` > 0 nearest, or of all where there are fewer: nearest first.
  void nearest(const float* q, int count, std::vector<Neighbour>& out) const;
  /// The same of all points nearer than `radius`: in the order of their indices.
  void within(const float* q, float radius, std::vector<Neighbour>& out) const;

 private:
  struct Node {
    int axis = -1;  ///< −1: a bucket
    float cut = 0.0F;
    int below = -1;  ///< index of nodes_; of a bucket: of buckets_
    int above = -1;
  };
  struct Bucket {
    PointGroups points;
    std::vector<int> indices;
  };
  /// From a query to the box of the node that is visited, by coordinate.
  struct Offsets {
    float of[kMostDimensions] = {};
  };

  void split(int node);
  /// Has `look` look at the buckets whose boxes are no farther than limit(), the square of a distance.
  template <typename Limit, typename Look>
  void visit(int node, const float* q, float bound, Offsets& offsets, const Limit& limit, const Look& look) const;

  int dimensions_;
  int size_ = 0;
  std::vector<Node> nodes_;
  std::vector<Bucket> buckets_;
};

}  // namespace hecaton::planner::global
