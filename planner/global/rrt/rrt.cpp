#include "planner/global/rrt/rrt.hpp"

#include <algorithm>
#include <cmath>

#include "planner/global/tree.hpp"

namespace hecaton::planner::global {
namespace {

/// EXTEND: grows the nearest node by at most `range` [rad | m] towards the sample. The new node is the last of the
/// tree.
Extend extend(const SearchProblem& problem, Tree& tree, const float* sample, float range, std::vector<float>& next,
              std::vector<float>& image) {
  const Neighbour near = tree.nearest(sample);
  const float* q = problem.space.nearest_image(tree[near.index], sample, image);
  const float distance = std::sqrt(near.distance2);
  if (distance <= 0.0F) return Extend::kTrapped;
  const bool reaches = distance <= range;
  if (reaches) {
    std::copy(q, q + problem.space.stride, next.begin());
  } else {
    problem.space.interpolate(tree[near.index], q, range / distance, next.data());
  }
  if (!problem.edge_free(tree[near.index], next.data())) return Extend::kTrapped;
  tree.add(next.data(), near.index);
  return reaches ? Extend::kReached : Extend::kAdvanced;
}

}  // namespace

Rrt::Rrt(const RrtParameters& parameters)
    : GlobalPlanner({.name = "rrt", .summary = "one tree from the start, which grows towards random configurations"}),
      parameters_(parameters) {}

SearchResult Rrt::search(const SearchProblem& problem) const {
  SearchResult result;
  Random random(problem.seed);
  Tree tree(problem.space, problem.start);
  std::vector<float> sample(problem.space.stride);
  std::vector<float> next(problem.space.stride);
  std::vector<float> image;
  while (!result.solved() && !problem.over(result.iterations)) {
    // The first sample is the goal: the straight edge may be free.
    const bool to_goal = result.iterations == 0 || random.uniform() < parameters_.goal_bias;
    ++result.iterations;
    if (to_goal) {
      std::copy(problem.goal, problem.goal + problem.space.stride, sample.begin());
    } else {
      problem.space.sample(random, sample.data());
    }
    const Extend outcome = extend(problem, tree, sample.data(), parameters_.range, next, image);
    if (to_goal && outcome == Extend::kReached) result.status = PlanStatus::kSolved;
  }
  if (result.solved()) {
    result.path = tree.path_to_root(tree.size() - 1);
    result.path.reverse();
  }
  result.nodes = tree.size();
  if (problem.record != nullptr) tree.record(*problem.record);
  return result;
}

}  // namespace hecaton::planner::global
