#pragma once
/// One arm's ways through the standing world, in its own joint space: what a search for several arms goes by.

#include <cstdint>
#include <vector>

#include "planner/global/space.hpp"
#include "planner/global/validity.hpp"

namespace hecaton::planner::global {

class ArmRoadmap {
 public:
  struct Edge {
    int a;
    int b;
    float length;  ///< in joint space [rad | m]
  };

  /// Node 0 is `start`, node 1 `goal`: both free. `validity`: of this arm alone; it must outlive the roadmap.
  ArmRoadmap(const Validity& validity, const float* start, const float* goal, Space space, std::uint64_t seed);

  /// Until it has `nodes` nodes, with at most so many samples more. Of several free samples the one that is farthest
  /// from all nodes becomes one: few nodes are to be everywhere. Each is joined with its `neighbours` nearest, as far
  /// as the straight ways are free.
  void grow(int nodes, std::uint64_t samples, int neighbours);

  [[nodiscard]] int nodes() const { return points_.size(); }
  [[nodiscard]] const float* operator[](int node) const { return points_[node]; }
  [[nodiscard]] const std::vector<Edge>& edges() const { return edges_; }
  /// Indices of edges().
  [[nodiscard]] const std::vector<int>& edges_of(int node) const { return edges_of_[node]; }
  [[nodiscard]] int other_end(int edge, int node) const {
    return edges_[edge].a == node ? edges_[edge].b : edges_[edge].a;
  }
  /// Of every node, along the roadmap [rad | m]; infinite: there is no way.
  [[nodiscard]] std::vector<float> distances_to_goal() const;
  [[nodiscard]] const Space& space() const { return space_; }

 private:
  void add(const float* q, int neighbours);
  /// Squared.
  [[nodiscard]] float nearest(const float* q) const;

  const Validity& validity_;
  Space space_;
  Random random_;
  Points points_;
  std::vector<Edge> edges_;
  std::vector<std::vector<int>> edges_of_;
};

}  // namespace hecaton::planner::global
