#pragma once
/// Searches for the strategies of a motion problem [Mediavilla02, section 3.2]: systematic trials as in the paper,
/// successive halving on the same grid [Jamieson16], and local refinement of what they find.

#include <functional>
#include <span>
#include <string>

#include "planner/strategy_search/evaluate.hpp"

namespace hecaton::planner {

/// The values of each α and β, and both local directions, for each arm: all combinations are tried. Coefficients beyond
/// the second have β's values.
struct StrategyGrid {
  std::vector<double> alpha = {-2.0, 0.0, 2.0};
  std::vector<double> beta = {-2.5, -1.0, 1.0, 2.5};

  /// Strategies of one arm with so many coefficients.
  [[nodiscard]] std::vector<Strategy> of_arm(int coefficients) const;
  /// All combinations over the problem's arms; the first arm's strategy changes slowest. Throws ProblemError when there
  /// are more than `most`.
  [[nodiscard]] std::vector<SystemStrategy> of(const StrategyProblem& problem, std::size_t most = 2'000'000) const;
};

struct Candidate {
  SystemStrategy strategy;
  Evaluation evaluation;
};

/// Fewest faults per task first, then the shortest T(L).
[[nodiscard]] bool better(const Evaluation& a, const Evaluation& b);

/// One round of a search: so many tasks of one seed for each candidate.
struct Round {
  std::string name;
  int tasks = 300;  ///< of each arm
  std::uint64_t seed = 1;
  bool stop_at_fault = true;  ///< a candidate's first fault ends its round
};

/// How a search is carried out; none of it changes what it finds.
struct SearchHooks {
  int threads = 1;
  /// Told after each evaluation, from the thread that made it, one at a time.
  std::function<void(const Round& round, std::size_t index, std::size_t all, const Evaluation& evaluation)> evaluated =
      {};
  /// An evaluation that is known already, of a search that is resumed; nullptr: it is made.
  std::function<const Evaluation*(const Round& round, std::size_t index)> known = {};
  int part = 0;   ///< only candidates whose index has this remainder …
  int parts = 1;  ///< … when divided by this are evaluated here, as one of several processes
  /// Then brings what the others have: a text for each candidate, at first empty for theirs (planner/strategy_search/
  /// text_of()).
  std::function<void(std::vector<std::string>& texts)> share = {};
};

/// Whether this process evaluates that candidate.
[[nodiscard]] inline bool is_own(const SearchHooks& hooks, std::size_t index) {
  return index % static_cast<std::size_t>(hooks.parts) == static_cast<std::size_t>(hooks.part);
}

/// Evaluates each, in the order given, whatever the number of threads and parts.
[[nodiscard]] std::vector<Evaluation> evaluate_round(const StrategyProblem& problem,
                                                     std::span<const SystemStrategy> strategies, const Round& round,
                                                     const SearchHooks& hooks = {});

struct SearchPlan {
  bool complete = false;      ///< only screens, but with every task of every candidate, and keeps all
  bool halving = false;       ///< successive halving instead of systematic trials
  int screening_tasks = 300;  ///< of each arm
  int confirm_tasks = 1800;   ///< of each arm and set
  int confirm_sets = 2;
  std::uint64_t seed = 1;  ///< of the first round; the others use those after it
  std::size_t keep = 20;   ///< candidates that are confirmed although none is without fault, ≥ 1
  int refine = 0;          ///< so many of the best are refined by the simplex method before they are confirmed
  int refine_steps = 120;  ///< evaluations of each
};

struct SearchReport {
  std::vector<Candidate> best;  ///< of the last round, best first; evaluated over all tasks of all rounds they were in
  struct Stage {
    Round round;
    std::size_t candidates = 0;
    std::size_t without_fault = 0;
    std::uint64_t arm_ticks = 0;
  };
  std::vector<Stage> stages;
};

/// Screening, refinement, confirmation on fresh seeds.
[[nodiscard]] SearchReport search_strategies(const StrategyProblem& problem,
                                             const std::vector<SystemStrategy>& candidates, const SearchPlan& plan,
                                             const SearchHooks& hooks = {});

/// Local optimisation of a strategy by the flexible polyhedron search of Nelder and Mead [Mediavilla02, section 3.2],
/// as NLopt has it.
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
