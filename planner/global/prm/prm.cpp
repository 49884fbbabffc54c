#include "planner/global/prm/prm.hpp"

#include <algorithm>
#include <cmath>
#include <queue>

#include "planner/global/nearest_points.hpp"

namespace hecaton::planner::global {
namespace {

/// The roadmap of one query.
class Roadmap {
 public:
  Roadmap(const SearchProblem& problem, const PrmParameters& parameters)
      : problem_(problem),
        parameters_(parameters),
        space_(problem.space),
        nearest_(space_),
        points_(space_.stride),
        random_(problem.seed) {}

  /// Adds start and goal, and grows the roadmap until it contains a path between them. Returns the shortest one.
  SearchResult query() {
    const int start = find_or_add(problem_.start);
    const int goal = find_or_add(problem_.goal);
    std::vector<int> path = shortest(start, goal);
    while (path.empty() && !problem_.over(result_.iterations)) {
      grow();
      path = shortest(start, goal);
    }
    if (!path.empty()) {
      result_.status = PlanStatus::kSolved;
      result_.path = Points(space_.stride);
      for (const int node : path) result_.path.add(points_[node]);
      result_.path.unwrap(space_, problem_.start);
    }
    result_.nodes = points_.size();
    if (problem_.record != nullptr) *problem_.record = {points_, edges_};
    return std::move(result_);
  }

 private:
  struct Edge {
    int to;
    float length;  ///< in joint space
  };

  /// Adds a batch of free samples; one check tests eight samples.
  void grow() {
    std::vector<float> eight(static_cast<std::size_t>(kWidth) * space_.stride);
    const auto configuration = [&](int lane) {
      return eight.data() + static_cast<std::ptrdiff_t>(lane) * space_.stride;
    };
    for (int added = 0; added < parameters_.batch && !problem_.over(result_.iterations);) {
      for (int lane = 0; lane < kWidth; ++lane) space_.sample(random_, configuration(lane));
      const unsigned collisions = problem_.validity.collisions(eight.data());
      for (int lane = 0; lane < kWidth && !problem_.over(result_.iterations); ++lane) {
        ++result_.iterations;
        if ((collisions >> lane & 1U) != 0) continue;
        add(configuration(lane));
        ++added;
      }
    }
  }

  int find_or_add(const float* q) {
    const Neighbour near = nearest_.nearest(q);
    return near.index >= 0 && near.distance2 <= 0.0F ? near.index : add(q);
  }

  /// Adds a node and joins it with its nearest nodes where the edge is free.
  int add(const float* q) {
    std::vector<Neighbour> near;
    nearest_.nearest(q, parameters_.neighbours, near);
    const int node = points_.size();
    points_.add(q);
    nearest_.add(points_[node]);
    edges_of_.emplace_back();
    for (const Neighbour& other : near) {
      if (problem_.over(0)) break;
      const float* from = points_[other.index];
      if (!problem_.edge_free(from, space_.nearest_image(from, points_[node], image_))) continue;
      const float length = std::sqrt(other.distance2);
      edges_of_[node].push_back({other.index, length});
      edges_of_[other.index].push_back({node, length});
      edges_.emplace_back(other.index, node);
    }
    return node;
  }

  /// A* with the distance to the goal as heuristic, or Dijkstra.
  [[nodiscard]] std::vector<int> shortest(int start, int goal) const {
    struct Open {
      float bound;
      int node;
      bool operator>(const Open& other) const { return bound != other.bound ? bound > other.bound : node > other.node; }
    };
    const auto bound = [&](int node) {
      return parameters_.search == RoadmapSearch::kAStar ? space_.distance(points_[node], points_[goal]) : 0.0F;
    };
    std::vector<float> cost(points_.size(), HUGE_VALF);
    std::vector<int> before(points_.size(), -1);
    std::vector<bool> closed(points_.size(), false);
    std::priority_queue<Open, std::vector<Open>, std::greater<>> open;
    cost[start] = 0.0F;
    open.push({bound(start), start});
    while (!open.empty()) {
      const int node = open.top().node;
      open.pop();
      if (closed[node]) continue;
      closed[node] = true;
      if (node == goal) break;
      for (const auto& [next, length] : edges_of_[node]) {
        if (closed[next]) continue;
        const float along = cost[node] + length;
        if (along >= cost[next]) continue;
        cost[next] = along;
        before[next] = node;
        open.push({along + bound(next), next});
      }
    }
    if (!closed[goal]) return {};
    std::vector<int> path;
    for (int node = goal; node >= 0; node = before[node]) path.push_back(node);
    std::reverse(path.begin(), path.end());
    return path;
  }

  const SearchProblem& problem_;
  const PrmParameters& parameters_;
  const Space& space_;
  NearestPoints nearest_;
  Points points_;
  std::vector<std::vector<Edge>> edges_of_;  ///< by node
  std::vector<std::pair<int, int>> edges_;   ///< indices of nodes, in the order of creation
  Random random_;
  SearchResult result_;
  std::vector<float> image_;  ///< buffer of Space::nearest_image
};

}  // namespace

Prm::Prm(const PrmParameters& parameters)
    : GlobalPlanner({.name = "prm", .summary = "a roadmap of random configurations, and the shortest path in it"}),
      parameters_(parameters) {}

SearchResult Prm::search(const SearchProblem& problem) const {
  return Roadmap(problem, parameters_).query();
}

}  // namespace hecaton::planner::global
