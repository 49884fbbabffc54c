#pragma once
/// One query to the global planner: from here to there.

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "planner/global/global_planner.hpp"
#include "planner/global/registry.hpp"
#include "planner/global/simplify.hpp"

namespace hecaton::planner::global {

struct PlanOptions {
  std::shared_ptr<const GlobalPlanner> planner = default_planner();  ///< not null
  std::uint64_t seed = 1;
  Budget budget = {};  ///< of the search; its clock also ends shortening
  bool simplify = true;
  SimplifyOptions shortcuts = {};
  /// A found path is proven free everywhere (Validity::proven_free), and planned anew with ever finer checks where that
  /// fails: what a coarse check steps over is thin or grazed. Shortcuts are proven, too.
  bool certify = true;
  SearchRecord* record = nullptr;  ///< of the search that found the path, or the last; null: none
};

struct Plan {
  PlanStatus status = PlanStatus::kBudgetEnded;
  std::string reason;  ///< a sentence; empty when solved
  /// start … goal [rad | m], without jumps: a joint that turns without end may reach the goal turns aside; empty unless
  /// solved
  std::vector<std::vector<double>> path;
  double length = 0.0;  ///< in joint space [rad | m]
  std::uint64_t iterations = 0;
  std::uint64_t checks = 0;  ///< configurations looked at
  int nodes = 0;

  [[nodiscard]] bool solved() const { return status == PlanStatus::kSolved; }
};

/// The box of the planned arms' limits, closed along continuous joints.
[[nodiscard]] Space space_of(const Validity& validity);
/// For who does not know closed spaces: an open box, in which continuous joints get half a turn beyond start and goal.
[[nodiscard]] Space space_of(const Validity& validity, std::span<const double> start, std::span<const double> goal);

/// Nothing when the arm can be at q; otherwise one sentence that begins with `which`: "start" or "goal".
[[nodiscard]] std::optional<std::string> reject(const Validity& validity, std::string_view which,
                                                std::span<const double> q);

/// The search alone: path of Plan not yet simplified.
[[nodiscard]] Plan plan(const Validity& validity, std::span<const double> start, std::span<const double> goal,
                        const PlanOptions& options = {});

/// Shortens a solved plan's path. Called by plan() unless options.simplify is false.
void simplify(const Validity& validity, const PlanOptions& options, Plan& plan);

}  // namespace hecaton::planner::global
