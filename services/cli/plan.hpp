#pragma once
/// Parts of `hecaton plan`: the query, planning by a motion method, and the output.

#include <cmath>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "planner/cell.hpp"
#include "planner/global/plan.hpp"
#include "planner/global/validity.hpp"
#include "planner/goal_check.hpp"
#include "planner/methods/potential_field/gradient_path.hpp"
#include "planner/trajectory/jerk_limited.hpp"
#include "services/cli/robot_options.hpp"
#include "services/cli/tool_goal_options.hpp"
#include "services/command_line/document.hpp"
#include "services/command_line/long_work.hpp"
#include "services/command_line/terminal.hpp"
#include "services/config/validate.hpp"

namespace hecaton::services::cli {

/// The query as given on the command line.
struct PlanArguments {
  std::string file;               ///< cell file or URDF
  std::vector<std::string> arms;  ///< of the cell; empty: the first
  std::string from;            ///< numbers or the name of a pose; empty: the request's start, or where the arms start
  std::string to;              ///< the same; empty: the request's goal, or the tool goal
  ToolGoalOptions tool;        ///< of the only planned arm
  std::string moveit_scene;    ///< path; empty: none
  std::string moveit_request;  ///< path; empty: none
  RobotOptions robot;
};

/// The query as the global planner takes it.
struct PlanQuery {
  std::vector<planner::CellGeometry> planned;  ///< one per planned arm, which is its own arm; joints follow one another
  std::vector<planner::global::WorldBody> world;
  std::vector<world::Obstacle> obstacles;  ///< of the cell at t = 0
  std::vector<double> start;               ///< [rad | m]
  std::vector<double> goal;                ///< [rad | m]; empty: that of `tool`, see resolve_tool_goal()
  std::optional<planner::ToolGoal> tool = {};
  planner::PlannedArm first = {};  ///< the first planned arm, as its cell has it
  planner::Timing timing = {};     ///< of the cell
  double time_limit = 0.0;         ///< of the cell's tasks, virtual [s]
  std::vector<std::string> notes;  ///< sentences: which parts of MoveIt's files are not read
};

/// Other arms stand where they start, obstacles where they are at t = 0. Throws Failure (bad input), ConfigError and
/// ModelError.
[[nodiscard]] PlanQuery make_plan_query(const PlanArguments& arguments);

/// Sets query.goal to a configuration for query.tool that `check` accepts, if there is one.
planner::ToolGoalAnswer resolve_tool_goal(PlanQuery& query, const planner::ConfigurationCheck& check);

/// The planned arm. Throws Failure (usage) when the query has several arms; `option` is the option that requires one
/// arm, such as "--plot".
[[nodiscard]] const planner::Arm& only_arm(const PlanQuery& query, std::string_view option);

/// Obstacles for the only planned arm: world bodies, other arms, and objects that it carries.
[[nodiscard]] std::vector<world::Obstacle> obstacles_of_only_arm(const PlanQuery& query, const std::string& option);

[[nodiscard]] planner::JointVector joints_of(const std::vector<double>& values);
[[nodiscard]] std::vector<planner::JointVector> joints_of(const std::vector<std::vector<double>>& path);

/// Plans for one arm by gradient descent in its potential field. Everything else stands still.
class FieldQuery {
 public:
  /// `margin` [m]: distance kept from obstacles and other arms. Throws Failure when the query has several arms.
  FieldQuery(const PlanQuery& query, double margin);

  /// If it is not solved, `reason` says how the descent ended and how far from the goal.
  [[nodiscard]] planner::global::Plan plan();
  /// Shortens a solved plan's path. Beyond the margin it keeps `keep` [m] where the whole path has that, otherwise a
  /// quarter of it where the whole path has that.
  void refine(planner::global::Plan& plan, double keep);

 private:
  const PlanQuery& query_;
  planner::CellGeometry geometry_;
  planner::potential::PotentialField field_;
  double margin_;  ///< [m]
  planner::potential::FreeMotion motion_;
};

struct SimulatedPlan {
  planner::global::Plan plan;  ///< iterations: searches; checks: control periods; nodes: known points
  double duration = 0.0;       ///< virtual [s]
  int plots = 0;               ///< files written
};

/// Simulates the only planned arm moving by `method` from start to goal; everything else stands still. `seed`: of its
/// sensors' noise. `plot`: folder for a plot of every step; empty: none. A plan that is not solved says why. Throws
/// Failure when the query has several arms, when the cell does not suit the method, and when a plot cannot be written.
/// `ended`: called with the virtual time [s] in every period; true ends the simulation.
[[nodiscard]] SimulatedPlan plan_by_simulation(const PlanQuery& query, const planner::global::Validity& validity,
                                               const std::string& method, std::uint64_t seed, const std::string& plot,
                                               const std::function<bool(double)>& ended);

/// The result, for printing.
struct PlanOutcome {
  std::string method;
  std::uint64_t seed = 1;
  planner::global::Plan plan;
  double planning_us = 0.0;
  double simplify_us = 0.0;
  double timing_us = 0.0;                              ///< for rounding the corners and computing the times
  double clearance = HUGE_VAL;                         ///< smallest on the path [m]
  double obstacle_clearance = HUGE_VAL;                ///< smallest on the path, without pairs of links of one arm [m]
  std::string effort;                                  ///< for people
  double duration = 0.0;                               ///< of the motion along a solved plan's path [s]
  planner::AveragedTrajectory trajectory;              ///< along the path; empty for simulated plans
  std::vector<std::vector<double>> found;              ///< the path before it was shortened [rad | m]
  planner::global::SearchRecord record;                ///< of the search, when it is to be plotted
  std::vector<config::Finding> findings;               ///< notes of the query
  std::optional<Interrupted> interrupted;              ///< empty: planning was complete
  std::optional<planner::NearestOrientation> nearest;  ///< when the tool cannot take the orientation of the goal
};

/// A lower bound of the smallest distance on the path (Validity::clearance) [m].
[[nodiscard]] double smallest_clearance(const planner::global::Validity& validity, const planner::global::Plan& plan,
                                        planner::global::Validity::Pairs pairs);

/// `period` [s]: of the trajectory's samples; 0: none are printed.
[[nodiscard]] Json plan_json(const PlanOutcome& outcome, double period);
[[nodiscard]] std::string plan_text(const PlanOutcome& outcome, double period, const Palette& palette);

/// The only planned arm on the path, as an SVG; with `field` its potential field. For two joints also the tree or
/// roadmap of the search, if `outcome` has its record.
[[nodiscard]] std::string plan_plot(const PlanQuery& query, const planner::global::Validity& validity,
                                    const PlanOutcome& outcome, bool field);

}  // namespace hecaton::services::cli
