#include <algorithm>
#include <map>

#include "services/cli/plan.hpp"
#include "services/command_line/options.hpp"
#include "services/command_line/program.hpp"
#include "services/config/cell_file.hpp"
#include "services/config/moveit_files.hpp"
#include "services/config/overlaps.hpp"
#include "services/config/text.hpp"

namespace hecaton::services::cli {
namespace {

[[noreturn]] void refuse(const std::string& option, const std::string& value, const std::string& must_be) {
  throw Failure(ExitCode::kBadInput, option + " = '" + config::printable(value) + "' must be " + must_be);
}

/// A cell with the robot of a URDF alone.
planner::Cell cell_of_robot(const PlanArguments& arguments) {
  const auto model = load_robot(arguments.file, arguments.robot);
  planner::PlannedArm planned;
  planned.arm.name = config::is_name(model->name) ? model->name : "robot";
  planned.arm.model = model;
  planned.arm.limits = model->limits;
  planned.arm.named = model->named;
  planner::Cell cell;
  cell.name = planned.arm.name;
  cell.arms.push_back(std::move(planned));
  return cell;
}

std::vector<int> planned_arms(const planner::Cell& cell, const std::vector<std::string>& names) {
  if (names.empty()) return {0};
  std::vector<int> arms;
  for (const std::string& name : names) {
    const auto found = std::find_if(cell.arms.begin(), cell.arms.end(),
                                    [&](const planner::PlannedArm& planned) { return planned.arm.name == name; });
    if (found == cell.arms.end()) {
      std::vector<std::string_view> known;
      for (const planner::PlannedArm& planned : cell.arms) known.emplace_back(planned.arm.name);
      throw Failure(ExitCode::kBadInput, "--arm = '" + config::printable(name) + "' is no arm of the cell; " +
                                             config::suggestion(name, known));
    }
    const int index = static_cast<int>(found - cell.arms.begin());
    if (std::find(arms.begin(), arms.end(), index) != arms.end()) refuse("--arm", name, "given once");
    arms.push_back(index);
  }
  return arms;
}

void append(std::vector<double>& values, const planner::JointVector& q) {
  values.insert(values.end(), q.begin(), q.end());
}

/// Numbers for all planned arms together, or a named pose that every planned arm has.
std::vector<double> configuration(const std::string& option, const std::string& text, const planner::Cell& cell,
                                  const std::vector<int>& arms) {
  std::vector<double> values;
  std::size_t joints = 0;
  bool named = true;
  for (const int arm : arms) {
    const planner::Arm& planned = cell.arms[arm].arm;
    joints += static_cast<std::size_t>(planned.model->joints());
    named = named && planned.named.contains(text);
    if (named) append(values, planned.named.at(text));
  }
  if (named) return values;
  const ParsedNumbers parsed = parse_numbers({text}, joints);
  if (parsed.error) {
    refuse(option, text, std::to_string(joints) + " numbers, or the name of a pose that every planned arm has");
  }
  for (const double number : parsed.numbers) {
    if (!config::kAngle.allow(number)) refuse(option + "'s value", config::number_text(number), config::kAngle.text());
  }
  return parsed.numbers;
}

/// Arms of one robot have joints of the same names: a request for several of them is ambiguous.
void refuse_shared_joints(const std::string& file, const planner::Cell& cell, const std::vector<int>& arms) {
  std::map<std::string, std::vector<std::string_view>> owners;
  for (const int arm : arms) {
    const planner::Arm& planned = cell.arms[arm].arm;
    for (const std::string& joint : planned.model->joint_names) owners[joint].emplace_back(planned.name);
  }
  for (const auto& [joint, names] : owners) {
    if (names.size() < 2) continue;
    throw Failure(ExitCode::kBadInput, file + ": start_state.joint_state.name: '" + config::printable(joint) +
                                           "' is a joint of each of the planned arms " + config::listed(names) +
                                           "; a request is for one of these arms, use --from and --to for several");
  }
}

/// Checks the group of a request by the SRDF. Without groups a note says that it is not read.
void check_group(const PlanArguments& arguments, const std::string& group, PlanQuery& query) {
  if (group.empty()) return;
  const std::string says = arguments.moveit_request + ": group_name = '" + config::printable(group) + "' ";
  const std::string& srdf = arguments.robot.srdf;
  const std::vector<std::string> groups = srdf.empty() ? std::vector<std::string>() : config::groups_of_srdf(srdf);
  if (groups.empty()) {
    query.notes.push_back(says + "is not read: " +
                          (is_robot(arguments.file) ? "without an SRDF with groups the chain to the tool is planned"
                                                    : "--arm names the planned arms"));
  } else if (std::find(groups.begin(), groups.end(), group) == groups.end()) {
    const std::vector<std::string_view> known(groups.begin(), groups.end());
    throw Failure(ExitCode::kBadInput, says + "must be " + config::alternatives(known) + ", the groups of " + srdf);
  }
}

std::vector<double> by_name(const std::string& file, const std::map<std::string, double>& positions,
                            const planner::Cell& cell, const std::vector<int>& arms) {
  std::vector<double> values;
  for (const int arm : arms) {
    for (const std::string& joint : cell.arms[arm].arm.model->joint_names) {
      const auto found = positions.find(joint);
      if (found == positions.end()) {
        throw Failure(ExitCode::kBadInput, file + ": joint '" + joint + "' is missing");
      }
      values.push_back(found->second);
    }
  }
  return values;
}

std::vector<std::string_view> joints_of(const planner::Cell& cell, const std::vector<int>& arms) {
  std::vector<std::string_view> names;
  for (const int arm : arms) {
    for (const std::string& joint : cell.arms[arm].arm.model->joint_names) names.emplace_back(joint);
  }
  return names;
}

/// A start may name joints that are not planned: a note. A goal must not.
void check_names(const std::string& file, const config::MoveItRequest& request,
                 const std::vector<std::string_view>& planned, PlanQuery& query) {
  std::vector<std::string_view> others;
  for (const auto& [joint, position] : request.start) {
    if (std::find(planned.begin(), planned.end(), joint) == planned.end()) others.emplace_back(joint);
  }
  if (!others.empty()) {
    query.notes.push_back(file + ": start_state: no planned joint is called " + config::alternatives(others) +
                          ": not read");
  }
  for (const auto& [joint, position] : request.goal) {
    if (std::find(planned.begin(), planned.end(), joint) != planned.end()) continue;
    throw Failure(ExitCode::kBadInput, file + ": goal_constraints: joint_name = '" + config::printable(joint) +
                                           "' is no planned joint; " + config::suggestion(joint, planned));
  }
}

/// Moves values that are outside a limit by rounding onto the limit, with a note.
void clamp_rounding(const planner::Cell& cell, const std::vector<int>& arms, const std::string& which,
                    std::vector<double>& values, std::vector<std::string>& notes) {
  std::size_t first = 0;
  for (const int arm : arms) {
    const planner::Arm& planned = cell.arms[arm].arm;
    const auto joints = static_cast<std::size_t>(planned.model->joints());
    if (first + joints > values.size()) return;
    planner::JointVector q =
        Eigen::Map<const Eigen::VectorXd>(values.data() + first, static_cast<Eigen::Index>(joints));
    const std::string note = planner::clamp_rounding(planned, q);
    if (!note.empty()) notes.push_back(which + ": " + note);
    std::copy(q.begin(), q.end(), values.begin() + static_cast<std::ptrdiff_t>(first));
    first += joints;
  }
}

void read_ends(const PlanArguments& arguments, const planner::Cell& cell, const std::vector<int>& arms,
               PlanQuery& query) {
  if (!arguments.moveit_request.empty()) {
    const config::MoveItRequest request = config::read_moveit_request(arguments.moveit_request);
    query.notes.insert(query.notes.end(), request.notes.begin(), request.notes.end());
    check_group(arguments, request.group, query);
    refuse_shared_joints(arguments.moveit_request, cell, arms);
    check_names(arguments.moveit_request, request, joints_of(cell, arms), query);
    query.start = by_name(arguments.moveit_request + ": start_state", request.start, cell, arms);
    query.goal = by_name(arguments.moveit_request + ": goal_constraints", request.goal, cell, arms);
  }
  if (!arguments.from.empty()) query.start = configuration("--from", arguments.from, cell, arms);
  if (!arguments.to.empty()) query.goal = configuration("--to", arguments.to, cell, arms);
  if (query.start.empty()) {
    for (const int arm : arms) {
      const planner::PlannedArm& planned = cell.arms[arm];
      if (planned.start.size() > 0) {
        append(query.start, planned.start);
      } else if (planned.arm.named.contains("home")) {
        append(query.start, planned.arm.home());
      } else {
        throw Failure(ExitCode::kBadInput, "--from or --moveit-request is needed: arm " + planned.arm.name +
                                               " has no start and no pose 'home'");
      }
    }
  }
  query.tool = tool_goal_of(arguments.tool);
  if (query.tool) {
    query.goal.clear();  // that of a request
    (void)only_arm(query, "a goal of the tool");
  } else if (query.goal.empty()) {
    throw Failure(ExitCode::kBadInput, "--to, --pose, --position or --moveit-request is needed for the goal");
  }
  clamp_rounding(cell, arms, "start", query.start, query.notes);
  clamp_rounding(cell, arms, "goal", query.goal, query.notes);
}

/// Names of the scene's objects must differ from those of the cell's obstacles.
void refuse_taken_names(const std::string& file, const config::MoveItScene& scene, const planner::Cell& cell) {
  for (std::size_t i = 0; i < scene.obstacles.size(); ++i) {
    const std::string& name = scene.obstacles[i].name;
    for (const world::Obstacle& obstacle : cell.scene.obstacles) {
      if (obstacle.name != name) continue;
      throw Failure(ExitCode::kBadInput, file + ": world.collision_objects[" + std::to_string(i) + "].id = '" +
                                             config::printable(name) +
                                             "' must be unique, but an obstacle of the cell has the same name");
    }
  }
}

/// Files may use another name for the same robot, so another name is a note only.
void check_robot_name(const std::string& file, const std::string& robot, const planner::Cell& cell, PlanQuery& query) {
  if (robot.empty()) return;
  std::vector<std::string_view> known;
  for (const planner::PlannedArm& planned : cell.arms) {
    const std::string_view name = planned.arm.model->name;
    if (name == robot) return;
    if (std::find(known.begin(), known.end(), name) == known.end()) known.push_back(name);
  }
  query.notes.push_back(file + ": robot_model_name = '" + config::printable(robot) + "' is not " +
                        config::alternatives(known) + ": only the objects of this scene are read");
}

/// Adds the objects of the scene to the cell.
void add_moveit_scene(const PlanArguments& arguments, planner::Cell& cell, PlanQuery& query) {
  // The root of a URDF without a cell is at the origin.
  std::vector<std::string> frames = {"world"};
  if (is_robot(arguments.file)) frames.push_back(cell.arms.front().arm.model->links.front().name);
  const config::MoveItScene scene = config::read_moveit_scene(arguments.moveit_scene, frames);
  refuse_taken_names(arguments.moveit_scene, scene, cell);
  cell.scene.obstacles.insert(cell.scene.obstacles.end(), scene.obstacles.begin(), scene.obstacles.end());
  query.notes = scene.notes;
  check_robot_name(arguments.moveit_scene, scene.robot, cell, query);
}

}  // namespace

PlanQuery make_plan_query(const PlanArguments& arguments) {
  planner::Cell cell =
      is_robot(arguments.file) ? cell_of_robot(arguments) : config::load_cell_file(arguments.file).cell;
  const std::vector<int> arms = planned_arms(cell, arguments.arms);
  PlanQuery query;
  if (!arguments.moveit_scene.empty()) add_moveit_scene(arguments, cell, query);
  query.obstacles = cell.scene.obstacles;
  query.first = cell.arms[arms.front()];
  query.timing = cell.timing;
  query.time_limit = cell.tasks.time_limit;
  std::vector<planner::Arm> all;
  std::vector<planner::JointVector> others;
  for (const planner::PlannedArm& planned : cell.arms) {
    all.push_back(planned.arm);
    others.push_back(planned.start.size() > 0             ? planned.start
                     : planned.arm.named.contains("home") ? planned.arm.home()
                                                          : planner::JointVector());
  }
  for (const int arm : arms) {
    query.planned.emplace_back(all, arm).set_obstacles(query.obstacles);
    others[arm] = planner::JointVector();
  }
  std::vector<world::Pose> X_WO;
  for (world::Obstacle& obstacle : query.obstacles) {
    obstacle.X_WO = config::initial_pose(obstacle);
    X_WO.push_back(obstacle.X_WO);
  }
  query.world = planner::global::world_bodies(query.planned.front(), X_WO, others);
  read_ends(arguments, cell, arms, query);
  return query;
}

planner::ToolGoalAnswer resolve_tool_goal(PlanQuery& query, const planner::ConfigurationCheck& check) {
  const planner::Arm& arm = only_arm(query, "a goal of the tool");
  planner::ToolGoalAnswer answer = planner::resolve_tool_goal(arm, *query.tool, joints_of(query.start), check);
  query.goal.assign(answer.q.begin(), answer.q.end());
  return answer;
}

const planner::Arm& only_arm(const PlanQuery& query, std::string_view option) {
  if (query.planned.size() != 1) {
    throw Failure(ExitCode::kUsage,
                  std::string(option) + " is for one arm, not for " + std::to_string(query.planned.size()));
  }
  return query.planned.front().own_arm();
}

std::vector<world::Obstacle> obstacles_of_only_arm(const PlanQuery& query, const std::string& option) {
  const std::string& name = only_arm(query, option).name;
  std::vector<world::Obstacle> obstacles;
  for (const planner::global::WorldBody& body : query.world) {
    world::Obstacle& obstacle = obstacles.emplace_back();
    obstacle.name = body.name;
    obstacle.shapes.push_back({body.shape});
    obstacle.X_WO = body.X_WS;
  }
  for (const world::Obstacle& obstacle : query.obstacles) {
    if (obstacle.attachment && obstacle.attachment->arm == name) obstacles.push_back(obstacle);
  }
  return obstacles;
}

}  // namespace hecaton::services::cli
