#pragma once
/// Local optimisation of a strategy by the flexible polyhedron search of Nelder and Mead [Mediavilla02, section 3.2],
/// as NLopt has it.

#include "planner/strategy_search/evaluate.hpp"

namespace hecaton::planner {

struct SimplexOptions {
  int most_steps = 200;      ///< evaluations of T(L)
  double tolerance = 0.5;    ///< of T(L), as in table 2 [steps]
  double first_size = 0.25;  ///< of the first simplex, in α and β
};

struct SimplexResult {
  SystemStrategy strategy;  ///< the best that was evaluated
  Evaluation initial;
  Evaluation final;
  int steps = 0;  ///< evaluations that were made
};

/// Minimises T(L) over the coefficients of all arms on these tasks; directions stay. A fault counts with its time
/// limit, so that strategies with faults lose.
[[nodiscard]] SimplexResult refine_by_simplex(const StrategyProblem& problem, const TaskSet& tasks,
                                              const SystemStrategy& initial, const SimplexOptions& options = {});

}  // namespace hecaton::planner
