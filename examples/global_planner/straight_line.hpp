#pragma once
/// Example of a global planner: the straight line in joint space, if it is free.

#include <vector>

#include "planner/global/global_planner.hpp"

namespace example {

namespace global = hecaton::planner::global;

class StraightLine final : public global::GlobalPlanner {
 public:
  StraightLine() : GlobalPlanner({.name = "straight_line", .summary = "the straight line, if it is free"}) {}

  [[nodiscard]] global::SearchResult search(const global::SearchProblem& problem) const override {
    global::SearchResult result;
    // Continuous joints take the short way.
    std::vector<float> image;
    const float* goal = problem.space.nearest_image(problem.start, problem.goal, image);
    if (!problem.edge_free(problem.start, goal)) {
      result.status = global::PlanStatus::kStuck;
      result.reason = "an obstacle blocks the straight line from start to goal";
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
