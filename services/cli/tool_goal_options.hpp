#pragma once
/// The options of a goal of the tool frame, the same for every command: --pose, --position, --free, --tolerance.

#include <optional>
#include <string>
#include <vector>

#include "planner/model/tool_goal.hpp"

namespace CLI {
class App;
}  // namespace CLI

namespace hecaton::services::cli {

struct ToolGoalOptions {
  std::vector<double> pose;           ///< x y z [m] roll pitch yaw [rad]; empty: not given
  std::vector<double> position;       ///< x y z [m]; empty: not given
  std::string free_rotation;          ///< roll, pitch or yaw; empty: not given
  planner::ToolGoal tolerances = {};  ///< the pose is unused
};

/// Adds --pose and --position to `what`, which allows one of its options, and --free and --tolerance to `command`.
/// `options` must outlive the parsing.
void add_tool_goal_options(CLI::App& command, CLI::App& what, ToolGoalOptions& options);

/// Throws Failure (usage) for --tolerance without --pose and --position. Call it after parsing.
void check_tool_goal_options(const CLI::App& command);

/// The goal; empty when neither --pose nor --position is given.
[[nodiscard]] std::optional<planner::ToolGoal> tool_goal_of(const ToolGoalOptions& options);

}  // namespace hecaton::services::cli
