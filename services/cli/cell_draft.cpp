#include "services/cli/cell_draft.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <optional>
#include <sstream>

#include "planner/collision/cell_geometry.hpp"
#include "planner/collision/model_filter.hpp"
#include "planner/local/random.hpp"
#include "planner/model/kinematics.hpp"
#include "planner/simulation/tasks.hpp"
#include "services/command_line/options.hpp"
#include "services/command_line/program.hpp"
#include "services/config/overlaps.hpp"
#include "services/config/robot_catalogue.hpp"
#include "services/config/text.hpp"

namespace hecaton::services::cli {
namespace {

namespace fs = std::filesystem;
using config::number_text;
using planner::JointVector;

constexpr double kAssumedVelocity = 1.0;  ///< of joints without a velocity limit [rad/s | m/s]
constexpr double kTilted = 0.1;           ///< a base with a larger roll or pitch does not stand on a floor [rad]
constexpr double kFloorGap = 0.01;        ///< from the lowest base down to the floor [m]
constexpr double kFloorThickness = 0.04;  ///< [m]
/// Clearances that a pose found by sampling should have, the widest first [m].
constexpr std::array<double, 3> kWanted = {0.08, 0.05, 0.03};
/// Clearance to other arms and the floor with which a robot's own pose is taken [m].
constexpr double kOwnPoseClearance = 0.03;
constexpr int kPoseSamples = 2000;
constexpr double kApart = 0.5;           ///< least distance of `ready` from `home` in joint space [rad | m]
constexpr double kPosePrecision = 1e-4;  ///< of poses in the file [rad | m]
constexpr double kAboveFloor = 0.1;      ///< least height of the task area above the lowest base [m]
constexpr int kReachSamples = 6000;
constexpr int kTrials = 3;  ///< of drawing a task

/// An arm of the draft with its model.
struct LoadedArm {
  const DraftArm* draft = nullptr;
  bool by_name = false;
  bool assumed_velocity = false;
  planner::Arm arm;  ///< `named` has the robot's own poses at first, then those of the draft
};

struct TaskCylinder {
  Eigen::Vector3d centre_W;
  double radius;
  double half_height;
};

LoadedArm load_arm(const DraftArm& draft) {
  LoadedArm loaded;
  loaded.draft = &draft;
  loaded.arm.name = draft.name;
  loaded.arm.X_WB = pose_of(draft.base);
  loaded.by_name = !fs::exists(draft.robot);
  if (loaded.by_name && !config::is_robot_name(draft.robot)) {
    throw Failure(ExitCode::kBadInput, draft.name + " = '" + config::printable(draft.robot) +
                                           "' must be the name of a robot or the path of a URDF; " +
                                           config::robot_suggestion(draft.robot));
  }
  planner::UrdfOptions options;
  options.tool_link = draft.tool_link;
  if (loaded.by_name) {
    planner::SourceFiles sources;
    loaded.arm.model = config::load_named_robot(config::read_named_robot(draft.robot, sources), options);
  } else {
    try {
      loaded.arm.model = planner::load_arm_model(draft.robot, options);
    } catch (const planner::ModelError&) {
      options.default_velocity = kAssumedVelocity;
      options.names.default_velocity = draft.name + ".limits.velocity";
      loaded.arm.model = planner::load_arm_model(draft.robot, options);  // throws again for any other fault
      loaded.assumed_velocity = true;
    }
  }
  loaded.arm.limits = loaded.arm.model->limits;
  loaded.arm.named = loaded.arm.model->named;
  return loaded;
}

JointVector sample(const planner::JointLimits& limits, planner::Random& random) {
  JointVector q(limits.lower.size());
  for (Eigen::Index joint = 0; joint < q.size(); ++joint) {
    q[joint] = random.uniform(std::max(limits.lower[joint], -std::numbers::pi),
                              std::min(limits.upper[joint], std::numbers::pi));
  }
  return q;
}

/// The zero position, moved into the limits.
JointVector nearest_to_zero(const planner::JointLimits& limits) {
  return JointVector::Zero(limits.lower.size()).cwiseMax(limits.lower).cwiseMin(limits.upper);
}

double lowest_base(const std::vector<LoadedArm>& arms) {
  double lowest = arms.front().draft->base[2];
  for (const LoadedArm& arm : arms) lowest = std::min(lowest, arm.draft->base[2]);
  return lowest;
}

/// A box below all bases that the arms cannot reach over.
world::Obstacle floor_below(const std::vector<LoadedArm>& arms) {
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
  floor.name = "floor";
  floor.shapes.push_back(
      {world::Box{0.5 * Eigen::Vector3d(tenths(high.x() - low.x()), tenths(high.y() - low.y()), kFloorThickness)}});
  floor.X_WO.translation() =
      Eigen::Vector3d(std::round(middle.x() * 100.0) / 100.0, std::round(middle.y() * 100.0) / 100.0,
                      lowest_base(arms) - kFloorGap - 0.5 * kFloorThickness);
  return floor;
}

/// Chooses poses of the arms that are clear of themselves, of obstacles, and of other arms in the pose of that name.
class PoseFinder {
 public:
  PoseFinder(const std::vector<LoadedArm>& arms, std::vector<world::Obstacle> obstacles)
      : obstacles_(std::move(obstacles)) {
    std::vector<planner::Arm> models;
    for (const LoadedArm& arm : arms) models.push_back(arm.arm);
    for (std::size_t i = 0; i < arms.size(); ++i) {
      geometries_.emplace_back(models, static_cast<int>(i));
      geometries_.back().set_obstacles(obstacles_);
    }
  }

