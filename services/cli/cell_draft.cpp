#include "services/cli/cell_draft.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <optional>
#include <sstream>
#include <system_error>
#include <tuple>

#include "planner/cell_defaults.hpp"
#include "planner/collision/cell_geometry.hpp"
#include "planner/collision/model_filter.hpp"
#include "planner/local/random.hpp"
#include "planner/model/capsules.hpp"
#include "planner/model/kinematics.hpp"
#include "planner/simulation/tasks.hpp"
#include "services/arm_driver/device_choice.hpp"
#include "services/cli/pose_finder.hpp"
#include "services/command_line/options.hpp"
#include "services/command_line/program.hpp"
#include "services/command_line/terminal.hpp"
#include "services/config/robot_catalogue.hpp"
#include "services/config/text.hpp"

namespace hecaton::services::cli {
namespace {

namespace fs = std::filesystem;
using config::number_text;
using planner::JointVector;

constexpr double kAssumedVelocity = 1.0;  ///< of joints without a velocity limit [rad/s | m/s]
constexpr double kTilted = 0.1;           ///< a base with a larger roll or pitch does not stand on a floor [rad]
constexpr double kFloorThickness = 0.04;  ///< [m]
/// From the lowest base down to the floor; the first is taken that allows random goals and causes no warning [m]. The
/// lowest moving link of a small arm always stays near the floor.
constexpr std::array<double, 3> kFloorGaps = {0.01, 0.03, 0.05};
constexpr double kTableHeight = 0.3;     ///< bases above this height stand on a table [m]
constexpr double kPosePrecision = 1e-4;  ///< of poses in the file [rad | m]
constexpr double kAboveFloor = 0.1;      ///< least height of the task area above the lowest base [m]
constexpr int kTrials = 6;               ///< of drawing a task, all of which must succeed
/// Task areas that are tried in turn: size and raise as shares of the assumed size and radius. Near the bases and the
/// floor few postures are clear.
struct AreaShares {
  double size;
  double raise;
};
constexpr std::array<AreaShares, 4> kAreas = {{{1.0, 0.0}, {0.75, 0.0}, {0.75, 0.5}, {0.5, 0.75}}};

/// An arm of the draft with its model.
struct LoadedArm {
  const DraftArm* draft = nullptr;
  bool by_name = false;
  bool assumed_velocity = false;
  bool has_bare_links = false;  ///< moving links without collision geometry
  std::string base_link;        ///< joints above it move other arms of the robot, too, and are held; empty: the root
  planner::Arm arm;             ///< `named` has the robot's own poses at first, then those of the draft
};

/// Loads the URDF; where it lacks velocity limits or collision geometry, with what the draft can write for it.
void load_urdf_of(LoadedArm& loaded, planner::UrdfOptions& options) {
  const std::string& path = loaded.draft->robot;
  try {
    loaded.arm.model = planner::load_arm_model(path, options);
    return;
  } catch (const planner::ModelError&) {
    options.default_velocity = kAssumedVelocity;
    options.names.default_velocity = loaded.draft->name + ".limits.velocity";
  }
  try {
    loaded.arm.model = planner::load_arm_model(path, options);
  } catch (const planner::ModelError&) {
    options.allow_bare_links = true;
    loaded.arm.model = planner::load_arm_model(path, options);  // throws again for any other fault
    loaded.has_bare_links = true;
  }
  options.default_velocity.reset();
  try {
    static_cast<void>(planner::load_arm_model(path, options));
  } catch (const planner::ModelError&) {
    loaded.assumed_velocity = true;
  }
}

LoadedArm load_arm(const DraftArm& draft, const std::vector<std::string>& other_tools = {},
                   const std::string& base_link = {}) {
  LoadedArm loaded;
  loaded.draft = &draft;
  loaded.base_link = base_link;
  loaded.arm.name = draft.name;
  loaded.arm.X_WB = pose_of(draft.base);
  loaded.by_name = config::means_robot(draft.robot);
  if (!loaded.by_name && !fs::exists(draft.robot)) {
    throw Failure(ExitCode::kBadInput, draft.name + " = '" + config::printable(draft.robot) +
                                           "' must be the name of a robot or the path of a URDF; " +
                                           config::robot_suggestion(draft.robot));
  }
  planner::UrdfOptions options;
  options.base_link = base_link;
  options.tool_link = draft.tool_link;
  options.other_arms = other_tools;
  options.packages = draft.files.packages;
  options.xacro_arguments = draft.files.xacro_arguments;
  options.names.tool_link = config::printable(draft.robot) + ":LINK in place of " + config::printable(draft.robot);
  name_file_options(options);
  if (loaded.by_name) {
    planner::SourceFiles sources;
    loaded.arm.model = config::load_named_robot(config::read_named_robot(draft.robot, sources), options);
  } else {
    load_urdf_of(loaded, options);
  }
  loaded.arm.limits = loaded.arm.model->limits;
  loaded.arm.named = loaded.arm.model->named;
  const planner::CellGeometry geometry({loaded.arm}, 0);
  const auto& bodies = geometry.own_bodies();
  if (std::none_of(bodies.begin(), bodies.end(), [](const planner::Body& body) { return body.moves; })) {
    throw Failure(ExitCode::kBadInput, "'" + config::printable(draft.robot) +
                                           "' has no collision geometry that a joint moves, so that nothing could keep "
                                           "the arm clear: add <collision> elements to its links");
  }
  return loaded;
}

bool is_same_robot_at_same_base(const DraftArm& a, const DraftArm& b) {
  const auto place = [](const DraftArm& arm) { return fs::absolute(arm.robot).lexically_normal(); };
  return a.base == b.base && place(a) == place(b);
}

/// The last link of the arm's chain whose joint moves an arm of `others`, too; empty: none.
std::string shared_base(const LoadedArm& arm, const std::vector<const LoadedArm*>& others) {
  const planner::RobotModel& model = *arm.arm.model;
  std::string base;
  for (const planner::Link& link : model.links) {  // parents before children
    if (link.joint < 0 || link.follows) continue;
    const bool shared = std::any_of(others.begin(), others.end(), [&](const LoadedArm* other) {
      const auto& names = other->arm.model->joint_names;
      return std::find(names.begin(), names.end(), model.joint_names[static_cast<std::size_t>(link.joint)]) !=
             names.end();
    });
    if (shared) base = link.name;
  }
  return base;
}

/// Loads all arms. Arms of one robot at one base leave each other's links out, as in the cell file.
std::vector<LoadedArm> load_arms(const std::vector<DraftArm>& drafts) {
  std::vector<LoadedArm> arms;
  const auto arms_of_robot = [&](std::size_t arm) {
    std::vector<std::size_t> others;
    for (std::size_t i = 0; i < drafts.size(); ++i) {
      if (i != arm && is_same_robot_at_same_base(drafts[i], drafts[arm])) others.push_back(i);
    }
    return others;
  };
  const auto load = [&](std::size_t arm, const std::string& base_link) {
    std::vector<std::string> tools;
    for (const std::size_t other : arms_of_robot(arm)) tools.push_back(drafts[other].tool_link);
    return load_arm(drafts[arm], tools, base_link);
  };
  for (std::size_t i = 0; i < drafts.size(); ++i) arms.push_back(load(i, ""));
  std::vector<std::string> bases;
  for (std::size_t i = 0; i < drafts.size(); ++i) {
    std::vector<const LoadedArm*> others;
    for (const std::size_t other : arms_of_robot(i)) others.push_back(&arms[other]);
    bases.push_back(shared_base(arms[i], others));
  }
  for (std::size_t i = 0; i < drafts.size(); ++i) {
    if (!bases[i].empty()) arms[i] = load(i, bases[i]);
    const std::vector<std::size_t> others = arms_of_robot(i);
    if (!others.empty()) arms[i].arm.robot = static_cast<int>(std::min(i, others.front()));
  }
  return arms;
}

double lowest_base(const std::vector<LoadedArm>& arms) {
  double lowest = arms.front().draft->base[2];
  for (const LoadedArm& arm : arms) lowest = std::min(lowest, arm.draft->base[2]);
  return lowest;
}

/// Where the robots stand: at the lowest base, or lower with what is fixed to it, such as the legs of a humanoid [m].
double lowest_support(const std::vector<LoadedArm>& arms) {
  constexpr double kLeastLeg = 0.1;  // flanges and cables hang lower than a base, too [m]
  const double base = lowest_base(arms);
  double lowest = base;
  for (const LoadedArm& arm : arms) {
    const planner::RobotModel& model = *arm.arm.model;
    planner::Kinematics places;
    planner::place_links(model, arm.arm.X_WB, JointVector::Zero(model.joints()), places);
    for (const planner::LinkGeometry& geometry : model.geometry) {
      if (planner::moved_link(model, geometry.link) >= 0) continue;
      const planner::PlacedCapsule bound = planner::bounding_capsule(geometry.shape);
      const world::Pose X_WF = places.X_WL[geometry.link] * geometry.X_LS * bound.X_FS;
      const double half = bound.capsule.half_length * std::abs(X_WF.linear()(2, 2));
      lowest = std::min(lowest, X_WF.translation().z() - half);
    }
  }
  return lowest < base - kLeastLeg ? std::floor(1000.0 * lowest) / 1000.0 : base;
}

/// A box below all robots, with its top `gap` [m] under the lowest, that the arms cannot reach over.
world::Obstacle floor_below(const std::vector<LoadedArm>& arms, double gap) {
  Eigen::Vector2d low = Eigen::Vector2d::Constant(1e9);
  Eigen::Vector2d high = -low;
  for (const LoadedArm& arm : arms) {
    const double reach = planner::arm_reach(arm.arm).tool + 0.3;
    const Eigen::Vector2d base(arm.draft->base[0], arm.draft->base[1]);
    low = low.cwiseMin(base - Eigen::Vector2d::Constant(reach));
    high = high.cwiseMax(base + Eigen::Vector2d::Constant(reach));
  }
  const auto tenths = [](double length) { return std::ceil(length * 10.0) / 10.0; };
  const Eigen::Vector2d middle = 0.5 * (low + high);
  world::Obstacle floor;
  floor.name = lowest_support(arms) > kTableHeight ? "table" : "floor";
  floor.shapes.push_back(
      {world::Box{0.5 * Eigen::Vector3d(tenths(high.x() - low.x()), tenths(high.y() - low.y()), kFloorThickness)}});
  floor.X_WO.translation() =
      Eigen::Vector3d(std::round(middle.x() * 100.0) / 100.0, std::round(middle.y() * 100.0) / 100.0,
                      lowest_support(arms) - gap - 0.5 * kFloorThickness);
  return floor;
}

// The text.

std::string numbers_text(const auto& numbers, double precision) {
  std::string text = "[";
  for (Eigen::Index i = 0; i < static_cast<Eigen::Index>(numbers.size()); ++i) {
    const double rounded = std::round(numbers[i] / precision) * precision;
    text += (i > 0 ? ", " : "") + number_text(rounded == 0.0 ? 0.0 : rounded);  // no "-0"
  }
  return text + "]";
}

std::string base_text(const std::vector<double>& base) {
  const std::vector<double> xyz(base.begin(), base.begin() + 3);
  const std::vector<double> rpy(base.begin() + 3, base.end());
  const bool turned = std::any_of(rpy.begin(), rpy.end(), [](double angle) { return angle != 0.0; });
  return "{xyz: " + numbers_text(xyz, 1e-9) + (turned ? ", rpy: " + numbers_text(rpy, 1e-9) : "") + "}";
}

/// `path` of a URDF for a cell file in `folder`.
std::string path_from(const std::string& path, const fs::path& folder) {
  const fs::path absolute = fs::absolute(path).lexically_normal();
  const fs::path relative = absolute.lexically_relative(fs::absolute(folder).lexically_normal());
  return (relative.empty() ? absolute : relative).string();
}

bool is_own_pose(const LoadedArm& arm, const std::string& name, const JointVector& q) {
  const auto own = arm.arm.model->named.find(name);
  return own != arm.arm.model->named.end() && own->second == q;
}

/// `text` as a YAML text in single quotes.
std::string in_yaml_quotes(const std::string& text) {
  std::string quoted = "'";
  for (const char c : text) quoted += c == '\'' ? std::string("''") : std::string(1, c);
  return quoted + "'";
}

std::string map_text(const std::string& key, const std::map<std::string, std::string>& values) {
  std::string text;
  for (const auto& [name, value] : values) {
    text += (text.empty() ? "" : ", ") + in_yaml_quotes(name) + ": " + in_yaml_quotes(value);
  }
  return "    " + key + ": {" + text + "}\n";
}

std::string files_text(const RobotFileOptions& files, const fs::path& folder) {
  std::string text;
  if (!files.packages.empty()) {
    std::map<std::string, std::string> packages = files.packages;
    for (auto& [name, directory] : packages) directory = path_from(directory, folder);
    text += map_text("packages", packages);
  }
  if (!files.xacro_arguments.empty()) text += map_text("xacro", files.xacro_arguments);
  return text;
}

std::string arm_text(const LoadedArm& loaded, const fs::path& folder) {
  const DraftArm& draft = *loaded.draft;
  std::ostringstream out;
  out << "  - name: " << draft.name << "\n";
  if (loaded.by_name) {
    out << "    robot: " << draft.robot << "   # `hecaton robots " << draft.robot << "` describes it\n";
  } else {
    out << "    urdf: " << in_yaml_quotes(path_from(draft.robot, folder)) << "\n" << files_text(draft.files, folder);
  }
  if (!loaded.base_link.empty()) {
    out << "    chain: [" << in_yaml_quotes(loaded.base_link) << ", " << in_yaml_quotes(draft.tool_link)
        << "]   # joints above it move another arm, too, and are held at 0 or the nearest limit: joints: {NAME: VALUE} "
           "sets them\n";
  } else if (!draft.tool_link.empty()) {
    out << "    tool_link: " << in_yaml_quotes(draft.tool_link) << "\n";
  }
  out << "    base: " << base_text(draft.base) << "   # of the robot's root link in the world frame [m, rad]\n";
  if (loaded.assumed_velocity) {
    out << "    limits: {velocity: " << number_text(kAssumedVelocity)
        << "}   # the URDF has no velocity limit for some joint: write the real one\n";
  }
  if (loaded.has_bare_links) {
    out << "    allow_bare_links: true   # some moving link has no collision geometry and is kept clear of nothing: "
           "add "
           "<collision> to the URDF\n";
  }
  std::string poses;
  for (const auto& [name, q] : loaded.arm.named) {
    if (is_own_pose(loaded, name, q)) continue;
    poses += "      " + name + ": " + numbers_text(q, kPosePrecision) + "\n";
  }
  if (!poses.empty())
    out << "    poses:   # compact ones, clear of the arm itself, of other arms and of the floor [rad, m]\n" << poses;
  return out.str();
}

std::string tasks_text(const std::optional<planner::TaskArea>& area) {
  if (!area) {
    return "# Goals for `hecaton simulate` and `hecaton up --tasks`: all arms go from pose to pose together.\n"
           "# Random goals instead: `tasks: {centre: [x, y, z], radius: r}`, a cylinder that all arms reach.\n"
           "tasks:\n  pose_sequence: [home, ready]\n";
  }
  return "# Random goals for `hecaton simulate` and `hecaton up --tasks`: tool positions in a cylinder along z.\n"
         "tasks:\n" +
         std::string(area->of_each_arm ? "  frame: base   # each arm has its own cylinder: they have none in common\n"
                                       : "") +
         "  centre: " + numbers_text(area->centre, 1e-9) +
         (area->of_each_arm ? "   # from the base of each arm [m]" : "   # in the world frame [m]") +
         "\n  radius: " + number_text(area->radius) + "\n  half_height: " + number_text(area->half_height) + "\n";
}

std::string floor_text(const std::optional<world::Obstacle>& floor, double lowest) {
  if (!floor) {
    return "# Everything that the arms must not touch, such as a table, is an obstacle:\n"
           "# obstacles:\n#   - name: table\n#     shapes: [{type: box, size: [1, 1, 0.04]}]\n"
           "#     pose: {xyz: [0, 0, -0.03]}\n";
  }
  const Eigen::Vector3d size = 2.0 * std::get<world::Box>(floor->shapes.front().shape).half_extents;
  return "# Everything that the arms must not touch, such as a table, is an obstacle.\nobstacles:\n"
         "  - name: " +
         floor->name + "   # its top is " +
         number_text(std::round(100.0 * (lowest - floor->X_WO.translation().z() - 0.5 * size.z()))) +
         " cm below where the robots stand, its size is a guess: measure yours\n    shapes: [{type: box, size: " +
         numbers_text(size, 1e-9) +
         "}]\n    pose: {xyz: " + numbers_text(Eigen::Vector3d(floor->X_WO.translation()), 1e-9) + "}\n";
}

std::string cell_name(const std::string& path) {
  const std::string stem = fs::path(path).stem().string();
  return config::is_name(stem) ? stem : "cell";
}

std::string cell_text(const std::vector<LoadedArm>& arms, const std::optional<planner::TaskArea>& area,
                      const std::optional<world::Obstacle>& floor, const std::string& path) {
  std::string text =
      "# A cell of Hecaton, written by `hecaton init`. Check it: hecaton check " + path +
      "\n# Lengths are in metres, angles in radians. The reference of the cell file explains every key.\nname: " +
      cell_name(path) + "\n\n" + tasks_text(area) + "\narms:\n";
  for (const LoadedArm& arm : arms) text += arm_text(arm, fs::path(path).parent_path() / ".");
  return text + "\n" + floor_text(floor, lowest_support(arms));
}

bool draws_tasks(const planner::Cell& cell) {
  planner::TaskGenerator generator(cell);
  planner::Random random(1);
  for (int trial = 0; trial < kTrials; ++trial) {
    const auto starts = generator.draw_starts(random);
    if (!starts || !generator.draw_conflicting_goals(random, *starts)) return false;
  }
  return true;
}

/// The first area in which tasks can be drawn: the area that a cell without tasks gets, made smaller or raised if need
/// be. Empty: none.
std::optional<planner::TaskArea> drawable_area(planner::Cell cell, const std::vector<LoadedArm>& arms) {
  std::vector<planner::TaskArea> areas;
  if (const auto assumed = planner::default_task_area(cell)) {
    const auto rounded = [](double length) { return std::round(length * 100.0) / 100.0; };
    const double lowest = lowest_base(arms);
    const bool stands = !assumed->of_each_arm && assumed->centre.z() > lowest;
    for (const AreaShares& shares : kAreas) {
      planner::TaskArea area = *assumed;
      area.radius = rounded(shares.size * assumed->radius);
      area.half_height = rounded(shares.size * assumed->half_height);
      area.centre = assumed->centre.unaryExpr(rounded);
      if (stands) {
        const double raised = assumed->centre.z() + shares.raise * assumed->radius;
        area.centre.z() = rounded(std::max(raised, lowest + kAboveFloor + area.half_height));
      }
      if (area.radius > 0.0) areas.push_back(area);
    }
  }
  for (const planner::TaskArea& area : areas) {
    cell.tasks = area;
    if (draws_tasks(cell)) return area;
  }
  return std::nullopt;
}

/// `q` with as many decimals as the file will have.
JointVector rounded_within(const JointVector& q, const planner::JointLimits& limits) {
  const Eigen::ArrayXd low = (limits.lower.array() / kPosePrecision).ceil();
  const Eigen::ArrayXd high = (limits.upper.array() / kPosePrecision).floor();
  return ((q.array() / kPosePrecision).round().max(low).min(high) * kPosePrecision).matrix();
}

/// Sets the poses `home` and `ready` of all arms; false when an arm has none that is clear.
bool choose_poses(std::vector<LoadedArm>& arms, const std::optional<world::Obstacle>& floor) {
  std::vector<world::Obstacle> obstacles;
  if (floor) obstacles.push_back(*floor);
  const auto models = [&] {
    std::vector<planner::Arm> all;
    for (const LoadedArm& arm : arms) all.push_back(arm.arm);
    return all;
  };
  const PoseFinder finder(models(), obstacles);
  for (const char* name : {"home", "ready"}) {
    const auto poses = finder.find(models(), name);
    if (!poses) return false;
    for (std::size_t i = 0; i < arms.size(); ++i) {
      JointVector q = (*poses)[i];
      arms[i].arm.named[name] = is_own_pose(arms[i], name, q) ? q : rounded_within(q, arms[i].arm.limits);
    }
  }
  return true;
}

void require_distinct_names(const std::vector<DraftArm>& drafts) {
  for (std::size_t i = 0; i < drafts.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (drafts[i].name != drafts[j].name) continue;
      throw Failure(ExitCode::kBadInput, "two arms have the name " + drafts[i].name + "; each arm needs its own");
    }
  }
}

/// How to write two arms of the robot: "yumi:left_tool0 and yumi:right_tool0", or "my_robot.urdf:LINK".
std::string example_of_two_arms(const std::string& robot) {
  const std::vector<config::RobotTool> tools = config::tools_of(robot);
  if (tools.size() == 2) return robot + ":" + tools[0].link + " and " + robot + ":" + tools[1].link;
  return config::printable(robot) + ":LINK";
}

/// Two robots cannot stand at one place, but two arms of one robot do.
void require_distinct_places(const std::vector<DraftArm>& drafts) {
  for (std::size_t i = 0; i < drafts.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const DraftArm& a = drafts[j];
      const DraftArm& b = drafts[i];
      const bool two_arms = !a.tool_link.empty() && !b.tool_link.empty() && a.tool_link != b.tool_link;
      if (two_arms || !is_same_robot_at_same_base(a, b)) continue;
      const std::string robot = config::printable(b.robot);
      throw Failure(ExitCode::kBadInput, "arms " + a.name + " and " + b.name +
                                             " are the same robot at the same base: " + "give " + b.name +
                                             " another base, such as " + robot +
                                             "@\"1 0 0\"; two arms of one robot need a tool link each, as in " +
                                             example_of_two_arms(b.robot));
    }
  }
}

