#include "services/cli/tool_goal_options.hpp"

#include <array>
#include <numbers>
#include <string_view>

#include <CLI/CLI.hpp>

#include "services/command_line/options.hpp"
#include "services/command_line/program.hpp"
#include "services/config/text.hpp"

namespace hecaton::services::cli {
namespace {

struct Unit {
  std::string_view name;
  double factor;
  bool angle;
};
constexpr std::array<Unit, 4> kUnits{
    {{"mm", 1e-3, false}, {"m", 1.0, false}, {"deg", std::numbers::pi / 180.0, true}, {"rad", 1.0, true}}};

[[noreturn]] void refuse(const std::string& word) {
  throw Failure(ExitCode::kBadInput,
                "--tolerance = '" + config::printable(word) +
                    "' must be a distance from 0.01mm to 1m or an angle from 0.01deg to 180deg, each at most once: "
                    "'2mm', '1deg' or '2mm,1deg'");
}

/// Splits "2mm,1deg".
std::vector<std::string> split(const std::vector<std::string>& words) {
  std::vector<std::string> pieces(1);
  for (const std::string& word : words) {
    for (const char c : word + ",") {
      if (c != ',' && c != ' ') {
        pieces.back() += c;
      } else if (!pieces.back().empty()) {
        pieces.emplace_back();
      }
    }
  }
  pieces.pop_back();
  return pieces;
}

void read_tolerance(const std::string& word, std::array<bool, 2>& given, planner::ToolGoal& tolerances) {
  constexpr double kRounding = 1.0 + 1e-9;  // 0.01deg and 180deg are allowed
  const std::size_t begin = word.find_last_not_of("dmegra") + 1;
  for (const Unit& unit : kUnits) {
    if (std::string_view(word).substr(begin) != unit.name) continue;
    const auto number = config::parse_number(std::string_view(word).substr(0, begin));
    const double least = unit.angle ? planner::kLeastOrientationTolerance : planner::kLeastPositionTolerance;
    const double most = unit.angle ? planner::kMostOrientationTolerance : planner::kMostPositionTolerance;
    if (!number || given[unit.angle ? 1 : 0]) refuse(word);
    const double value = *number * unit.factor;
    if (!(value * kRounding >= least && value <= most * kRounding)) refuse(word);
    given[unit.angle ? 1 : 0] = true;
    (unit.angle ? tolerances.orientation_tolerance : tolerances.position_tolerance) = value;
    return;
  }
  refuse(word);
}

}  // namespace

void add_tool_goal_options(CLI::App& command, CLI::App& what, ToolGoalOptions& options) {
  CLI::Option* pose = add_pose(what, "--pose", options.pose,
                               "position and orientation of the tool frame: x y z [m] roll pitch yaw [rad]");
  add_numbers(what, "--position", options.position, 3, "position of the tool frame, in any orientation: x y z [m]",
              config::kCoordinate)
      ->excludes(pose);
  add_choice(command, "--free", options.free_rotation, {"roll", "pitch", "yaw"},
             "with --pose: the tool may turn about its own x (roll), y (pitch) or z axis (yaw)")
      ->needs(pose);
  const auto read = [&options](const std::vector<std::string>& words) {
    std::array<bool, 2> given{};
    const std::vector<std::string> pieces = split(words);
    if (pieces.empty()) refuse("");
    for (const std::string& piece : pieces) read_tolerance(piece, given, options.tolerances);
  };
  command
      .add_option_function<std::vector<std::string>>(
          "--tolerance", read, "with --pose or --position: largest error of the tool at a reached goal (1mm,0.5deg)")
      ->expected(1, 2)
      ->type_name("TOLERANCE");
}

void check_tool_goal_options(const CLI::App& command) {
  if (command.count("--tolerance") == 0 || command.count("--pose") + command.count("--position") > 0) return;
  throw Failure(ExitCode::kUsage,
                "--tolerance is for --pose and --position: other goals have goal_tolerance in the cell file");
}

std::optional<planner::ToolGoal> tool_goal_of(const ToolGoalOptions& options) {
  if (options.pose.empty() && options.position.empty()) return std::nullopt;
  planner::ToolGoal goal = options.tolerances;
  if (options.pose.empty()) {
    goal.X_WT.translation() << options.position.at(0), options.position.at(1), options.position.at(2);
    goal.free_rotation = planner::FreeRotation::kAll;
    return goal;
  }
  goal.X_WT = pose_of(options.pose);
  if (options.free_rotation == "roll") goal.free_rotation = planner::FreeRotation::kRoll;
  if (options.free_rotation == "pitch") goal.free_rotation = planner::FreeRotation::kPitch;
  if (options.free_rotation == "yaw") goal.free_rotation = planner::FreeRotation::kYaw;
  return goal;
}

}  // namespace hecaton::services::cli