  /// For each arm its own pose `name` if that is clear, else one that is; empty when an arm has none.
  std::optional<std::vector<JointVector>> find(const std::vector<LoadedArm>& arms, const std::string& name) {
    std::vector<JointVector> poses;
    std::vector<std::vector<config::PosedBody>> placed;
    for (std::size_t i = 0; i < arms.size(); ++i) {
      const auto pose = find_one(arms[i], static_cast<int>(i), name, placed);
      if (!pose) return std::nullopt;
      placed.push_back(bodies(static_cast<int>(i), *pose));
      poses.push_back(*pose);
    }
    return poses;
  }

 private:
  [[nodiscard]] std::vector<config::PosedBody> bodies(int arm, const JointVector& q) const {
    return config::place_arm(obstacles_, geometries_[arm], arm, q);
  }

  [[nodiscard]] bool clear(int arm, const JointVector& q, const std::vector<std::vector<config::PosedBody>>& placed,
                           double of_itself, double of_others) const {
    const planner::CellGeometry& geometry = geometries_[arm];
    const auto own = bodies(arm, q);
    if (config::nearest_self_pair(own, geometry, of_itself).found) return false;
    for (int i = 0; i < static_cast<int>(obstacles_.size()); ++i) {
      const auto obstacle = config::place_obstacle(geometry, obstacles_[i], i);
      if (config::nearest_pair(own, obstacle, of_others, true).found) return false;
    }
    return std::none_of(placed.begin(), placed.end(), [&](const std::vector<config::PosedBody>& other) {
      return config::nearest_pair(own, other, of_others, false).found;
    });
  }

  std::optional<JointVector> find_one(const LoadedArm& loaded, int arm, const std::string& name,
                                      const std::vector<std::vector<config::PosedBody>>& placed) const {
    const planner::Arm& model = loaded.arm;
    if (const auto own = model.named.find(name); own != model.named.end()) {
      if (clear(arm, own->second, placed, 0.0, kOwnPoseClearance)) return own->second;
    }
    const auto home = model.named.find("home");
    const auto usable = [&](const JointVector& q) {
      return name == "home" || home == model.named.end() || (q - home->second).norm() >= kApart;
    };
    std::vector<JointVector> candidates = {nearest_to_zero(model.limits)};
    planner::Random random(static_cast<std::uint64_t>(arm) + (name == "home" ? 1U : 1001U));
    for (int i = 0; i < kPoseSamples; ++i) candidates.push_back(sample(model.limits, random));
    // The nearest to zero first: a posture that a person can imagine.
    std::stable_sort(candidates.begin() + 1, candidates.end(), [&](const JointVector& a, const JointVector& b) {
      return (a - candidates.front()).norm() < (b - candidates.front()).norm();
    });
    for (const double clearance : kWanted) {
      for (const JointVector& q : candidates) {
        // A pair of links that no posture brings far apart must not exclude all of them.
        if (usable(q) && clear(arm, q, placed, 0.25 * clearance, clearance)) return q;
      }
    }
    return std::nullopt;
  }

