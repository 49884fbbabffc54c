#pragma once
/// What `hecaton plan` is asked, as the global planner wants it.

#include <string>
#include <vector>

#include "planner/global/validity.hpp"
#include "planner/local/parameters.hpp"
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
  planner::PotentialParameters potential = {};  ///< of the first planned arm
};

/// Other arms stand where they start, obstacles where they are at t = 0. Throws Failure (bad input), ConfigError and
/// ModelError.
[[nodiscard]] PlanQuery make_plan_query(const PlanWords& words);

}  // namespace hecaton::services::cli
