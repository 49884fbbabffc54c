#pragma once
/// The interface of a global planner, and the registry of planners. A planner finds a path between two configurations.
/// docs/how-to/add-a-global-planner.md explains how to add one; planner/global/registry.cpp lists Hecaton's.

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "planner/global/space.hpp"
#include "planner/global/validity.hpp"

namespace hecaton::planner::global {

/// How a query ended.
enum class PlanStatus {
  kSolved,        ///< there is a path
  kStartInvalid,  ///< outside of limits, or not free
  kGoalInvalid,   ///< outside of limits, or not free
  kBudgetEnded,   ///< more time might help
  kStuck,         ///< more time would not help
};

/// Limits of a search.
struct Budget {
  std::uint64_t iterations = 1'000'000;  ///< samples drawn
  std::function<bool()>
      ended;  ///< called from time to time; may read a clock, which planners must not. Empty: no limit
};

/// The trees or the roadmap of a search, for plots.
struct SearchRecord {
  Points nodes;                            ///< in the order in which they were found
  std::vector<std::pair<int, int>> edges;  ///< indices of nodes
};

/// Input of a search. References and pointers are valid during the search. Points are `space.stride` floats [rad | m].
struct SearchProblem {
  const Validity& validity;        ///< counts checks, therefore for one thread
  const Space& space;              ///< to sample in
  const float* start;              ///< free
  const float* goal;               ///< free
  std::uint64_t seed = 1;          ///< of all random numbers
  Budget budget = {};              ///< see over()
  EdgeCheck check = {};            ///< see edge_free()
  SearchRecord* record = nullptr;  ///< filled at the end of the search; may be null

  /// The only check of edges that a planner makes.
  [[nodiscard]] bool edge_free(const float* a, const float* b) const { return validity.edge_free(a, b, check); }

  /// True if a search must stop after `iteration` samples. Asks the budget every 64 samples and every kChecksUnasked
  /// checks, because a sample may need many checks.
  [[nodiscard]] bool over(std::uint64_t iteration) const {
    if (ended || iteration >= budget.iterations) return true;
    if (!budget.ended || (iteration % 64 != 63 && validity.checks() - asked_at < kChecksUnasked)) return false;
    asked_at = validity.checks();
    ended = budget.ended();
    return ended;
  }

  static constexpr std::uint64_t kChecksUnasked = 8192;  ///< a few ms
  mutable std::uint64_t asked_at = 0;                    ///< checks() when the budget was asked last
  mutable bool ended = false;                            ///< over() was true
};

/// A path, or why there is none.
struct SearchResult {
  PlanStatus status = PlanStatus::kBudgetEnded;  ///< kSolved, kBudgetEnded or kStuck
  std::string reason = {};                       ///< if kStuck: one sentence without a full stop
  Points path = Points();                        ///< start … goal; all straight edges are free
  std::uint64_t iterations = 0;                  ///< samples drawn
  int nodes = 0;                                 ///< of all trees or of the roadmap

  [[nodiscard]] bool solved() const { return status == PlanStatus::kSolved; }  ///< there is a path
};

/// What people see of a planner.
struct PlannerTraits {
  std::string_view name;     ///< in commands and reports
  std::string_view summary;  ///< one phrase, for lists
};

/// A global planner. Immutable and shared by threads. The planner only searches: plan() (planner/global/plan.hpp)
/// checks start and goal, and shortens the path.
class GlobalPlanner {
 public:
  explicit GlobalPlanner(const PlannerTraits& traits) : traits_(traits) {}  ///< the texts must outlive the planner
  virtual ~GlobalPlanner() = default;

  [[nodiscard]] const PlannerTraits& traits() const { return traits_; }  ///< as given

  /// Must check edges by problem.edge_free() only, and return soon after problem.over() holds. Draws all random numbers
  /// from problem.seed: on one machine, the same problem gives the same result to the last bit. No clock, log or
  /// network. Thread-safe for problems that do not share a validity.
  [[nodiscard]] virtual SearchResult search(const SearchProblem& problem) const = 0;

 private:
  PlannerTraits traits_;
};

/// A list of planners by name. A program with its own planners copies built_in_planners() and adds them.
class PlannerRegistry {
 public:
  /// A planner, shared by threads.
  using Shared = std::shared_ptr<const GlobalPlanner>;

  /// Throws std::invalid_argument if there is a planner of the same name.
  void add(Shared planner);
  /// The same for a planner without arguments.
  template <class Planner>
  void add() {
    add(std::make_shared<const Planner>());
  }

  /// In the order of their registration.
  [[nodiscard]] const std::vector<Shared>& planners() const { return planners_; }
  /// The planner of that name. Throws std::invalid_argument, which lists the names, if there is none.
  [[nodiscard]] const Shared& at(std::string_view name) const;

 private:
  std::vector<Shared> planners_;
};

/// Hecaton's planners, with default parameters. Thread-safe.
[[nodiscard]] const PlannerRegistry& built_in_planners();

/// RRT-Connect with default parameters. Thread-safe.
[[nodiscard]] std::shared_ptr<const GlobalPlanner> default_planner();

}  // namespace hecaton::planner::global
