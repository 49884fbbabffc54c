#pragma once
/// RRT [LaValle01], [Cardenas10] fig. 8 and 9: one tree from the start, which grows towards random configurations and,
/// with a small probability, towards the goal.

#include "planner/global/global_planner.hpp"

namespace hecaton::planner::global {

struct RrtParameters {
  float range = 1.0F;       ///< longest new edge, in joint space [rad | m]
  float goal_bias = 0.05F;  ///< share of samples that are the goal
};

class Rrt final : public GlobalPlanner {
 public:
  explicit Rrt(const RrtParameters& parameters = {});
  [[nodiscard]] SearchResult search(const SearchProblem& problem) const override;

 private:
  RrtParameters parameters_;
};

}  // namespace hecaton::planner::global
