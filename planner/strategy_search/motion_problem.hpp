#pragma once
/// The motion problem of a cell [Mediavilla02, section 2.2], ready to be simulated fast, and its random tasks.

#include <cstdint>
#include <string>
#include <vector>

#include "planner/cell.hpp"
#include "planner/strategy_search/run_kernel.hpp"

namespace hecaton::planner {

/// The tasks of one seed: drawn once, the same for every strategy.
struct TaskSet {
  int tasks = 0;  ///< of each arm, N
  std::vector<std::vector<double>> goals;
  std::vector<std::vector<std::int32_t>> waits;
  std::vector<std::vector<double>> starts;
  /// What precheck_paths() has found.
  struct Paths {
    std::vector<std::int32_t> first;
    std::vector<std::uint8_t> alone;
    std::vector<float> places;
  };
  std::vector<Paths> paths;
  FlatTasks flat;  ///< refers to the above
  TaskSet() = default;
  TaskSet(TaskSet&&) = default;
  TaskSet& operator=(TaskSet&&) = default;
  TaskSet(const TaskSet&) = delete;
  TaskSet& operator=(const TaskSet&) = delete;
  ~TaskSet() = default;
};

class StrategyProblem {
 public:
  /// No two areas in a row may overlap: the reader of cell files sees to that.
  /// Throws ProblemError when the cell has no motion problem, an arm has no areas, or something does not fit.
  explicit StrategyProblem(const Cell& cell);

  [[nodiscard]] int arms() const { return flat_.arms; }
  [[nodiscard]] const std::string& name_of(int arm) const { return names_[arm]; }
  /// Numbers α, β, … that a strategy of the arm has.
  [[nodiscard]] int coefficients(int arm) const { return flat_.arm[arm].joints - 2; }
  [[nodiscard]] const FlatProblem& flat() const { return flat_; }
  /// For comparisons: h, Δ, the order of neighbours.
  [[nodiscard]] FlatProblem& flat() { return flat_; }

  /// Goals in the balls of the areas, each clear of its arm's limits, itself and obstacles; starts at which arms are
  /// clear of each other, too. Throws ProblemError when none are found.
  [[nodiscard]] TaskSet draw(std::uint64_t seed, int tasks) const;

  /// Looks at straight ways beforehand, of as many tasks as fit into some megabytes: worth it for tasks that several
  /// strategies are tried on, and of no consequence for what is found.
  void precheck_paths(TaskSet& tasks) const;

  /// Sentences about what of the cell is simulated otherwise than it is.
  [[nodiscard]] const std::vector<std::string>& notes() const { return notes_; }

 private:
  void add_obstacle(const world::Obstacle& obstacle);

  FlatProblem flat_;
  std::vector<std::string> names_;
  std::vector<std::vector<JointVector>> areas_;  ///< centres, per arm, of the joints that avoid [rad]
  std::vector<std::vector<std::string>> area_names_;
  double spread_ = 0.0;
  double mean_wait_ = 0.0;
  std::vector<std::string> notes_;
};

}  // namespace hecaton::planner
