#pragma once
/// The two indexes of a strategy [Mediavilla02, section 3.1], probability of faults and mean time, and their
/// statistics.

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "planner/methods/strategy/strategy.hpp"
#include "planner/strategy_search/motion_problem.hpp"

namespace hecaton::planner {

/// L of the whole system (eq. 8): one strategy per arm.
using SystemStrategy = std::vector<Strategy>;

/// Results of a simulated set of tasks. Vectors: one entry per arm.
struct Evaluation {
  std::vector<std::int64_t> tasks;  ///< finished, faults included
  std::vector<std::int64_t> faults;
  std::vector<double> time;     ///< sum over the tasks; a fault counts with its time limit [steps]
  std::vector<double> time2;    ///< sum of squares [steps²]
  std::uint64_t arm_ticks = 0;  ///< simulated steps of moving arms
  bool complete = false;        ///< all tasks were simulated

  [[nodiscard]] std::int64_t all_tasks() const;
  [[nodiscard]] std::int64_t all_faults() const;
  /// P(L): faults of all arms over tasks of all arms.
  [[nodiscard]] double fault_rate() const;
  /// T(L), eq. 9 in the reading that gives the numbers of table 1: the sum over arms of the mean time of a task
  /// [steps]. With "N is the sum of all N_k", as the paper says, the value for two arms would be half of that.
  [[nodiscard]] double mean_time() const;
  /// Standard error of mean_time() for independent tasks [steps].
  [[nodiscard]] double mean_time_error() const;

  /// Adds another run of the same strategy.
  Evaluation& operator+=(const Evaluation& other);
};

struct EvaluateOptions {
  bool stop_at_fault = false;  ///< end at the first fault
  bool detect_cycles = true;   ///< see RunOptions
  std::vector<std::vector<std::int32_t>>* times =
      nullptr;  ///< output: duration of each finished task, by arm [steps]; may be null
  /// Called with the number of finished tasks of all arms after each; true ends the evaluation, which is then not
  /// complete. May be empty.
  std::function<bool(std::int64_t)> ended = {};
};

/// Simulates `tasks` with `strategy`. Thread-safe.
[[nodiscard]] Evaluation evaluate(const StrategyProblem& problem, const TaskSet& tasks, const SystemStrategy& strategy,
                                  const EvaluateOptions& options = {});

/// One line of text that reads back to the same bits; for files and messages of a search.
[[nodiscard]] std::string text_of(const Evaluation& evaluation);
[[nodiscard]] std::string text_of(const SystemStrategy& strategy);

/// Empty if the text is invalid or truncated.
[[nodiscard]] std::optional<Evaluation> evaluation_of(const std::string& text);
[[nodiscard]] std::optional<SystemStrategy> strategy_of(const std::string& text);

/// Confidence interval of the probability of a fault [Clopper34]; exact for a binomial experiment.
struct FaultBounds {
  double low = 0.0;
  double high = 1.0;
};
/// 0 ≤ faults ≤ tasks; confidence < 1. Without tasks: [0, 1].
[[nodiscard]] FaultBounds fault_bounds(std::int64_t faults, std::int64_t tasks, double confidence = 0.95);

struct Moments {
  double mean = 0.0;
  double deviation = 0.0;
};
[[nodiscard]] Moments moments(std::span<const std::int32_t> times);

/// Normalised cross-correlation of two series of equal length at lags 1 … lags: Σ (aₖ − ā)(bₖ₊ₗ − b̄) / (N σₐ σ_b).
/// Zeros if a series is constant.
[[nodiscard]] std::vector<double> correlations(std::span<const std::int32_t> a, std::span<const std::int32_t> b,
                                               int lags);
/// The same at lag 0.
[[nodiscard]] double correlation(std::span<const std::int32_t> a, std::span<const std::int32_t> b);

}  // namespace hecaton::planner
