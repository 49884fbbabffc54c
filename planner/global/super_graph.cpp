#include "planner/global/super_graph.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <queue>
#include <unordered_map>
#include <utility>

#include "planner/model/fnv1a.hpp"

namespace hecaton::planner::global {
namespace {

/// Free samples from which a new node is chosen.
constexpr int kCandidates = 4;

/// A roadmap of one arm in its own joint space, in the world without the other arms.
class ArmRoadmap {
 public:
  struct Edge {
    int a;
    int b;
    float length;  ///< in joint space [rad | m]
  };

  /// Node 0 is `start`, node 1 is `goal`; both must be free. `validity`: of this arm alone; must outlive the roadmap.
  ArmRoadmap(const Validity& validity, const float* start, const float* goal, Space space, std::uint64_t seed);

  /// Adds nodes until there are `nodes`, with at most `samples` samples. Of several free samples, the one farthest from
  /// all nodes becomes a node, so that few nodes cover the space. Each is joined with its `neighbours` nearest nodes if
  /// the edge is free.
  void grow(int nodes, std::uint64_t samples, int neighbours);

  [[nodiscard]] int nodes() const { return points_.size(); }
  [[nodiscard]] const float* operator[](int node) const { return points_[node]; }
  [[nodiscard]] const std::vector<Edge>& edges() const { return edges_; }
  /// Indices of edges().
  [[nodiscard]] const std::vector<int>& edges_of(int node) const { return edges_of_[node]; }
  [[nodiscard]] int other_end(int edge, int node) const {
    return edges_[edge].a == node ? edges_[edge].b : edges_[edge].a;
  }
  /// Path length from each node to the goal [rad | m]; infinite if there is no path.
  [[nodiscard]] std::vector<float> distances_to_goal() const;
  [[nodiscard]] const Space& space() const { return space_; }

 private:
  void add(const float* q, int neighbours);
  /// Distance of q from the nearest node.
  [[nodiscard]] float nearest(const float* q) const;

  const Validity& validity_;
  Space space_;
  Random random_;
  Points points_;
  std::vector<Edge> edges_;
  std::vector<std::vector<int>> edges_of_;
};

ArmRoadmap::ArmRoadmap(const Validity& validity, const float* start, const float* goal, Space space, std::uint64_t seed)
    : validity_(validity), space_(std::move(space)), random_(seed), points_(space_.stride), edges_of_(2) {
  points_.add(start);
  points_.add(goal);
  if (validity_.edge_free(start, goal)) {
    edges_.push_back({0, 1, space_.distance(start, goal)});
    edges_of_[0].push_back(0);
    edges_of_[1].push_back(0);
  }
}

void ArmRoadmap::grow(int nodes, std::uint64_t samples, int neighbours) {
  std::vector<float> eight(static_cast<std::size_t>(kWidth) * space_.stride);
  std::vector<float> best(space_.stride);
  float farthest = -1.0F;
  int candidates = 0;
  for (std::uint64_t drawn = 0; this->nodes() < nodes && drawn < samples; drawn += kWidth) {
    const auto sample = [&](int lane) { return eight.data() + static_cast<std::ptrdiff_t>(lane) * space_.stride; };
    for (int lane = 0; lane < kWidth; ++lane) space_.sample(random_, sample(lane));
    const unsigned collisions = validity_.collisions(eight.data());
    for (int lane = 0; lane < kWidth; ++lane) {
      if ((collisions >> lane & 1U) != 0) continue;
      ++candidates;
      const float distance = nearest(sample(lane));
      if (distance <= farthest) continue;
      farthest = distance;
      std::copy(sample(lane), sample(lane) + space_.stride, best.begin());
    }
    if (candidates < kCandidates) continue;
    add(best.data(), neighbours);
    farthest = -1.0F;
    candidates = 0;
  }
}

float ArmRoadmap::nearest(const float* q) const {
  float least = std::numeric_limits<float>::infinity();
  for (int i = 0; i < nodes(); ++i) least = std::min(least, space_.distance(points_[i], q));
  return least;
}

void ArmRoadmap::add(const float* q, int neighbours) {
  const int node = nodes();
  std::vector<std::pair<float, int>> near;
  for (int i = 0; i < node; ++i) near.emplace_back(space_.distance(points_[i], q), i);
  std::sort(near.begin(), near.end());
  points_.add(q);
  edges_of_.emplace_back();
  int tried = 0;
  for (const auto& [length, other] : near) {
    // Start and goal are joined with all nodes where the edge is free.
    if (tried >= neighbours && other > 1) continue;
    ++tried;
    if (!validity_.edge_free(points_[other], points_[node])) continue;
    edges_of_[node].push_back(static_cast<int>(edges_.size()));
    edges_of_[other].push_back(static_cast<int>(edges_.size()));
    edges_.push_back({other, node, length});
  }
}

std::vector<float> ArmRoadmap::distances_to_goal() const {
  std::vector<float> distances(nodes(), std::numeric_limits<float>::infinity());
  using Open = std::pair<float, int>;
  std::priority_queue<Open, std::vector<Open>, std::greater<>> open;
  distances[1] = 0.0F;
  open.push({0.0F, 1});
  while (!open.empty()) {
    const auto [distance, node] = open.top();
    open.pop();
    if (distance > distances[node]) continue;
    for (const int edge : edges_of_[node]) {
      const int next = other_end(edge, node);
      const float along = distance + edges_[edge].length;
      if (along >= distances[next]) continue;
      distances[next] = along;
      open.push({along, next});
    }
  }
  return distances;
}

enum class Known : std::uint8_t { kNot, kFree, kBlocked };

/// Cached checks of two arms: one at its nodes or on its edges, the other at its nodes.
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

using Places = std::vector<std::uint16_t>;  // one node per arm

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

/// The search of one query.
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

