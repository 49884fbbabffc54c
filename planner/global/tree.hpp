#pragma once
/// A tree of configurations with its nearest-neighbour search.

#include <limits>
#include <vector>

#include "planner/global/global_planner.hpp"
#include "planner/global/nearest_points.hpp"

namespace hecaton::planner::global {

/// Outcome of EXTEND [LaValle01] ([Cardenas10] fig. 9).
enum class Extend { kTrapped, kAdvanced, kReached };

/// Grows from its root; nodes are never removed.
class Tree {
 public:
  Tree(const Space& space, const float* root) : points_(space.stride), nearest_(space) { add(root, -1); }

  /// Returns the index of the new node.
  int add(const float* q, int parent) {
    points_.add(q);
    nearest_.add(points_[points_.size() - 1]);
    parents_.push_back(parent);
    domains_.push_back(std::numeric_limits<float>::infinity());
    return points_.size() - 1;
  }
  [[nodiscard]] int size() const { return points_.size(); }
  [[nodiscard]] const float* operator[](int i) const { return points_[i]; }
  [[nodiscard]] int parent(int i) const { return parents_[i]; }
  [[nodiscard]] Neighbour nearest(const float* q) const { return nearest_.nearest(q); }
  void within(const float* q, float radius, std::vector<Neighbour>& out) const { nearest_.within(q, radius, out); }

  /// Radius of the node's dynamic domain [Yershova05]: samples farther away do not extend it.
  [[nodiscard]] float domain(int i) const { return domains_[i]; }
  void set_domain(int i, float radius) { domains_[i] = radius; }

  /// Appends nodes and edges to `out`.
  void record(SearchRecord& out) const {
    if (out.nodes.stride() != points_.stride()) out.nodes = Points(points_.stride());
    const int first = out.nodes.size();
    for (int i = 0; i < size(); ++i) {
      out.nodes.add(points_[i]);
      if (parents_[i] >= 0) out.edges.emplace_back(first + parents_[i], first + i);
    }
  }

  /// The points from node i to the root.
  [[nodiscard]] Points path_to_root(int i) const {
    Points path(points_.stride());
    for (; i >= 0; i = parents_[i]) path.add(points_[i]);
    return path;
  }

 private:
  Points points_;
  NearestPoints nearest_;
  std::vector<int> parents_;
  std::vector<float> domains_;
};

}  // namespace hecaton::planner::global
