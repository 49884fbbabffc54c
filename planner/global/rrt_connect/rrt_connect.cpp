#include "planner/global/rrt_connect/rrt_connect.hpp"

#include <algorithm>
#include <cmath>

#include "planner/global/tree.hpp"

namespace hecaton::planner::global {
namespace {

class RrtConnectSearch {
 public:
  RrtConnectSearch(const SearchProblem& problem, const RrtConnectParameters& parameters)
      : problem_(problem),
        parameters_(parameters),
        start_(problem.space, problem.start),
        goal_(problem.space, problem.goal),
        sample_(problem.space.stride),
        next_(problem.space.stride),
        random_(problem.seed) {}

  SearchResult run() {
    SearchResult result;
    const float* goal = problem_.space.nearest_image(problem_.start, problem_.goal, image_);
    if (problem_.edge_free(problem_.start, goal)) {
      result.status = PlanStatus::kSolved;
      result.path = Points(problem_.space.stride);
      result.path.add(problem_.start);
      result.path.add(goal);
    }
    while (!result.solved() && !problem_.over(result.iterations)) {
      ++result.iterations;
      // The smaller tree grows [Kuffner00].
      const bool from_start = start_.size() <= goal_.size();
      Tree& one = from_start ? start_ : goal_;
      Tree& other = from_start ? goal_ : start_;
      problem_.space.sample(random_, sample_.data());
      if (extend(one) == Extend::kTrapped || connect(other, one[one.size() - 1]) != Extend::kReached) continue;
      result.status = PlanStatus::kSolved;
      result.path = joined();
    }
    result.nodes = start_.size() + goal_.size();
    if (problem_.record != nullptr) {
      start_.record(*problem_.record);
      goal_.record(*problem_.record);
    }
    return result;
  }

 private:
  /// Grows `tree` towards the sample by at most the range. The new node is the last of the tree.
  Extend extend(Tree& tree) {
    const Neighbour near = tree.nearest(sample_.data());
    const float distance = std::sqrt(near.distance2);
    if (distance <= 0.0F) return Extend::kTrapped;
    const float range = std::min(parameters_.range, tree.domain(near.index));
    const bool reaches = distance <= range;
    const float* sample = problem_.space.nearest_image(tree[near.index], sample_.data(), image_);
    problem_.space.interpolate(tree[near.index], sample, reaches ? 1.0F : range / distance, next_.data());
    if (!problem_.edge_free(tree[near.index], next_.data())) {
      if (parameters_.domain_factor < 1.0F) {
        tree.set_domain(near.index, std::max(range * parameters_.domain_factor, parameters_.min_domain));
      }
      return Extend::kTrapped;
    }
    tree.set_domain(near.index, tree.domain(near.index) / parameters_.domain_factor);
    tree.add(next_.data(), near.index);
    return reaches ? Extend::kReached : Extend::kAdvanced;
  }

  /// Grows `tree` straight towards `other` until it is reached or an edge is not free.
  Extend connect(Tree& tree, const float* other) {
    const Neighbour near = tree.nearest(other);
    const float* q = problem_.space.nearest_image(tree[near.index], other, image_);
    const float distance = std::sqrt(near.distance2);
    const int steps = std::max(1, static_cast<int>(std::ceil(distance / parameters_.range)));
    const std::vector<float> from(tree[near.index], tree[near.index] + problem_.space.stride);
    int last = near.index;
    for (int i = 1; i <= steps; ++i) {
      problem_.space.interpolate(from.data(), q, static_cast<float>(i) / static_cast<float>(steps), next_.data());
      if (i == steps) std::copy(q, q + problem_.space.stride, next_.data());
      if (problem_.over(0) || !problem_.edge_free(tree[last], next_.data()))
        return i > 1 ? Extend::kAdvanced : Extend::kTrapped;
      last = tree.add(next_.data(), last);
    }
    return Extend::kReached;
  }

  /// The path through both trees, whose last nodes are the same configuration.
  [[nodiscard]] Points joined() const {
    Points path = start_.path_to_root(start_.size() - 1);
    path.reverse();
    for (int i = goal_.parent(goal_.size() - 1); i >= 0; i = goal_.parent(i)) path.add(goal_[i]);
    path.unwrap(problem_.space, problem_.start);
    return path;
  }

  const SearchProblem& problem_;
  const RrtConnectParameters& parameters_;
  Tree start_;
  Tree goal_;
  std::vector<float> sample_;
  std::vector<float> next_;
  std::vector<float> image_;  ///< buffer of Space::nearest_image
  Random random_;
};

}  // namespace

RrtConnect::RrtConnect(const RrtConnectParameters& parameters)
    : GlobalPlanner({.name = "rrt_connect", .summary = "two trees, from start and goal, that grow towards each other"}),
      parameters_(parameters) {}

SearchResult RrtConnect::search(const SearchProblem& problem) const {
  return RrtConnectSearch(problem, parameters_).run();
}

}  // namespace hecaton::planner::global