  /// A* on the present roadmaps. Returns the vertices from start to goal; empty if there is no path or the budget has
  /// ended.
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
      if (*vertices_[at].places == goal) return path_to(at);
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
  /// False if an arm has no path to its goal even when it is alone.
  bool prepare() {
    const std::size_t arms = roadmaps_.size();
    to_go_.clear();
    for (const ArmRoadmap& roadmap : roadmaps_) {
      to_go_.push_back(roadmap.distances_to_goal());
      if (std::isinf(to_go_.back().front())) return false;
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
        if (!can_move(static_cast<int>(i), edge, to, places)) continue;
        places[i] = static_cast<std::uint16_t>(to);
        const int next = find(places);
        const float along = cost + roadmaps_[i].edges()[edge].length;
        if (!vertices_[next].closed && along < vertices_[next].cost) {
          vertices_[next].cost = along;
          vertices_[next].parent = at;
          open_.push({along + static_cast<float>(options_.weight) * to_go(places), next});
        }
      }
      places[i] = static_cast<std::uint16_t>(from);
    }
  }

  [[nodiscard]] float to_go(const Places& places) const {
    float sum = 0.0F;
    for (std::size_t i = 0; i < places.size(); ++i) sum += to_go_[i][places[i]];
    return sum;
  }

  /// True if arm i can move along an edge to its end, while every other arm stands at its place in `places`.
  bool can_move(int i, int edge, int to, const Places& places) {
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
      const ArmRoadmap::Edge& ends = roadmaps_[i].edges()[edge];
      const std::vector<float> a = both(validity, i, ends.a, k, place);
      const std::vector<float> b = both(validity, i, ends.b, k, place);
      known = validity.edge_free(a.data(), b.data()) ? Known::kFree : Known::kBlocked;
    }
    return known == Known::kFree;
  }

  /// The joint configuration of arms i and k, the smaller index first.
  [[nodiscard]] std::vector<float> both(const Validity& validity, int i, int node_i, int k, int node_k) const {
    if (i > k) return both(validity, k, node_k, i, node_i);
    std::vector<float> q(validity.stride(), 0.0F);
    const int joints = roadmaps_[i].space().dimensions;
    std::copy_n(roadmaps_[i][node_i], joints, q.begin());
    std::copy_n(roadmaps_[k][node_k], roadmaps_[k].space().dimensions, q.begin() + joints);
    return q;
  }

  [[nodiscard]] std::vector<Places> path_to(int at) const {
    std::vector<Places> path;
    for (; at >= 0; at = vertices_[at].parent) path.push_back(*vertices_[at].places);
    std::reverse(path.begin(), path.end());
    return path;
  }

  const SuperGraph& graph_;
  const SuperGraphOptions& options_;
  std::uint64_t most_checks_;
  std::vector<ArmRoadmap> roadmaps_;
  std::vector<std::vector<float>> to_go_;  ///< by arm and node: path length to the goal [rad | m]
  std::vector<Table> at_nodes_;            ///< by arms i < k: both at nodes
  std::vector<Table> on_edges_;            ///< by arms i, k: i on an edge, k at a node
  std::unordered_map<Places, int, PlacesHash> index_;
  std::vector<Vertex> vertices_;
  std::priority_queue<Open, std::vector<Open>, std::greater<>> open_;
};

Plan SuperGraph::plan(std::span<const double> start, std::span<const double> goal, std::uint64_t seed,
                      const SuperGraphOptions& options) {
  Plan result;
  const std::uint64_t checks_before = checks();
  Search search(*this, start, goal, seed, options);
  std::vector<Places> path;
  int nodes = options.nodes;
  for (int i = 0; i <= options.doublings && path.empty() && !search.over(result.iterations); ++i, nodes *= 2) {
    search.grow(nodes);
    result.nodes = nodes;
    path = search.run(result.iterations);
  }
  result.checks = checks() - checks_before;
  if (path.empty()) {
    result.reason = "no path was found in the product of the arms' roadmaps";
    return result;
  }
  result.status = PlanStatus::kSolved;
  for (const Places& places : path) result.path.push_back(search.joined(places));
  result.path.front().assign(start.begin(), start.end());
  result.path.back().assign(goal.begin(), goal.end());
  return result;
}

}  // namespace hecaton::planner::global
