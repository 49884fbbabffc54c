#include "services/config/cell_file.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "planner/cell_defaults.hpp"
#include "planner/methods/strategy/strategy.hpp"
#include "services/config/overlaps.hpp"
#include "services/config/readers.hpp"
#include "services/config/text.hpp"
#include "services/config/yaml_tree.hpp"
#include "services/config/yaml_view.hpp"

namespace hecaton::config {
namespace {

constexpr Bounds kLoopPeriod{0.0005, 1.0, "s"};
constexpr std::array<std::string_view, 2> kConflicting = {"some", "all"};
constexpr std::array<std::string_view, 2> kFrame = {"world", "base"};

void read_clutter(const MapView& map, planner::Clutter& clutter) {
  constexpr Bounds kSize{0.001, kFarthest, "m"};
  clutter.count = map.at("count").integer(1, 64);
  read_number(map, "smallest", kSize, clutter.smallest);
  read_number(map, "largest", kSize, clutter.largest);
  read_number(map, "inner", {0.0, kFarthest, "m"}, clutter.inner);
  read_number(map, "outer", kLength, clutter.outer);
  read_number(map, "lowest", kCoordinate, clutter.lowest);
  read_number(map, "highest", kCoordinate, clutter.highest);
  const auto in_order = [&](const char* low, double least, const char* high, double most) {
    if (least > most) map.fail(high, number_text(most), std::string("at least ") + low + " = " + number_text(least));
  };
  in_order("smallest", clutter.smallest, "largest", clutter.largest);
  in_order("inner", clutter.inner, "outer", clutter.outer);
  in_order("lowest", clutter.lowest, "highest", clutter.highest);
}

/// check_areas() checks the names of arms and poses later.
void read_problem(const MapView& map, const YamlView& areas, planner::MotionProblem& problem) {
  for (const auto& [arm, poses] : areas.named_items(128)) {
    for (const YamlView& pose : poses.items(2, 16, "pose names")) problem.areas[arm].push_back(pose.name());
  }
  if (problem.areas.empty()) areas.fail("a map with the name of one arm at least");
  read_number(map, "spread", {0.0, 3.0, "rad"}, problem.spread);
  read_number(map, "mean_wait", {0.0, 1e6, "steps"}, problem.mean_wait);
}

void leave_out(const MapView& map, std::string_view key, const std::string& why) {
  if (const auto given = map.find(key)) given->fail("left out, because " + why);
}

planner::Timing read_timing(const MapView& root) {
  planner::Timing timing;
  const auto view = root.find("timing");
  if (!view) return timing;
  const MapView map = view->map(section::kTiming);
  read_seconds(map, "control_period", kLoopPeriod, timing.control_period);
  read_seconds(map, "driver_period", kLoopPeriod, timing.driver_period);
  read_seconds(map, "world_period", kLoopPeriod, timing.world_period);
  read_seconds(map, "command_timeout", {0.001, 10.0, "s"}, timing.command_timeout);
  if (timing.driver_period > timing.control_period) {
    map.fail("driver_period", milliseconds_text(timing.driver_period),
             "at most control_period = " + milliseconds_text(timing.control_period));
  }
  // A single late command must not stop the arm.
  if (timing.command_timeout < 2.0 * timing.control_period) {
    map.fail("command_timeout", milliseconds_text(timing.command_timeout),
             "at least twice control_period = " + milliseconds_text(timing.control_period));
  }
  return timing;
}

bool read_real_time(const MapView& root) {
  bool real_time = false;
  if (const auto view = root.find("timing")) read_boolean(view->map(section::kTiming), "real_time", real_time);
  return real_time;
}

/// Fails for keys of the random task area that the key `instead` replaces.
void leave_out_task_area(const MapView& map, const char* instead) {
  for (const char* key : {"frame", "centre", "radius", "half_height", "posture", "conflicting", "clutter"}) {
    leave_out(map, key, std::string("tasks.") + instead + " defines the goals");
  }
}

void read_task_area(const MapView& map, planner::TaskArea& tasks) {
  for (const char* key : {"spread", "mean_wait"}) leave_out(map, key, "it belongs to tasks.areas");
  read_choice(map, "frame", kFrame, tasks.of_each_arm);
  tasks.centre = read_vector(map.at("centre"), kCoordinate, "numbers [x, y, z] in m");
  read_number(map, "radius", kLength, tasks.radius);
  read_number(map, "half_height", {0.0, kFarthest, "m"}, tasks.half_height);
  if (const auto posture = map.find("posture")) tasks.posture = posture->name();
  read_choice(map, "conflicting", kConflicting, tasks.all_conflict);
  if (const auto clutter = map.find("clutter")) read_clutter(clutter->map(section::kClutter), tasks.clutter);
}

/// Without the section the radius is 0: no random goals.
planner::TaskArea read_tasks(const MapView& root) {
  planner::TaskArea tasks;
  const auto view = root.find("tasks");
  if (!view) {
    tasks.radius = 0.0;
    return tasks;
  }
  const MapView map = view->map(section::kTasks);
  if (const auto sequence = map.find("pose_sequence")) {
    leave_out(map, "areas", "tasks.pose_sequence defines the goals");
    leave_out_task_area(map, "pose_sequence");
    for (const YamlView& pose : sequence->items(2, 64, "pose names")) tasks.pose_sequence.push_back(pose.name());
  } else if (const auto areas = map.find("areas")) {
    leave_out_task_area(map, "areas");
    read_problem(map, *areas, tasks.problem);
  } else {
    read_task_area(map, tasks);
  }
  read_seconds(map, "time_limit", {0.0, 3600.0, "s", true}, tasks.time_limit);
  return tasks;
}

std::string read_world_host(const MapView& root, const std::vector<Host>& hosts) {
  if (const auto view = root.find("world")) return read_host(view->map(section::kWorld), "host", hosts);
  if (hosts.size() > 1) static_cast<void>(root.at("world"));
  return hosts.front().name;
}

void require_of_every_arm(const MapView& root, const planner::Cell& cell, const char* key, const std::string& pose) {
  for (const planner::PlannedArm& planned : cell.arms) {
    if (planned.arm.named.contains(pose)) continue;
    root.at("tasks")
        .map(section::kTasks)
        .fail(key, pose, "the name of a pose that every arm has; arm " + planned.arm.name + " has none");
  }
}

// Between overlapping areas a task may have length 0, and a strategy's plane no direction; the area that an arm comes
// from would be ambiguous.
void check_overlap(const MapView& tasks, const planner::PlannedArm& planned, const std::vector<std::string>& poses,
                   double spread) {
  const planner::Arm& arm = planned.arm;
  const int joints = planner::avoiding_joints(planner::parameters_of<planner::StrategyParameters>(planned.methods),
                                              arm.model->joints());
  const int n = std::min(joints, arm.model->joints());
  for (std::size_t k = 0; k < poses.size(); ++k) {
    const std::string& next = poses[(k + 1) % poses.size()];
    const double way = (arm.named.at(poses[k]).head(n) - arm.named.at(next).head(n)).norm();
    if (way > 2.0 * spread) continue;
    tasks.fail("areas." + arm.name, poses[k] + ", " + next,
               "poses more than twice tasks.spread apart in the joints that avoid, " + number_text(2.0 * spread) +
                   " rad, because areas must not overlap; they are " + number_text(way) + " rad apart");
  }
}

// Areas name poses of existing arms, and do not overlap.
void check_areas(const MapView& root, const planner::Cell& cell) {
  for (const auto& [name, poses] : cell.tasks.problem.areas) {
    const MapView tasks = root.at("tasks").map(section::kTasks);
    const auto arm =
        std::find_if(cell.arms.begin(), cell.arms.end(),
                     [&name = name](const planner::PlannedArm& planned) { return planned.arm.name == name; });
    if (arm == cell.arms.end()) tasks.at("areas").fail_with("there is no arm " + name);
    for (const std::string& pose : poses) {
      if (!arm->arm.named.contains(pose)) tasks.fail("areas." + name, pose, "the name of a pose that the arm has");
    }
    check_overlap(tasks, *arm, poses, cell.tasks.problem.spread);
  }
}

void check_task_poses(const MapView& root, const planner::Cell& cell) {
  check_areas(root, cell);
  for (const std::string& pose : cell.tasks.pose_sequence) require_of_every_arm(root, cell, "pose_sequence", pose);
  if (!cell.tasks.posture.empty()) require_of_every_arm(root, cell, "posture", cell.tasks.posture);
}

// Relations between sections.
void check_relations(const MapView& root, const CellFile& file) {
  if (file.network.transport == Transport::kSharedMemory && file.hosts.size() > 1) {
    root.at("network").map(section::kNetwork).at("transport").fail("udp in a cell of several hosts");
  }
  if (file.network.transport == Transport::kSharedMemory && !file.keystore.empty()) {
    root.at("network")
        .map(section::kNetwork)
        .at("transport")
        .fail("udp in a cell with security, because nothing checks what comes through shared memory");
  }
  // The working loop itself sends the heartbeat, at most once per period.
  const std::chrono::duration<double> deadline = file.supervision.heartbeat_deadline;
  const auto require_below = [&](const char* key, double period) {
    if (period < deadline.count()) return;
    root.fail(std::string("timing.") + key, milliseconds_text(period),
              "below supervision.heartbeat_deadline = " + milliseconds_text(deadline.count()));
  };
  require_below("control_period", file.cell.timing.control_period);
  require_below("world_period", file.cell.timing.world_period);
}

/// Names of arms become parts of topics of ROS 2.
void check_ros2_names(const MapView& root, const CellFile& file) {
  if (!file.ros2) return;
  for (std::size_t i = 0; i < file.cell.arms.size(); ++i) {
    const std::string& name = file.cell.arms[i].arm.name;
    if (name == "hecaton") {
      root.fail("arms[" + std::to_string(i) + "].name", name,
                "another name, because the section ros2 has the orders of the whole cell under this one");
    }
    if (name.find("__") != std::string::npos) {
      root.fail("arms[" + std::to_string(i) + "].name", name,
                "a name without two underscores in a row, because the section ros2 makes topics of it");
    }
    const bool digit_first = name.front() >= '0' && name.front() <= '9';
    if (!digit_first && name.find_first_of("-.") == std::string::npos) continue;
    root.fail("arms[" + std::to_string(i) + "].name", name,
              "letters, digits and underscores without a digit in front, because the section ros2 makes topics of it");
  }
}

/// "arm left", "arms left, right"
std::string named(const planner::Cell& cell, const std::vector<int>& arms) {
  std::string names = arms.size() == 1 ? "arm" : "arms";
  for (std::size_t i = 0; i < arms.size(); ++i) names += (i == 0 ? " " : ", ") + cell.arms[arms[i]].arm.name;
  return names;
}

void assume_accelerations(const std::vector<int>& arms, CellFile& file) {
  if (arms.empty()) return;
  file.notes.push_back("limits.acceleration of " + named(file.cell, arms) +
                       " is missing: every joint is assumed to reach its URDF's velocity limit in " +
                       number_text(planner::kAssumedRunUp) + " s");
}

void assume_home_poses(const std::vector<int>& arms, CellFile& file) {
  if (arms.empty()) return;
  planner::choose_home_poses(file.cell, arms);
  std::string poses;
  for (const int arm : arms) {
    std::string numbers;
    for (const double q : file.cell.arms[arm].arm.home()) {
      numbers += (numbers.empty() ? "" : ", ") + number_text(1e-3 * std::round(1e3 * q));
    }
    poses += (poses.empty() ? " [" : "; [") + numbers + "]";
  }
  file.notes.push_back("poses.home of " + named(file.cell, arms) + " is missing: compact postures are chosen," + poses);
}

/// A cell without tasks gets an area that all arms reach.
void assume_tasks(CellFile& file) {
  const auto area = planner::default_task_area(file.cell);
  if (!area) return;
  file.cell.tasks = *area;
  const Eigen::Vector3d& c = area->centre;
  file.notes.push_back("tasks is missing: goals are drawn within reach of all arms, centre [" + number_text(c.x()) +
                       ", " + number_text(c.y()) + ", " + number_text(c.z()) + "] in " +
                       (area->of_each_arm ? "each base frame" : "W") + ", radius " + number_text(area->radius) +
                       " m, half_height " + number_text(area->half_height) + " m");
}

CellFile read_cell(const YamlNode& tree, const YamlSource& source, const planner::MethodRegistry& methods,
                   const std::vector<ShapeType>& shapes) {
  CellFile file;
  file.path = source.path;
  const MapView root = YamlView(tree, source, "").map(section::kRoot);
  file.cell.name = root.at("name").name();
  file.network = read_network(root);
  file.keystore = read_keystore(root);
  file.hosts = read_hosts(root);
  file.world_host = read_world_host(root, file.hosts);
  file.supervision = read_supervision(root, file.hosts);
  file.view = read_view(root, file.hosts);
  file.record = read_record(root, file.hosts);
  file.ros2 = read_ros2(root, file.hosts);
  if (!file.keystore.empty() && file.ros2 && file.ros2->control && file.ros2->enclave.empty()) {
    root.at("ros2")
        .map(section::kRos2)
        .at("control")
        .fail(
            "false in a cell with security, because nodes of ROS 2 need no keys, unless ros2.enclave has keys for "
            "them");
  }
  file.cell.timing = read_timing(root);
  file.real_time = read_real_time(root);
  file.cell.tasks = read_tasks(root);
  check_relations(root, file);
  const OpenValues open = read_arms(root, methods, file);
  check_ros2_names(root, file);
  check_task_poses(root, file.cell);
  file.cell.scene = read_scene(root, file.cell.arms, ShapeSections(shapes));
  leave_out_poses(file.cell, file.notes);
  assume_accelerations(open.acceleration, file);
  assume_home_poses(open.home, file);
  if (!root.find("tasks")) assume_tasks(file);
  check_start(file.cell, source.path);
  file.sources = source.sources;
  return file;
}

}  // namespace

CellFile load_cell_file(const std::string& path, const std::filesystem::path& snapshot,
                        const planner::MethodRegistry& methods, const std::vector<ShapeType>& shapes) {
  planner::SourceFiles sources(snapshot);
  const YamlNode tree = read_yaml_file(path, sources);
  return read_cell(tree, {path, sources}, methods, shapes);
}

CellFile parse_cell_file(const std::string& text, const std::string& path, const planner::MethodRegistry& methods,
                         const std::vector<ShapeType>& shapes) {
  planner::SourceFiles sources;
  return read_cell(read_yaml_text(text, path), {path, sources}, methods, shapes);
}

}  // namespace hecaton::config
