#pragma once
/// One query to the global planner: from here to there.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "planner/global/search.hpp"
#include "planner/global/simplify.hpp"

namespace hecaton::planner::global {

enum class Method { kRrtConnect, kRrt, kEst, kPrm };

struct PlanOptions {
  Method method = Method::kRrtConnect;
  std::uint64_t seed = 1;
  Budget budget = {};  ///< of the search; its clock also ends shortening
  RrtOptions rrt = {};
  EstOptions est = {};
  PrmOptions prm = {};
  bool simplify = true;
  SimplifyOptions shortcuts = {};
  /// A found path is proven free everywhere (Validity::proven_free), and planned anew with ever finer checks where that
  /// fails: what a coarse check steps over is thin or grazed. Shortcuts are proven, too.
  bool certify = true;
  SearchRecord* record = nullptr;  ///< of the search that found the path, or the last; null: none
};

enum class PlanStatus {
  kSolved,
  kStartInvalid,
  kGoalInvalid,
  kBudgetEnded,
  kStuck,  ///< a method that does not search cannot go on
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

/// Start or goal as messages say why it cannot be; empty when it can. `which`: "start", "goal".
[[nodiscard]] std::string reject(const Validity& validity, std::string_view which, std::span<const double> q);

/// The search alone: path of Plan not yet simplified.
[[nodiscard]] Plan plan(const Validity& validity, std::span<const double> start, std::span<const double> goal,
                        const PlanOptions& options = {});

/// Shortens a solved plan's path. Called by plan() unless options.simplify is false.
void simplify(const Validity& validity, const PlanOptions& options, Plan& plan);

/// "rrt_connect", …
[[nodiscard]] std::string_view name_of(Method method);

}  // namespace hecaton::planner::global
