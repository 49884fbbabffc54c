#include "planner/global/super_graph.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>
#include <unordered_map>

#include "planner/model/fnv1a.hpp"

namespace hecaton::planner::global {
namespace {

enum class Known : std::uint8_t { kNot, kFree, kBlocked };

/// What is known of one arm at its nodes or on its edges, and another one at its nodes.
class Table {
 public:
  Table() = default;
  Table(std::size_t rows, std::size_t columns) : columns_(columns), known_(rows * columns, Known::kNot) {}
  [[nodiscard]] Known& at(int row, int column) {
    return known_[static_cast<std::size_t>(row) * columns_ + static_cast<std::size_t>(column)];
  }

 private:
  std::size_t columns_ = 0;
  std::vector<Known> known_;
};

using Places = std::vector<std::uint16_t>;  // a node for each arm

struct PlacesHash {
  std::size_t operator()(const Places& places) const {
    Fnv1a hash;
    for (const std::uint16_t place : places) hash.add(place);
    return hash.value();
  }
};

struct Vertex {
  const Places* places = nullptr;
  float cost = std::numeric_limits<float>::infinity();
  int parent = -1;
  bool closed = false;
};

struct Open {
  float bound;
  int vertex;
  bool operator>(const Open& other) const { return bound != other.bound ? bound > other.bound : vertex > other.vertex; }
};

}  // namespace

SuperGraph::SuperGraph(const std::vector<CellGeometry>& planned, const ValidityOptions& options) {
  const std::span<const WorldBody> nothing;
  for (const CellGeometry& geometry : planned) {
    alone_.push_back(std::make_unique<Validity>(std::vector{geometry}, nothing, options));
  }
  pairs_.resize(planned.size() * planned.size());
  for (std::size_t i = 0; i < planned.size(); ++i) {
    for (std::size_t k = i + 1; k < planned.size(); ++k) {
      pairs_[i * planned.size() + k] =
          std::make_unique<Validity>(std::vector{planned[i], planned[k]}, nothing, options);
    }
  }
}

void SuperGraph::set_world(std::span<const WorldBody> world) {
  for (const auto& validity : alone_) validity->set_world(world);
}

std::uint64_t SuperGraph::checks() const {
  std::uint64_t sum = 0;
  for (const auto& validity : alone_) sum += validity->checks();
  for (const auto& validity : pairs_) sum += validity ? validity->checks() : 0;
  return sum;
}

/// Of one question.
class SuperGraph::Search {
 public:
  Search(const SuperGraph& graph, std::span<const double> start, std::span<const double> goal, std::uint64_t seed,
         const SuperGraphOptions& options)
      : graph_(graph), options_(options), most_checks_(graph.checks() + options.checks) {
    Random random(seed);
    std::size_t first = 0;
    for (const auto& validity : graph.alone_) {
      const auto joints = static_cast<std::size_t>(validity->dimensions());
      const auto from = start.subspan(first, joints);
      const auto to = goal.subspan(first, joints);
      std::vector<float> a(validity->stride(), 0.0F);
      std::vector<float> b(validity->stride(), 0.0F);
      for (std::size_t j = 0; j < joints; ++j) {
        a[j] = static_cast<float>(from[j]);
        b[j] = static_cast<float>(to[j]);
      }
      roadmaps_.emplace_back(*validity, a.data(), b.data(), space_of(*validity, from, to), random.next());
      first += joints;
    }
  }

  void grow(int nodes) {
    for (ArmRoadmap& roadmap : roadmaps_) roadmap.grow(nodes, options_.samples, options_.neighbours);
  }

  /// The vertices from start to goal, over the roadmaps as they are; empty: there is no way, or the budget is over.
  std::vector<Places> run(std::uint64_t& iterations) {
    if (!prepare()) return {};
    const Places start(roadmaps_.size(), 0);
    const Places goal(roadmaps_.size(), 1);
    const int first = find(start);
    vertices_[first].cost = 0.0F;
    open_.push({0.0F, first});
    while (!open_.empty() && !over(iterations)) {
      const int at = open_.top().vertex;
      open_.pop();
      if (vertices_[at].closed) continue;
      vertices_[at].closed = true;
      if (*vertices_[at].places == goal) return way_to(at);
      ++iterations;
      expand(at);
    }
    return {};
  }

  [[nodiscard]] bool over(std::uint64_t iterations) const {
    return iterations >= options_.expansions || graph_.checks() >= most_checks_;
  }

  [[nodiscard]] std::vector<double> joined(const Places& places) const {
    std::vector<double> q;
    for (std::size_t i = 0; i < roadmaps_.size(); ++i) {
      const float* own = roadmaps_[i][places[i]];
      q.insert(q.end(), own, own + roadmaps_[i].space().dimensions);
    }
    return q;
  }

 private:
  /// False: some arm has no way to its goal even without the others.
  bool prepare() {
    const std::size_t arms = roadmaps_.size();
    to_come_.clear();
    for (const ArmRoadmap& roadmap : roadmaps_) {
      to_come_.push_back(roadmap.distances_to_goal());
      if (std::isinf(to_come_.back().front())) return false;
    }
    index_.clear();
    vertices_.clear();
    open_ = {};
    at_nodes_.assign(arms * arms, {});
    on_edges_.assign(arms * arms, {});
    for (std::size_t i = 0; i < arms; ++i) {
      for (std::size_t k = 0; k < arms; ++k) {
        if (i == k) continue;
        const auto nodes = static_cast<std::size_t>(roadmaps_[k].nodes());
        if (i < k) at_nodes_[i * arms + k] = Table(static_cast<std::size_t>(roadmaps_[i].nodes()), nodes);
        on_edges_[i * arms + k] = Table(roadmaps_[i].edges().size(), nodes);
      }
    }
    return true;
  }

