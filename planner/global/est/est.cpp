#include "planner/global/est/est.hpp"

#include <algorithm>
#include <cmath>

#include "planner/global/tree.hpp"

namespace hecaton::planner::global {
namespace {

/// A tree that counts the neighbours of each node.
class DensityTree {
 public:
  DensityTree(const Space& space, const float* root, float radius) : tree_(space, root), radius_(radius), counts_{1} {}

  int add(const float* q, int parent) {
    tree_.within(q, radius_, near_);
    for (const Neighbour& neighbour : near_) ++counts_[neighbour.index];
    counts_.push_back(static_cast<int>(near_.size()) + 1);
    return tree_.add(q, parent);
  }

  /// A random node, with a probability inverse to the number of nodes around it [Hsu00].
  [[nodiscard]] int draw(Random& random) const {
    double sum = 0.0;
    for (const int count : counts_) sum += 1.0 / count;
    double left = random.uniform() * sum;
    for (int i = 0; i < tree_.size(); ++i) {
      left -= 1.0 / counts_[i];
      if (left <= 0.0) return i;
    }
    return tree_.size() - 1;
  }

  [[nodiscard]] const Tree& tree() const { return tree_; }

 private:
  Tree tree_;
  float radius_;
  std::vector<int> counts_;
  std::vector<Neighbour> near_;
};

/// Uniform in the intersection of the space with a cube of side 2 `radius` about `centre`.
void sample_around(const Space& space, const float* centre, float radius, Random& random, float* q) {
  for (int j = 0; j < space.dimensions; ++j) {
    if (space.periodic() && space.period[j] > 0.0F) {
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
  path.unwrap(space, start[0]);
  return path;
}

}  // namespace

Est::Est(const EstParameters& parameters)
    : GlobalPlanner({.name = "est", .summary = "two trees, from start and goal, which grow where they are sparse"}),
      parameters_(parameters) {}

SearchResult Est::search(const SearchProblem& problem) const {
  SearchResult result;
  Random random(problem.seed);
  DensityTree start(problem.space, problem.start, parameters_.density_radius);
  DensityTree goal(problem.space, problem.goal, parameters_.density_radius);
  std::vector<float> q(problem.space.stride, 0.0F);
  std::vector<float> image;
  if (problem.edge_free(problem.start, problem.space.nearest_image(problem.start, problem.goal, image))) {
    result.status = PlanStatus::kSolved;
    result.path = joined(problem.space, start.tree(), 0, goal.tree(), 0);
  }
  while (!result.solved() && !problem.over(result.iterations)) {
    const bool from_start = result.iterations++ % 2 == 0;
    DensityTree& one = from_start ? start : goal;
    const DensityTree& other = from_start ? goal : start;
    const int node = one.draw(random);
    sample_around(problem.space, one.tree()[node], parameters_.range, random, q.data());
    if (!problem.edge_free(one.tree()[node], q.data())) continue;
    const int added = one.add(q.data(), node);
    const Neighbour near = other.tree().nearest(q.data());
    if (near.distance2 > parameters_.join_range * parameters_.join_range) continue;
    if (!problem.edge_free(q.data(), problem.space.nearest_image(q.data(), other.tree()[near.index], image))) continue;
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