bool is_file(const std::string& path) {
  std::error_code ignored;
  return fs::exists(path, ignored) && !fs::is_directory(path, ignored);
}

/// A command finds the cell only with its file: it is not in the default domain, on all interfaces and open.
bool has_own_network(const config::CellFile& file) {
  const config::Network standard;
  return file.network.domain != standard.domain || file.network.transport != standard.transport ||
         file.network.discovery != standard.discovery || !file.network.interface.empty() || !file.keystore.empty();
}

}  // namespace

std::pair<std::string, std::string> split_tool_link(const std::string& robot) {
  const std::size_t colon = robot.rfind(':');
  if (colon == std::string::npos || is_file(robot)) return {robot, ""};
  const std::string before = robot.substr(0, colon);
  const std::string after = robot.substr(colon + 1);
  // A file that does not exist, in a folder with a colon: the message about it shall name the whole path.
  if (after.find('/') != std::string::npos && !is_file(before)) return {robot, ""};
  return {before, after};
}

DraftArm parse_draft_arm(const std::string& word) {
  const auto refuse = [&](const std::string& must_be) {
    throw Failure(ExitCode::kBadInput, "'" + config::printable(word) + "' must be " + must_be);
  };
  const std::string form =
      "NAME=ROBOT@\"x y z\" or NAME=ROBOT@\"x y z roll pitch yaw\", with metres and radians; ROBOT:LINK chooses a tool "
      "link";
  const std::size_t equals = word.find('=');
  if (equals == std::string::npos) refuse(form);
  const std::string rest = word.substr(equals + 1);
  // Without a base an @ belongs to the path.
  const auto [path_of_rest, link_of_rest] = split_tool_link(rest);
  const bool is_whole = is_file(path_of_rest) && link_of_rest.find('@') == std::string::npos;
  const std::size_t at = word.rfind('@');
  const bool placed = !is_whole && at != std::string::npos && at > equals;
  DraftArm arm;
  arm.name = word.substr(0, equals);
  std::tie(arm.robot, arm.tool_link) = split_tool_link(placed ? word.substr(equals + 1, at - equals - 1) : rest);
  if (!config::is_name(arm.name) || arm.robot.empty()) refuse(form + "; NAME is " + std::string(config::kNameRule));
  if (!placed) return arm;
  const ParsedNumbers parsed = parse_numbers({word.substr(at + 1)}, 0);
  const std::size_t count = parsed.numbers.size();
  if (parsed.error || (count != 3 && count != 6)) refuse(form);
  std::copy(parsed.numbers.begin(), parsed.numbers.end(), arm.base.begin());
  const bool near =
      std::all_of(arm.base.begin(), arm.base.end(), [](double x) { return std::abs(x) <= config::kFarthest; });
  if (!near) refuse("a base within ±" + number_text(config::kFarthest) + " m and rad");
  return arm;
}

