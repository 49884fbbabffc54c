#pragma once
/// `hecaton plan --method potential_field`, and the pictures of `--plot`.

#include <string>

#include "planner/global/plan.hpp"
#include "planner/methods/potential_field/gradient_descent.hpp"
#include "services/cli/plan_query.hpp"

namespace hecaton::services::cli {

/// A query for one arm as a potential field takes it: whatever else there is stands still.
class FieldQuery {
 public:
  /// `margin` [m]: kept from obstacles and other arms. Throws Failure when the query is for several arms.
  FieldQuery(const PlanQuery& query, double margin);

  /// Not solved: `reason` says in what the descent ended, and how far from the goal.
  [[nodiscard]] planner::global::Plan plan();
  /// Post-processes a solved plan's path. Beyond the margin it keeps `keep` [m] where the whole path has that, else a
  /// quarter of it where it has that.
  void refine(planner::global::Plan& plan, double keep);

 private:
  const PlanQuery& query_;
  planner::CellGeometry geometry_;
  planner::potential::PotentialField field_;
  double margin_;  ///< [m]
  planner::potential::FreeMotion motion_;
};

/// The first planned arm on `plan`'s path, as an SVG; with `field` its potential field beside it, then `panels`.
[[nodiscard]] std::string plan_picture(const PlanQuery& query, const planner::global::Plan& plan, bool field,
                                       const std::string& title, std::vector<std::string> panels);

}  // namespace hecaton::services::cli
