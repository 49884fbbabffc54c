#pragma once
/// The two indexes of a strategy [Mediavilla02, section 3.1]: the estimated probability of faults and the average time.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "planner/methods/strategy/strategy.hpp"
#include "planner/strategy_search/motion_problem.hpp"

namespace hecaton::planner {

/// L of a whole system (eq. 8): one strategy an arm.
using SystemStrategy = std::vector<Strategy>;

struct Evaluation {
  std::vector<std::int64_t> tasks;   ///< of each arm, done or faulty
  std::vector<std::int64_t> faults;  ///< of each arm
  std::vector<double> time;          ///< of each arm, sum over its tasks; a fault counts with its time limit [steps]
  std::vector<double> time2;         ///< of each arm, sum of squares [steps²]
  std::uint64_t arm_ticks = 0;       ///< steps of arms under way that were simulated
  bool complete = false;             ///< every task was simulated: no early abort

  [[nodiscard]] std::int64_t all_tasks() const;
  [[nodiscard]] std::int64_t all_faults() const;
  /// P(L): faults of all arms over tasks of all arms.
  [[nodiscard]] double fault_rate() const;
  /// T(L), eq. 9 with table 1's numbers: the sum over arms of the mean time of a task [steps]. The paper's words "N is
  /// the sum of all N_k" would give half of what its tables print for two arms.
  [[nodiscard]] double mean_time() const;
  /// Standard error of mean_time(), tasks taken as independent [steps].
  [[nodiscard]] double mean_time_error() const;

  /// As if both had been one run.
  Evaluation& operator+=(const Evaluation& other);
};

struct EvaluateOptions {
  bool stop_at_fault = false;
  bool find_cycles = true;
  std::vector<std::vector<std::int32_t>>* times = nullptr;  ///< of each arm's tasks, if wanted [steps]
};

[[nodiscard]] Evaluation evaluate(const StrategyProblem& problem, const TaskSet& tasks, const SystemStrategy& strategy,
                                  const EvaluateOptions& options = {});

/// As a line of numbers and spaces from which the same bits are read again: for a search's file, and between its
/// processes.
[[nodiscard]] std::string text_of(const Evaluation& evaluation);
[[nodiscard]] std::string text_of(const SystemStrategy& strategy);

/// Nothing when the text is something else, or was cut off.
[[nodiscard]] std::optional<Evaluation> evaluation_of(const std::string& text);
[[nodiscard]] std::optional<SystemStrategy> strategy_of(const std::string& text);

}  // namespace hecaton::planner
