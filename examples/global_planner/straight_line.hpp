#pragma once
/// A global planner of one's own: the straight line in joint space, or nothing.

#include <vector>

#include "planner/global/global_planner.hpp"

namespace example {

namespace global = hecaton::planner::global;

class StraightLine final : public global::GlobalPlanner {
 public:
  StraightLine() : GlobalPlanner({.name = "straight_line", .summary = "the straight line, or nothing"}) {}

  [[nodiscard]] global::SearchResult search(const global::SearchProblem& problem) const override {
    global::SearchResult result;
    // The short way round, where a joint turns without end.
    std::vector<float> place;
    const float* goal = problem.space.nearest_image(problem.start, problem.goal, place);
    if (!problem.edge_free(problem.start, goal)) {
      result.status = global::PlanStatus::kStuck;
      result.reason = "something is in the straight line from start to goal";
      return result;
    }
    result.status = global::PlanStatus::kSolved;
    result.path = global::Points(problem.space.stride);
    result.path.add(problem.start);
    result.path.add(goal);
    return result;
  }
};

}  // namespace example
