#pragma once
/// Search for strategies of a motion problem [Mediavilla02, section 3.2]: exhaustive trials as in the paper, or
/// successive halving on the same grid [Jamieson16], and local refinement.

#include <functional>
#include <span>
#include <string>

#include "planner/strategy_search/evaluate.hpp"

namespace hecaton::planner {

/// Values of α and β; combined with both directions, for each arm. Further coefficients have the values of β.
struct StrategyGrid {
  std::vector<double> alpha = {-2.0, 0.0, 2.0};
  std::vector<double> beta = {-2.5, -1.0, 1.0, 2.5};

  /// All strategies of an arm with this number of coefficients.
  [[nodiscard]] std::vector<Strategy> of_arm(int coefficients) const;
  /// All combinations over the problem's arms; the first arm's strategy changes slowest. Throws ProblemError if there
  /// are more than `limit`.
  [[nodiscard]] std::vector<SystemStrategy> of(const StrategyProblem& problem, std::size_t limit = 2'000'000) const;
};

struct Candidate {
  SystemStrategy strategy;
  Evaluation evaluation;
};

/// True if `a` has fewer faults per task or, with equally many, a shorter T(L).
[[nodiscard]] bool better(const Evaluation& a, const Evaluation& b);

/// One round of a search: each candidate is evaluated on the same tasks.
struct Round {
  std::string name;
  int tasks = 300;  ///< of each arm
  std::uint64_t seed = 1;
  bool stop_at_fault = true;  ///< end an evaluation at its first fault
};

/// Execution of a search: threads, processes, progress. Does not change the result.
struct SearchHooks {
  int threads = 1;
  /// Called after each evaluation, by its thread; calls are serialized.
  std::function<void(const Round& round, std::size_t index, std::size_t all, const Evaluation& evaluation)> evaluated =
      {};
  /// Returns an evaluation of a resumed search, or null if there is none.
  std::function<const Evaluation*(const Round& round, std::size_t index)> known = {};
  /// Called often, by all threads; true ends the search: the report then has what is evaluated so far. Only for a
  /// single process. May be empty.
  std::function<bool()> ended = {};
  int part = 0;   ///< rank of this process; it evaluates the candidates with index % parts == part
  int parts = 1;  ///< number of processes
  /// Exchanges results with the other processes: one text (text_of()) per candidate, empty for candidates of
  /// other processes; on return, all are filled.
  std::function<void(std::vector<std::string>& texts)> share = {};
};

/// True if this process evaluates the candidate.
[[nodiscard]] inline bool is_own(const SearchHooks& hooks, std::size_t index) {
  return index % static_cast<std::size_t>(hooks.parts) == static_cast<std::size_t>(hooks.part);
}

/// Evaluates all strategies; results in their order. After SearchHooks::ended, evaluations that are missing have no
/// tasks.
[[nodiscard]] std::vector<Evaluation> evaluate_round(const StrategyProblem& problem,
                                                     std::span<const SystemStrategy> strategies, const Round& round,
                                                     const SearchHooks& hooks = {});

struct SearchPlan {
  bool complete = false;      ///< only screening, with all tasks of all candidates, and without elimination
  bool halving = false;       ///< successive halving instead of exhaustive trials
  int screening_tasks = 300;  ///< of each arm
  int confirm_tasks = 1800;   ///< of each arm, per set
  int confirm_sets = 2;
  std::uint64_t seed = 1;  ///< of the first round; later rounds use the following seeds
  std::size_t keep = 20;   ///< candidates to confirm if all have faults, ≥ 1
  int refine = 0;          ///< number of best candidates to refine by the simplex method before confirmation
  int refine_steps = 120;  ///< evaluations per refinement
};

struct SearchReport {
  std::vector<Candidate> best;  ///< of the last round, best first; with the tasks of all their rounds
  struct Stage {
    Round round;
    std::size_t candidates = 0;
    std::size_t evaluated = 0;  ///< of these; fewer only after SearchHooks::ended
    std::size_t without_fault = 0;
    std::uint64_t arm_ticks = 0;
  };
  std::vector<Stage> stages;  ///< the last one may be incomplete after SearchHooks::ended
  bool ended_early = false;   ///< by SearchHooks::ended; strategies without any evaluation are left out of `best`
};

/// Screening, refinement, and confirmation with other seeds.
[[nodiscard]] SearchReport search_strategies(const StrategyProblem& problem,
                                             const std::vector<SystemStrategy>& candidates, const SearchPlan& plan,
                                             const SearchHooks& hooks = {});

/// Options of the local optimisation by Nelder and Mead [Mediavilla02, section 3.2], with NLopt.
struct SimplexOptions {
  int max_steps = 200;         ///< evaluations of T(L)
  double tolerance = 0.5;      ///< of T(L), as in table 2 [steps]
  double initial_size = 0.25;  ///< of the first simplex, in α and β
  /// Called with the number of evaluations before each; true ends the optimisation with the best so far. May be empty.
  std::function<bool(int)> ended = {};
};

struct SimplexResult {
  SystemStrategy strategy;  ///< the best one
  Evaluation initial;
  Evaluation final;
  int steps = 0;  ///< number of evaluations
};

/// Minimises T(L) over the coefficients of all arms on these tasks. Directions stay. A fault counts with its time
/// limit, so that strategies with faults are worse.
[[nodiscard]] SimplexResult refine_by_simplex(const StrategyProblem& problem, const TaskSet& tasks,
                                              const SystemStrategy& initial, const SimplexOptions& options = {});

}  // namespace hecaton::planner
