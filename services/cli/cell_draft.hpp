#pragma once
/// Drafts of cell files, for `hecaton init`: from robots and bases to a commented cell that can start.

#include <string>
#include <utility>
#include <vector>

#include "services/cli/robot_options.hpp"
#include "services/config/cell_file.hpp"
#include "services/config/validate.hpp"

namespace hecaton::services::cli {

/// An arm of the draft.
struct DraftArm {
  std::string name;
  std::string robot;            ///< a name of the catalogue, or the path of a URDF
  std::string tool_link;        ///< empty: the robot's first tool, or the end of the longest chain
  RobotFileOptions files = {};  ///< not used for a robot of the catalogue
  std::vector<double> base = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0};  ///< x y z [m] roll pitch yaw [rad], in W
};

/// Reads `left=ur5e@-0.5 0 0`, with rotation `left=ur5e@-0.5 0 0 0 0 3.14`, with a tool link `left=yumi:left_tool0`.
/// Without `@…` the base is the origin. A `:` or `@` in the path of a file that exists belongs to the path. Throws
/// Failure (bad input).
[[nodiscard]] DraftArm parse_draft_arm(const std::string& word);

/// `yumi:left_tool0` as robot and tool link, which is empty without a colon. A colon in the path of a file that exists
/// belongs to the path.
[[nodiscard]] std::pair<std::string, std::string> split_tool_link(const std::string& robot);

/// Throws Failure (bad input) or planner::ModelError unless the robot can be loaded as the arm of a draft.
void require_usable(const DraftArm& arm);

struct CellDraft {
  std::string text;  ///< of the cell file
  config::CellFile file;
  std::vector<config::Finding> findings;  ///< of config::validate()
};

/// Drafts a cell file that is to stand at `path`. The draft has
/// - poses `home` and `ready`, compact ones, of robots whose own poses are missing or in the way of another arm,
/// - a floor (a table under raised bases) 1 to 5 cm below the lowest base or leg, unless a base is tilted or no arm
///   keeps clear of it,
/// - tasks: a cylinder in which tasks can be drawn; without one, or with a single arm, `home` and `ready` in turn.
/// Arms of one robot at one base, with a tool link each, are its two arms; joints that move both are held.
/// Deterministic; takes some seconds for ten arms. Throws Failure (bad input), planner::ModelError or
/// config::ConfigError when no cell of these robots and bases can start.
[[nodiscard]] CellDraft draft_cell(const std::vector<DraftArm>& arms, const std::string& path);

/// Where the goals of the draft are: "random, in a cylinder …", or "from pose to pose …".
[[nodiscard]] std::string goals_text(const planner::TaskArea& tasks);

/// What a user does after a check of the cell: lines with commands.
[[nodiscard]] std::string next_steps(const config::CellFile& file, const std::vector<config::Finding>& findings);

}  // namespace hecaton::services::cli
