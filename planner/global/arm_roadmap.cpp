#include "planner/global/arm_roadmap.hpp"

#include <algorithm>
#include <functional>
#include <limits>
#include <queue>
#include <utility>

namespace hecaton::planner::global {
namespace {

/// Free samples that a new node is chosen from.
constexpr int kCandidates = 4;

}  // namespace

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
    // Start and goal are joined with whatever sees them.
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

}  // namespace hecaton::planner::global