  std::vector<world::Obstacle> obstacles_;
  std::vector<planner::CellGeometry> geometries_;
};

/// Tool positions in W at random configurations.
std::vector<Eigen::Vector3d> sampled_tools(const planner::Arm& arm) {
  planner::Random random(7);
  planner::Kinematics kinematics;
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < kReachSamples; ++i) {
    planner::forward_kinematics(*arm.model, arm.X_WB, sample(arm.limits, random), kinematics);
    points.push_back(kinematics.X_WT.translation());
  }
  return points;
}

/// True if tools are in each eighth of the cylinder: quadrant, and upper or lower half.
bool covers(const std::vector<Eigen::Vector3d>& tools, const TaskCylinder& cylinder) {
  std::array<int, 8> eighths{};
  for (const Eigen::Vector3d& p_W : tools) {
    const Eigen::Vector3d d = p_W - cylinder.centre_W;
    if (std::hypot(d.x(), d.y()) > cylinder.radius || std::abs(d.z()) > cylinder.half_height) continue;
    ++eighths[(d.x() > 0.0 ? 1U : 0U) + (d.y() > 0.0 ? 2U : 0U) + (d.z() > 0.0 ? 4U : 0U)];
  }
  return std::all_of(eighths.begin(), eighths.end(), [](int count) { return count > 0; });
}

/// The largest cylinder of some between the arms that all of them reach.
std::optional<TaskCylinder> common_cylinder(const std::vector<LoadedArm>& arms) {
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  double reach = 1e9;
  std::vector<std::vector<Eigen::Vector3d>> tools;
  for (const LoadedArm& arm : arms) {
    tools.push_back(sampled_tools(arm.arm));
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3d& p : tools.back()) centre += p / static_cast<double>(tools.back().size());
    double farthest = 0.0;
    for (const Eigen::Vector3d& p : tools.back()) farthest = std::max(farthest, (p - centre).norm());
    middle += centre / static_cast<double>(arms.size());
    reach = std::min(reach, farthest);
  }
  const auto rounded = [](double length) { return std::round(length * 100.0) / 100.0; };
  for (const double radius : {0.4, 0.32, 0.25, 0.18, 0.12}) {
    for (const double height : {0.0, 0.15, -0.15, 0.3, -0.3}) {
      TaskCylinder cylinder{{rounded(middle.x()), rounded(middle.y()), rounded(middle.z() + height * reach)},
                            rounded(radius * reach),
                            rounded(0.4 * radius * reach)};
      if (cylinder.half_height <= 0.0) continue;
      if (cylinder.centre_W.z() - cylinder.half_height < lowest_base(arms) + kAboveFloor) continue;
      const bool all =
          std::all_of(tools.begin(), tools.end(), [&](const auto& of_arm) { return covers(of_arm, cylinder); });
      if (all) return cylinder;
    }
  }
  return std::nullopt;
}

// The text.

