#pragma once
/// The motion problem of a cell [Mediavilla02, section 2.2] for the fast simulation, and its random tasks.

#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

#include "planner/cell.hpp"
#include "planner/model/arm.hpp"
#include "planner/strategy_search/run_kernel.hpp"

namespace hecaton::planner {

/// A cell, or a request, that the strategy search does not support. what(): one sentence.
class ProblemError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The arm for the fast simulation: its first `avoiding` joints move, all later joints stay at `q_rest` (of all
/// joints) [rad | m]. Capsules enclose the link shapes. Throws ProblemError if a fixed size of FlatArm is exceeded. See
/// flat_arm.cpp.
[[nodiscard]] FlatArm flatten(const Arm& arm, int avoiding, const JointVector& q_rest);

/// Upper bound of the distance of the body's segment from the origin of the first joint [m].
[[nodiscard]] double reach_from_first_joint(const FlatArm& arm, const FlatBody& body);

/// Upper bound of the distance of the arm's segments from the first joint's axis [m].
[[nodiscard]] double reach_of(const FlatArm& arm);

/// The tasks of one seed, the same for all strategies.
struct TaskSet {
  int tasks = 0;  ///< of each arm, N
  std::vector<std::vector<double>> goals;
  std::vector<std::vector<std::int32_t>> waits;
  std::vector<std::vector<double>> starts;
  /// Results of precheck_paths(), see FlatPaths.
  struct Paths {
    std::vector<std::int32_t> first;
    std::vector<std::uint8_t> self_free;
    std::vector<float> places;
  };
  std::vector<Paths> paths;
  FlatTasks flat;  ///< points to the data above
  TaskSet() = default;
  TaskSet(TaskSet&&) = default;
  TaskSet& operator=(TaskSet&&) = default;
  TaskSet(const TaskSet&) = delete;
  TaskSet& operator=(const TaskSet&) = delete;
  ~TaskSet() = default;
};

/// Thread-safe as long as flat() is not modified.
class StrategyProblem {
 public:
  /// Successive areas of an arm must not overlap; the reader of cell files checks this. Throws ProblemError if the cell
  /// has no motion problem, an arm has no areas, or a fixed size of FlatProblem is exceeded.
  explicit StrategyProblem(const Cell& cell);

  [[nodiscard]] int arms() const { return flat_.arms; }
  [[nodiscard]] const std::string& name_of(int arm) const { return names_[arm]; }
  /// Number of coefficients α, β, … of the arm's strategy.
  [[nodiscard]] int coefficients(int arm) const { return flat_.arm[arm].joints - 2; }
  [[nodiscard]] const FlatProblem& flat() const { return flat_; }
  /// To change h, Δ or the order of neighbours.
  [[nodiscard]] FlatProblem& flat() { return flat_; }

  /// Draws goals in the areas, within the limits and clear of the arm itself and of obstacles, and starts that are
  /// clear of the other arms as well. Throws ProblemError if none is found.
  [[nodiscard]] TaskSet draw(std::uint64_t seed, int tasks) const;

  /// Checks the straight paths of the first tasks in advance (48 MB per arm at most). Saves time if several strategies
  /// are evaluated on these tasks; does not change results.
  void precheck_paths(TaskSet& tasks) const;

  /// Sentences about parts of the cell that the simulation simplifies.
  [[nodiscard]] const std::vector<std::string>& notes() const { return notes_; }

 private:
  void add_obstacle(const world::Obstacle& obstacle);

  FlatProblem flat_;
  std::vector<std::string> names_;
  std::vector<std::vector<JointVector>> areas_;  ///< centres per arm, of the moving joints [rad]
  std::vector<std::vector<std::string>> area_names_;
  double spread_ = 0.0;
  double mean_wait_ = 0.0;
  std::vector<std::string> notes_;
};

}  // namespace hecaton::planner
