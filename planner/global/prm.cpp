#include "planner/global/prm.hpp"

#include <algorithm>
#include <cmath>
#include <queue>

namespace hecaton::planner::global {

SearchResult prm(const SearchProblem& problem, const PrmOptions& options) {
  return Roadmap(problem.space).query(problem, options);
}

SearchResult Roadmap::query(const SearchProblem& problem, const PrmOptions& options) {
  SearchResult result;
  Random random(problem.seed + static_cast<std::uint64_t>(nodes()));  // a roadmap that grows draws new samples
  const int start = find_or_add(problem.start, problem, options);
  const int goal = find_or_add(problem.goal, problem, options);
  while (true) {
    const std::vector<int> way = shortest(start, goal, options.search);
    if (way.empty()) {
      if (problem.over(result.iterations)) break;
      grow(problem, options, random, result);
    } else if (confirm(way, problem)) {
      result.solved = true;
      result.path = Points(space_.stride);
      for (const int node : way) result.path.add(points_[node]);
      result.path.join_turns(space_, problem.start);
      break;
    }
  }
  result.nodes = nodes();
  if (problem.record != nullptr) record(*problem.record);
  return result;
}

void Roadmap::record(SearchRecord& out) const {
  out.nodes = points_;
  out.edges.clear();
  for (const Edge& edge : edges_) {
    if (!blocked(edge.known)) out.edges.emplace_back(edge.a, edge.b);
  }
}

/// A batch of free samples: each lane of a check is another one.
void Roadmap::grow(const SearchProblem& problem, const PrmOptions& options, Random& random, SearchResult& result) {
  std::vector<float> eight(static_cast<std::size_t>(kWidth) * space_.stride);
  const auto configuration = [&](int lane) { return eight.data() + static_cast<std::ptrdiff_t>(lane) * space_.stride; };
  for (int added = 0; added < options.batch && !problem.over(result.iterations);) {
    for (int lane = 0; lane < kWidth; ++lane) space_.sample(random, configuration(lane));
    const unsigned collisions = problem.validity.collisions(eight.data());
    for (int lane = 0; lane < kWidth && !problem.over(result.iterations); ++lane) {
      ++result.iterations;
      if ((collisions >> lane & 1U) != 0) continue;
      add(configuration(lane), problem, options);
      ++added;
    }
  }
}

int Roadmap::find_or_add(const float* q, const SearchProblem& problem, const PrmOptions& options) {
  const Neighbour near = nearest_.nearest(q);
  if (near.index >= 0 && near.distance2 <= 0.0F) {
    nodes_[near.index] = {edition_, true};  // problems begin and end where it is free
    return near.index;
  }
  return add(q, problem, options);
}

/// Joined with its nearest nodes, as far as the straight ways are free now.
int Roadmap::add(const float* q, const SearchProblem& problem, const PrmOptions& options) {
  std::vector<Neighbour> near;
  nearest_.nearest(q, options.neighbours, near);
  const int node = nodes();
  points_.add(q);
  nearest_.add(points_[node]);
  nodes_.push_back({edition_, true});
  edges_of_.emplace_back();
  for (const Neighbour& other : near) {
    if (problem.over(0)) break;
    const bool free = edge_free(other.index, node, problem);
    // A blocked one is kept, too: what blocks it may go.
    edges_of_[node].push_back(edges());
    edges_of_[other.index].push_back(edges());
    edges_.push_back({other.index, node, std::sqrt(other.distance2), {edition_, free}});
  }
  return node;
}

/// A* with the distance to the goal as its bound, or Dijkstra without.
std::vector<int> Roadmap::shortest(int start, int goal, RoadmapSearch search) const {
  struct Open {
    float bound;
    int node;
    bool operator>(const Open& other) const { return bound != other.bound ? bound > other.bound : node > other.node; }
  };
  const auto bound = [&](int node) {
    return search == RoadmapSearch::kAStar ? space_.distance(points_[node], points_[goal]) : 0.0F;
  };
  std::vector<float> cost(nodes(), HUGE_VALF);
  std::vector<int> before(nodes(), -1);
  std::vector<bool> closed(nodes(), false);
  std::priority_queue<Open, std::vector<Open>, std::greater<>> open;
  cost[start] = 0.0F;
  open.push({bound(start), start});
  while (!open.empty()) {
    const int node = open.top().node;
    open.pop();
    if (closed[node]) continue;
    closed[node] = true;
    if (node == goal) break;
    for (const int index : edges_of_[node]) {
      const Edge& edge = edges_[index];
      const int next = edge.a == node ? edge.b : edge.a;
      if (closed[next] || blocked(edge.known) || blocked(nodes_[next])) continue;
      const float along = cost[node] + edge.length;
      if (along >= cost[next]) continue;
      cost[next] = along;
      before[next] = node;
      open.push({along + bound(next), next});
    }
  }
  if (!closed[goal]) return {};
  std::vector<int> way;
  for (int node = goal; node >= 0; node = before[node]) way.push_back(node);
  std::reverse(way.begin(), way.end());
  return way;
}

bool Roadmap::confirm(const std::vector<int>& way, const SearchProblem& problem) {
  for (const int node : way) {
    Known& known = nodes_[node];
    if (known.edition != edition_) known = {edition_, problem.validity.state_free(points_[node])};
    if (!known.free) return false;
  }
  for (std::size_t i = 0; i + 1 < way.size(); ++i) {
    Edge& edge = edge_between(way[i], way[i + 1]);
    if (edge.known.edition != edition_) edge.known = {edition_, edge_free(edge.a, edge.b, problem)};
    if (!edge.known.free) return false;
  }
  return true;
}

Roadmap::Edge& Roadmap::edge_between(int a, int b) {
  const auto& of_a = edges_of_[a];
  return edges_[*std::find_if(of_a.begin(), of_a.end(), [&](int i) { return edges_[i].a == b || edges_[i].b == b; })];
}

}  // namespace hecaton::planner::global