std::string numbers_text(const auto& numbers, double precision) {
  std::string text = "[";
  for (Eigen::Index i = 0; i < static_cast<Eigen::Index>(numbers.size()); ++i) {
    text += (i > 0 ? ", " : "") + number_text(std::round(numbers[i] / precision) * precision);
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

std::string arm_text(const LoadedArm& loaded, const fs::path& folder) {
  const DraftArm& draft = *loaded.draft;
  std::ostringstream out;
  out << "  - name: " << draft.name << "\n";
  if (loaded.by_name) {
    out << "    robot: " << draft.robot << "   # `hecaton robots " << draft.robot << "` describes it\n";
  } else {
    out << "    urdf: '" << path_from(draft.robot, folder) << "'\n";
  }
  if (!draft.tool_link.empty()) out << "    tool_link: " << draft.tool_link << "\n";
  out << "    base: " << base_text(draft.base) << "   # of the robot's root link in the world frame [m, rad]\n";
  if (loaded.assumed_velocity) {
    out << "    limits: {velocity: " << number_text(kAssumedVelocity)
        << "}   # the URDF has no velocity limit for some joint: write the real one\n";
  }
  std::string poses;
  for (const auto& [name, q] : loaded.arm.named) {
    if (is_own_pose(loaded, name, q)) continue;
    poses += "      " + name + ": " + numbers_text(q, kPosePrecision) + "\n";
  }
  if (!poses.empty())
    out << "    poses:   # found by sampling: clear of the arm itself, of other arms and of the floor\n" << poses;
  return out.str();
}

std::string tasks_text(const std::optional<TaskCylinder>& cylinder) {
  if (!cylinder) {
    return "# Goals for `hecaton simulate` and `hecaton up --tasks`: all arms go from pose to pose together.\n"
           "# Random goals instead: `tasks: {centre: [x, y, z], radius: r}`, a cylinder that two arms share.\n"
           "tasks:\n  pose_sequence: [home, ready]\n";
  }
  return "# Random goals for `hecaton simulate` and `hecaton up --tasks`: tool positions in a cylinder along z.\n"
         "tasks:\n  centre: " +
         numbers_text(cylinder->centre_W, 1e-9) +
         "   # in the world frame [m]\n  radius: " + number_text(cylinder->radius) +
         "\n  half_height: " + number_text(cylinder->half_height) + "\n";
}

std::string floor_text(const std::optional<world::Obstacle>& floor) {
  if (!floor) {
    return "# Everything that the arms must not touch, such as a table, is an obstacle:\n"
           "# obstacles:\n#   - name: table\n#     shapes: [{type: box, size: [1, 1, 0.04]}]\n"
           "#     pose: {xyz: [0, 0, -0.03]}\n";
  }
  const Eigen::Vector3d size = 2.0 * std::get<world::Box>(floor->shapes.front().shape).half_extents;
  return "# Everything that the arms must not touch, such as a table, is an obstacle.\nobstacles:\n"
         "  - name: floor   # 1 cm below the lowest base\n    shapes: [{type: box, size: " +
         numbers_text(size, 1e-9) +
         "}]\n    pose: {xyz: " + numbers_text(Eigen::Vector3d(floor->X_WO.translation()), 1e-9) + "}\n";
}

std::string cell_name(const std::string& path) {
  const std::string stem = fs::path(path).stem().string();
  return config::is_name(stem) ? stem : "cell";
}

std::string cell_text(const std::vector<LoadedArm>& arms, const std::optional<TaskCylinder>& cylinder,
                      const std::optional<world::Obstacle>& floor, const std::string& path) {
  std::string text =
      "# A cell of Hecaton, written by `hecaton init`. Check it: hecaton check " + path +
      "\n# Lengths are in metres, angles in radians. The reference of the cell file explains every key.\nname: " +
      cell_name(path) + "\n\n" + tasks_text(cylinder) + "\narms:\n";
  for (const LoadedArm& arm : arms) text += arm_text(arm, fs::path(path).parent_path() / ".");
  return text + "\n" + floor_text(floor);
}

bool draws_tasks(const planner::Cell& cell) {
  planner::TaskGenerator generator(cell);
  planner::Random random(1);
  for (int trial = 0; trial < kTrials; ++trial) {
    const auto starts = generator.draw_configuration(random);
    if (!starts || !generator.draw_conflicting_goals(random, *starts)) return false;
  }
  return true;
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
  PoseFinder finder(arms, obstacles);
  for (const char* name : {"home", "ready"}) {
    const auto poses = finder.find(arms, name);
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

}  // namespace

DraftArm parse_draft_arm(const std::string& word) {
  const auto refuse = [&](const std::string& must_be) {
    throw Failure(ExitCode::kBadInput, "'" + config::printable(word) + "' must be " + must_be);
  };
  const std::string form =
      "NAME=ROBOT@\"x y z\" or NAME=ROBOT@\"x y z roll pitch yaw\", with metres and radians; ROBOT:LINK chooses a tool "
      "link";
  const std::size_t equals = word.find('=');
  if (equals == std::string::npos) refuse(form);
  const std::size_t at = word.rfind('@');
  const bool placed = at != std::string::npos && at > equals;
  const std::string robot = word.substr(equals + 1, placed ? at - equals - 1 : std::string::npos);
  const std::size_t colon = robot.rfind(':');
  DraftArm arm;
  arm.name = word.substr(0, equals);
  arm.robot = robot.substr(0, colon);
  if (colon != std::string::npos) arm.tool_link = robot.substr(colon + 1);
  if (!config::is_name(arm.name) || arm.robot.empty()) refuse(form + "; NAME is " + std::string(config::kNameRule));
  if (!placed) return arm;
  const ParsedNumbers parsed = parse_numbers({word.substr(at + 1)}, 0);
  const std::size_t count = parsed.numbers.size();
  if (!parsed.error.empty() || (count != 3 && count != 6)) refuse(form);
  std::copy(parsed.numbers.begin(), parsed.numbers.end(), arm.base.begin());
  const bool near =
      std::all_of(arm.base.begin(), arm.base.end(), [](double x) { return std::abs(x) <= config::kFarthest; });
  if (!near) refuse("a base within ±" + number_text(config::kFarthest) + " m and rad");
  return arm;
}

CellDraft draft_cell(const std::vector<DraftArm>& drafts, const std::string& path) {
  require_distinct_names(drafts);
  std::vector<LoadedArm> arms;
  for (const DraftArm& draft : drafts) arms.push_back(load_arm(draft));
  const bool upright = std::all_of(drafts.begin(), drafts.end(), [](const DraftArm& arm) {
    return std::abs(arm.base[3]) < kTilted && std::abs(arm.base[4]) < kTilted;
  });
  std::optional<world::Obstacle> floor;
  if (upright) floor = floor_below(arms);
  if (!choose_poses(arms, floor)) {
    floor.reset();
    if (!choose_poses(arms, floor)) {
      throw Failure(ExitCode::kBadInput,
                    "the arms have no poses in which they are clear of themselves and of each other: move their bases "
                    "apart, or check each robot alone with 'hecaton check'");
    }
  }
  const auto draft_with = [&](const std::optional<TaskCylinder>& cylinder) {
    CellDraft draft;
    draft.text = cell_text(arms, cylinder, floor, path);
    draft.file = config::parse_cell_file(draft.text, path);
    return draft;
  };
  std::optional<TaskCylinder> cylinder;
  if (arms.size() > 1) cylinder = common_cylinder(arms);
  CellDraft draft = draft_with(cylinder);
  if (cylinder && !draws_tasks(draft.file.cell)) draft = draft_with(std::nullopt);
  draft.findings = config::validate(draft.file);
  return draft;
}

std::string next_steps(const config::CellFile& file, const std::vector<config::Finding>& findings) {
  const bool works = findings.empty() || findings.front().severity != config::Severity::kError;  // errors come first
  if (!works) return "next: change what the errors name, then check again\n";
  const bool has_tasks =
      file.cell.tasks.radius > 0.0 || !file.cell.tasks.pose_sequence.empty() || !file.cell.tasks.problem.areas.empty();
  const std::string goal = "hecaton goal " + file.cell.arms.front().arm.name + " --named home --wait";
  return (has_tasks ? "next: hecaton simulate " + file.path + " --tasks 100\n"
                    : "next: add tasks, or begin with a live cell\n") +
         "then: hecaton up " + file.path + ", and in a second terminal: " + goal + "\n";
}

}  // namespace hecaton::services::cli