  int find(const Places& places) {
    const auto [entry, is_new] = index_.try_emplace(places, static_cast<int>(vertices_.size()));
    if (is_new) vertices_.push_back({&entry->first, std::numeric_limits<float>::infinity(), -1, false});
    return entry->second;
  }

  void expand(int at) {
    Places places = *vertices_[at].places;
    const float cost = vertices_[at].cost;
    for (std::size_t i = 0; i < roadmaps_.size(); ++i) {
      const int from = places[i];
      for (const int edge : roadmaps_[i].edges_of(from)) {
        const int to = roadmaps_[i].other_end(edge, from);
        if (!may_go(static_cast<int>(i), edge, to, places)) continue;
        places[i] = static_cast<std::uint16_t>(to);
        const int next = find(places);
        const float along = cost + roadmaps_[i].edges()[edge].length;
        if (!vertices_[next].closed && along < vertices_[next].cost) {
          vertices_[next].cost = along;
          vertices_[next].parent = at;
          open_.push({along + static_cast<float>(options_.weight) * to_come(places), next});
        }
      }
      places[i] = static_cast<std::uint16_t>(from);
    }
  }

  [[nodiscard]] float to_come(const Places& places) const {
    float sum = 0.0F;
    for (std::size_t i = 0; i < places.size(); ++i) sum += to_come_[i][places[i]];
    return sum;
  }

  /// Arm i along an edge to its end, among all others.
  bool may_go(int i, int edge, int to, const Places& places) {
    for (int k = 0; k < graph_.arms(); ++k) {
      if (k != i && !(free_at(i, to, k, places[k]) && free_on(i, edge, k, places[k]))) return false;
    }
    return true;
  }

  bool free_at(int i, int node, int k, int place) {
    if (i > k) return free_at(k, place, i, node);
    Known& known = at_nodes_[static_cast<std::size_t>(i * graph_.arms() + k)].at(node, place);
    if (known == Known::kNot) {
      const Validity& validity = graph_.pair(i, k);
      const std::vector<float> q = both(validity, i, node, k, place);
      known = validity.state_free(q.data()) ? Known::kFree : Known::kBlocked;
    }
    return known == Known::kFree;
  }

  bool free_on(int i, int edge, int k, int place) {
    Known& known = on_edges_[static_cast<std::size_t>(i * graph_.arms() + k)].at(edge, place);
    if (known == Known::kNot) {
      const Validity& validity = graph_.pair(std::min(i, k), std::max(i, k));
      const ArmRoadmap::Edge& way = roadmaps_[i].edges()[edge];
      const std::vector<float> a = both(validity, i, way.a, k, place);
      const std::vector<float> b = both(validity, i, way.b, k, place);
      known = validity.edge_free(a.data(), b.data()) ? Known::kFree : Known::kBlocked;
    }
    return known == Known::kFree;
  }

  /// The configuration of arms i and k, the one with the lower index first.
  [[nodiscard]] std::vector<float> both(const Validity& validity, int i, int node_i, int k, int node_k) const {
    if (i > k) return both(validity, k, node_k, i, node_i);
    std::vector<float> q(validity.stride(), 0.0F);
    const int joints = roadmaps_[i].space().dimensions;
    std::copy_n(roadmaps_[i][node_i], joints, q.begin());
    std::copy_n(roadmaps_[k][node_k], roadmaps_[k].space().dimensions, q.begin() + joints);
    return q;
  }

  [[nodiscard]] std::vector<Places> way_to(int at) const {
    std::vector<Places> way;
    for (; at >= 0; at = vertices_[at].parent) way.push_back(*vertices_[at].places);
    std::reverse(way.begin(), way.end());
    return way;
  }

  const SuperGraph& graph_;
  const SuperGraphOptions& options_;
  std::uint64_t most_checks_;
  std::vector<ArmRoadmap> roadmaps_;
  std::vector<std::vector<float>> to_come_;  ///< by arm and node, without the others [rad | m]
  std::vector<Table> at_nodes_;              ///< by arms i < k: both at nodes
  std::vector<Table> on_edges_;              ///< by arms i, k: i on an edge, k at a node
  std::unordered_map<Places, int, PlacesHash> index_;
  std::vector<Vertex> vertices_;
  std::priority_queue<Open, std::vector<Open>, std::greater<>> open_;
};

Plan SuperGraph::plan(std::span<const double> start, std::span<const double> goal, std::uint64_t seed,
                      const SuperGraphOptions& options) {
  Plan result;
  const std::uint64_t checks_before = checks();
  Search search(*this, start, goal, seed, options);
  std::vector<Places> way;
  int nodes = options.nodes;
  for (int i = 0; i <= options.doublings && way.empty() && !search.over(result.iterations); ++i, nodes *= 2) {
    search.grow(nodes);
    result.nodes = nodes;
    way = search.run(result.iterations);
  }
  result.checks = checks() - checks_before;
  if (way.empty()) {
    result.reason = "no way was found over the arms' roadmaps";
    return result;
  }
  result.status = PlanStatus::kSolved;
  for (const Places& places : way) result.path.push_back(search.joined(places));
  result.path.front().assign(start.begin(), start.end());
  result.path.back().assign(goal.begin(), goal.end());
  return result;
}

}  // namespace hecaton::planner::global
