#pragma once
/// What `hecaton plan` is asked, as the global planner wants it.

#include <string>
#include <vector>

#include "planner/cell.hpp"
#include "planner/global/validity.hpp"
#include "services/cli/robot_options.hpp"

namespace hecaton::services::cli {

struct PlanWords {
  std::string file;               ///< cell file or URDF
  std::vector<std::string> arms;  ///< of the cell; none: its only one, or its first
  std::string from;               ///< numbers, or the name of a pose; empty: where the arms start, or the request's
  std::string to;                 ///< the same; empty: the request's goal
  std::string moveit_scene;       ///< paths; empty: none
  std::string moveit_request;
  RobotOptions robot;
};

struct PlanQuery {
  std::vector<planner::CellGeometry> planned;  ///< the own arm of each; their joints follow one another
  std::vector<planner::global::WorldBody> world;
  std::vector<world::Obstacle> obstacles;  ///< as in the cell at t = 0
  std::vector<double> start;               ///< [rad | m]
  std::vector<double> goal;
  planner::PlannedArm first = {};  ///< the first planned arm, as its cell has it
  planner::Timing timing = {};     ///< of the cell
  double time_limit = 0.0;         ///< of its tasks, virtual [s]
  std::vector<std::string> notes;  ///< sentences: what of MoveIt's files does not matter here
};

/// Other arms stand where they start, obstacles where they are at t = 0. Throws Failure (bad input), ConfigError and
/// ModelError.
[[nodiscard]] PlanQuery make_plan_query(const PlanWords& words);

/// The planned arm. Throws Failure (usage) when there are several; `option`: what was given that is for one, such as
/// "--plot" or "--method potential_field".
[[nodiscard]] const planner::Arm& only_arm(const PlanQuery& query, const std::string& option);

/// Everything that stands in the only planned arm's way, and what it carries.
[[nodiscard]] std::vector<world::Obstacle> standing(const PlanQuery& query, const std::string& option);

}  // namespace hecaton::services::cli
