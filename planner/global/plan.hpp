#pragma once
/// One query to the global planner: checks of its ends, search, and shortening of the path.

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "planner/global/global_planner.hpp"

namespace hecaton::planner::global {

/// How a path is shortened.
struct SimplifyOptions {
  int passes = 2;        ///< cuts of all corners after the greedy shortcuts
  EdgeCheck check = {};  ///< of shortcuts; plan() sets it to PlanOptions::check
  /// Clearance from the world, beyond the padding, that a shortcut must not reduce [m]. In three grades: all of it, a
  /// quarter, none. A shortcut has at least the grade of the worst edge that it replaces.
  double clearance = 0.0;
  std::function<bool()> ended = {};  ///< called before each check of an edge; true: keep the path as it is
};

/// A path with the same ends that is not longer and passes the same checks. Joins each point with the farthest one that
/// has a free edge. Each pass cuts off the corners, and joins again.
[[nodiscard]] Points simplified(const Points& path, const Validity& validity, const Space& space,
                                const SimplifyOptions& options = {});

/// Length in joint space [rad | m].
[[nodiscard]] double length(const Points& path, const Space& space);

/// How a query is answered.
struct PlanOptions {
  std::shared_ptr<const GlobalPlanner> planner = default_planner();  ///< must not be null
  std::uint64_t seed = 1;                                            ///< of the search
  Budget budget = {};              ///< of the search; budget.ended also ends the shortening
  bool simplify = true;            ///< shorten the path
  SimplifyOptions shortcuts = {};  ///< if `simplify`
  EdgeCheck check = {};            ///< of all edges, also of shortcuts
  SearchRecord* record = nullptr;  ///< of the last search; may be null
};

/// The answer to a query.
struct Plan {
  PlanStatus status = PlanStatus::kBudgetEnded;  ///< how the query ended
  std::string reason;                            ///< one sentence if not solved; empty otherwise
  /// start … goal [rad | m], without jumps: a continuous joint may reach the goal plus full turns. Empty unless solved.
  std::vector<std::vector<double>> path;
  double length = 0.0;           ///< in joint space [rad | m]
  std::uint64_t iterations = 0;  ///< samples drawn
  std::uint64_t checks = 0;      ///< configurations checked
  int nodes = 0;                 ///< of all trees or of the roadmap

  [[nodiscard]] bool solved() const { return status == PlanStatus::kSolved; }  ///< there is a path
};

/// The box of the planned arms' limits, periodic in continuous joints.
[[nodiscard]] Space space_of(const Validity& validity);
/// The same without periods: continuous joints get half a turn beyond start and goal.
[[nodiscard]] Space space_of(const Validity& validity, std::span<const double> start, std::span<const double> goal);

/// Empty if q is within the limits and free; otherwise one sentence that begins with `which` ("start" or "goal").
[[nodiscard]] std::optional<std::string> reject(const Validity& validity, std::string_view which,
                                                std::span<const double> q);

/// Finds a path between two configurations: checks both, searches, and shortens the path.
[[nodiscard]] Plan plan(const Validity& validity, std::span<const double> start, std::span<const double> goal,
                        const PlanOptions& options = {});

/// Shortens the path of a solved plan. plan() calls it unless options.simplify is false.
void simplify(const Validity& validity, const PlanOptions& options, Plan& plan);

}  // namespace hecaton::planner::global
