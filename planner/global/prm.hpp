#pragma once
/// Probabilistic roadmaps [Kavraki96]: many queries share what was learnt about the free space.

#include <cstdint>
#include <vector>

#include "planner/global/nearest_points.hpp"
#include "planner/global/search.hpp"

namespace hecaton::planner::global {

/// A roadmap of one robot, kept between queries. When something in the world has moved, nothing is thrown away: nodes
/// and edges are looked at again when a path is to use them.
class Roadmap {
 public:
  explicit Roadmap(Space space) : space_(std::move(space)), nearest_(space_), points_(space_.stride) {}

  /// The world of the validity that queries are given is another one from now on.
  void world_changed() { ++edition_; }

  /// The shortest way over the roadmap from start to goal, which become nodes of it; it grows until there is one. The
  /// problem's space must be the roadmap's.
  [[nodiscard]] SearchResult query(const SearchProblem& problem, const PrmOptions& options = {});

  [[nodiscard]] int nodes() const { return points_.size(); }
  [[nodiscard]] int edges() const { return static_cast<int>(edges_.size()); }
  [[nodiscard]] const Points& points() const { return points_; }
  /// Its nodes, and its edges that are not known to be blocked.
  void record(SearchRecord& out) const;

 private:
  /// What is known of a node or an edge, and of which edition of the world.
  struct Known {
    std::uint64_t edition = 0;
    bool free = true;
  };
  struct Edge {
    int a;
    int b;
    float length;  ///< in joint space
    Known known;
  };

  int add(const float* q, const SearchProblem& problem, const PrmOptions& options);
  void grow(const SearchProblem& problem, const PrmOptions& options, Random& random, SearchResult& result);
  [[nodiscard]] int find_or_add(const float* q, const SearchProblem& problem, const PrmOptions& options);
  /// Nodes from start to goal over what is not known to be blocked; empty: none.
  [[nodiscard]] std::vector<int> shortest(int start, int goal, RoadmapSearch search) const;
  [[nodiscard]] bool blocked(const Known& known) const { return known.edition == edition_ && !known.free; }
  /// Looks at what of the way was not seen in this edition of the world. True when all of it is free.
  bool confirm(const std::vector<int>& way, const SearchProblem& problem);
  [[nodiscard]] bool edge_free(int a, int b, const SearchProblem& problem) const {
    return problem.edge_free(points_[a], space_.beside(points_[a], points_[b], place_));
  }
  [[nodiscard]] Edge& edge_between(int a, int b);

  Space space_;
  NearestPoints nearest_;
  Points points_;
  std::vector<Known> nodes_;
  std::vector<Edge> edges_;
  std::vector<std::vector<int>> edges_of_;  ///< by node: indices of edges_
  std::uint64_t edition_ = 1;
  mutable std::vector<float> place_;  ///< for Space::beside
};

}  // namespace hecaton::planner::global
