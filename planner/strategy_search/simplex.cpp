#include "planner/strategy_search/simplex.hpp"

#include <nlopt.hpp>

#include "planner/methods/strategy/coefficient_limit.hpp"

namespace hecaton::planner {
namespace {

struct Objective {
  const StrategyProblem& problem;
  const TaskSet& tasks;
  SimplexResult result;

  [[nodiscard]] SystemStrategy strategy_at(const std::vector<double>& x) const {
    SystemStrategy strategy = result.strategy;
    std::size_t at = 0;
    for (int arm = 0; arm < problem.arms(); ++arm) {
      for (int k = 0; k < problem.coefficients(arm); ++k) strategy[arm].coefficients[k] = x[at++];
    }
    return strategy;
  }

  double operator()(const std::vector<double>& x) {
    SystemStrategy strategy = strategy_at(x);
    Evaluation evaluation = evaluate(problem, tasks, strategy);
    const double time = evaluation.mean_time();
    if (result.steps++ == 0) result.initial = result.final = evaluation;
    if (time < result.final.mean_time()) {
      result.final = std::move(evaluation);
      result.strategy = std::move(strategy);
    }
    return time;
  }
};

}  // namespace

SimplexResult refine_by_simplex(const StrategyProblem& problem, const TaskSet& tasks, const SystemStrategy& initial,
                                const SimplexOptions& options) {
  std::vector<double> x;
  for (int arm = 0; arm < problem.arms(); ++arm) {
    for (int k = 0; k < problem.coefficients(arm); ++k) x.push_back(initial[arm].coefficients[k]);
  }
  Objective objective{problem, tasks, {}};
  objective.result.strategy = initial;
  if (x.empty()) {
    objective(x);
    return objective.result;
  }
  nlopt::opt search(nlopt::LN_NELDERMEAD, static_cast<unsigned>(x.size()));
  search.set_min_objective([](const std::vector<double>& at, std::vector<double>&,
                              void* data) { return (*static_cast<Objective*>(data))(at); },
                           &objective);
  search.set_lower_bounds(-kMostCoefficient);
  search.set_upper_bounds(kMostCoefficient);
  search.set_initial_step(options.first_size);
  search.set_ftol_abs(options.tolerance);
  search.set_maxeval(options.most_steps);
  double least = 0.0;
  try {
    search.optimize(x, least);
  } catch (const nlopt::roundoff_limited&) {
    // As near as can be: the best so far counts.
  }
  return objective.result;
}

}  // namespace hecaton::planner