void require_usable(const DraftArm& draft) {
  static_cast<void>(load_arm(draft));
}

CellDraft draft_cell(const std::vector<DraftArm>& drafts, const std::string& path) {
  require_distinct_names(drafts);
  require_distinct_places(drafts);
  std::vector<LoadedArm> arms = load_arms(drafts);
  const bool upright = std::all_of(drafts.begin(), drafts.end(), [](const DraftArm& arm) {
    return std::abs(arm.base[3]) < kTilted && std::abs(arm.base[4]) < kTilted;
  });
  const auto draft_with = [&](const std::optional<planner::TaskArea>& area,
                              const std::optional<world::Obstacle>& floor) {
    CellDraft draft;
    draft.text = cell_text(arms, area, floor, path);
    draft.file = config::parse_cell_file(draft.text, path);
    draft.findings = config::validate(draft.file);
    return draft;
  };
  /// With the goals that the arms can have, in the cell that choose_poses() left.
  const auto complete_draft = [&](const std::optional<world::Obstacle>& floor) {
    CellDraft draft = draft_with(std::nullopt, floor);
    if (arms.size() == 1) return draft;
    const auto area = drawable_area(draft.file.cell, arms);
    return area ? draft_with(area, floor) : draft;
  };
  // The floor that allows random goals, then one that causes no warning.
  const auto value_of = [&](const CellDraft& draft) {
    const bool warns = std::any_of(draft.findings.begin(), draft.findings.end(),
                                   [](const auto& finding) { return finding.severity != config::Severity::kNote; });
    const bool draws = arms.size() == 1 || draft.file.cell.tasks.pose_sequence.empty();
    return (draws ? 2 : 0) + (warns ? 0 : 1);
  };
  constexpr int kBestValue = 3;
  std::optional<CellDraft> best;
  for (const double gap : kFloorGaps) {
    const world::Obstacle floor = floor_below(arms, gap);
    if (!upright || !choose_poses(arms, floor)) continue;
    CellDraft draft = complete_draft(floor);
    if (!best || value_of(draft) > value_of(*best)) best = std::move(draft);
    if (value_of(*best) == kBestValue) break;
  }
  if (best) return *best;
  if (!choose_poses(arms, std::nullopt)) {
    throw Failure(ExitCode::kBadInput,
                  "the arms have no poses in which they are clear of themselves and of each other: move their bases "
                  "apart, or check each robot alone with 'hecaton check'");
  }
  return complete_draft(std::nullopt);
}

