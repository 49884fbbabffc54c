#pragma once
/// What `hecaton plan` says.

#include <cmath>
#include <cstdint>
#include <string>

#include "planner/global/plan.hpp"
#include "planner/trajectory/averaged_trajectory.hpp"
#include "services/command_line/document.hpp"
#include "services/command_line/terminal.hpp"

namespace hecaton::services::cli {

struct PlanOutcome {
  std::string method;
  std::uint64_t seed = 1;
  planner::global::Plan plan;
  double planning_us = 0.0;
  double simplify_us = 0.0;
  double timing_us = 0.0;                  ///< of rounding the corners and finding the times
  double clearance = HUGE_VAL;             ///< on the path [m]
  double obstacle_clearance = HUGE_VAL;    ///< the same without that of links of one arm from each other [m]
  std::string effort;                      ///< in words, for people
  double duration = 0.0;                   ///< that the arm takes on a solved plan's path [s]
  planner::AveragedTrajectory trajectory;  ///< on it, unless the method is one that goes it itself
  std::vector<std::vector<double>> found;  ///< the path before it was shortened [rad | m]
  planner::global::SearchRecord record;    ///< of a search that is to be drawn
  std::vector<std::string> notes;          ///< PlanQuery's
};

/// The smallest distance on the path, from below (Validity::clearance) [m].
[[nodiscard]] double smallest_clearance(const planner::global::Validity& validity, const planner::global::Plan& plan,
                                        planner::global::Validity::Pairs pairs);

/// `period` [s]: of the samples of the trajectory; 0: none are printed.
[[nodiscard]] Json plan_json(const PlanOutcome& outcome, double period);
[[nodiscard]] std::string plan_text(const PlanOutcome& outcome, double period, const Palette& palette);

}  // namespace hecaton::services::cli
