#include "planner/global/est/est.hpp"

#include <algorithm>
#include <cmath>

#include "planner/global/tree.hpp"

namespace hecaton::planner::global {
namespace {

/// A tree that knows how crowded the surroundings of each node are.
class SparseTree {
 public:
  SparseTree(const Space& space, const float* root, float radius) : tree_(space, root), radius_(radius), crowd_{1} {}

  int add(const float* q, int parent) {
    tree_.within(q, radius_, near_);
    for (const Neighbour& neighbour : near_) ++crowd_[neighbour.index];
    crowd_.push_back(static_cast<int>(near_.size()) + 1);
    return tree_.add(q, parent);
  }

  /// A node with a probability inverse to the number of nodes around it [Hsu00].
  [[nodiscard]] int draw(Random& random) const {
    double sum = 0.0;
    for (const int crowd : crowd_) sum += 1.0 / crowd;
    double left = random.uniform() * sum;
    for (int i = 0; i < tree_.size(); ++i) {
      left -= 1.0 / crowd_[i];
      if (left <= 0.0) return i;
    }
    return tree_.size() - 1;
  }

  [[nodiscard]] const Tree& tree() const { return tree_; }

 private:
  Tree tree_;
  float radius_;
  std::vector<int> crowd_;
  std::vector<Neighbour> near_;
};

/// Uniform in the part of the box around `centre` with sides of 2 `radius` that lies in the space.
void sample_around(const Space& space, const float* centre, float radius, Random& random, float* q) {
  for (int j = 0; j < space.dimensions; ++j) {
    if (space.closed() && space.turns[j] > 0.0F) {
      q[j] = static_cast<float>(random.uniform(centre[j] - radius, centre[j] + radius));
      continue;
    }
    q[j] = static_cast<float>(
        random.uniform(std::max(space.lower[j], centre[j] - radius), std::min(space.upper[j], centre[j] + radius)));
  }
}

Points joined(const Space& space, const Tree& start, int from, const Tree& goal, int to) {
  Points path = start.path_to_root(from);
  path.reverse();
  const Points rest = goal.path_to_root(to);
  for (int i = 0; i < rest.size(); ++i) path.add(rest[i]);
  path.join_turns(space, start[0]);
  return path;
}

}  // namespace

Est::Est(const EstParameters& parameters)
    : GlobalPlanner({.name = "est", .summary = "two trees, from start and goal, that grow where they are sparse"}),
      parameters_(parameters) {}

SearchResult Est::search(const SearchProblem& problem) const {
  SearchResult result;
  Random random(problem.seed);
  SparseTree start(problem.space, problem.start, parameters_.crowd_radius);
  SparseTree goal(problem.space, problem.goal, parameters_.crowd_radius);
  std::vector<float> q(problem.space.stride, 0.0F);
  std::vector<float> place;
  if (problem.edge_free(problem.start, problem.space.beside(problem.start, problem.goal, place))) {
    result.status = PlanStatus::kSolved;
    result.path = joined(problem.space, start.tree(), 0, goal.tree(), 0);
  }
  while (!result.solved() && !problem.over(result.iterations)) {
    const bool from_start = result.iterations++ % 2 == 0;
    SparseTree& one = from_start ? start : goal;
    const SparseTree& other = from_start ? goal : start;
    const int node = one.draw(random);
    sample_around(problem.space, one.tree()[node], parameters_.range, random, q.data());
    if (!problem.edge_free(one.tree()[node], q.data())) continue;
    const int added = one.add(q.data(), node);
    const Neighbour near = other.tree().nearest(q.data());
    if (near.distance2 > parameters_.join_range * parameters_.join_range) continue;
    if (!problem.edge_free(q.data(), problem.space.beside(q.data(), other.tree()[near.index], place))) continue;
    result.status = PlanStatus::kSolved;
    result.path = from_start ? joined(problem.space, start.tree(), added, goal.tree(), near.index)
                             : joined(problem.space, start.tree(), near.index, goal.tree(), added);
  }
  result.nodes = start.tree().size() + goal.tree().size();
  if (problem.record != nullptr) {
    start.tree().record(*problem.record);
    goal.tree().record(*problem.record);
  }
  return result;
}

}  // namespace hecaton::planner::global