std::string goals_text(const planner::TaskArea& tasks) {
  if (!tasks.pose_sequence.empty()) return "goals: all arms go from pose home to pose ready and back";
  return "goals: random tool positions, within " + number_text(tasks.radius) + " m of [" +
         number_text(tasks.centre.x()) + ", " + number_text(tasks.centre.y()) + ", " + number_text(tasks.centre.z()) +
         (tasks.of_each_arm ? "] from each base" : "] in the world frame");
}

std::string next_steps(const config::CellFile& file, const std::vector<config::Finding>& findings) {
  const bool works = findings.empty() || findings.front().severity != config::Severity::kError;  // errors come first
  if (!works) return "next: change what the errors name, then check again\n";
  const bool has_tasks =
      file.cell.tasks.radius > 0.0 || !file.cell.tasks.pose_sequence.empty() || !file.cell.tasks.problem.areas.empty();
  const planner::Arm& arm = file.cell.arms.front().arm;
  const std::string pose = arm.named.contains("ready") ? "ready" : "home";  // arms start at home
  const std::string path = shell_word(file.path);
  std::vector<std::string> commands = device_steps(file);
  commands.push_back("hecaton goal " + arm.name + " --named " + pose + " --wait");
  std::string text = (has_tasks ? "next: hecaton simulate " + path + " --tasks 100\n"
                                : "next: add tasks, or begin with a live cell\n") +
                     "then: hecaton up " + path + "\n";
  if (file.hosts.size() > 1) {
    text += "or on each host, with its name: hecaton agent " + path + " --host " + file.hosts.front().name + "\n";
  }
  text += "and in a second terminal:\n";
  const std::string cell = has_own_network(file) ? " --cell " + path : "";
  for (const std::string& command : commands) {
    text += "  " + command + (command.starts_with('#') ? "" : cell) + "\n";
  }
  return text;
}

}  // namespace hecaton::services::cli
