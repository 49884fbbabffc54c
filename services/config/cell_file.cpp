#include "services/config/cell_file.hpp"

#include <algorithm>

#include "planner/methods/strategy/strategy.hpp"
#include "services/config/check_start.hpp"
#include "services/config/read_arm.hpp"
#include "services/config/read_network.hpp"
#include "services/config/read_obstacle.hpp"
#include "services/config/read_timing.hpp"
#include "services/config/text.hpp"
#include "services/config/yaml_tree.hpp"
#include "services/config/yaml_view.hpp"

namespace hecaton::config {
namespace {

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

// Where two areas in a row overlap, a task may have no way, and a strategy's plane no direction; nor would it be clear
// which of them an arm has come from.
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
                   " rad, for their areas must not overlap; it is " + number_text(way));
  }
}

// Areas are poses of arms that there are, and lie apart.
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

// Relations between sections, which no section's reader can check alone.
void check_relations(const MapView& root, const CellFile& file) {
  if (file.network.transport == Transport::kSharedMemory && file.hosts.size() > 1) {
    root.at("network").map(section::kNetwork).at("transport").fail("udp in a cell of several hosts");
  }
  // The heartbeat is written by the working loop itself, so it cannot come more often than the loop runs.
  const std::chrono::duration<double> deadline = file.supervision.heartbeat_deadline;
  const auto require_below = [&](const char* key, double period) {
    if (period < deadline.count()) return;
    root.fail(std::string("timing.") + key, number_text(period * 1e3) + "ms",
              "below supervision.heartbeat_deadline = " + number_text(deadline.count() * 1e3) + "ms");
  };
  require_below("control_period", file.cell.timing.control_period);
  require_below("world_period", file.cell.timing.world_period);
}

CellFile read_cell(const YamlNode& tree, const YamlSource& source, const planner::MethodRegistry& methods) {
  CellFile file;
  file.path = source.path;
  const MapView root = YamlView(tree, source, "").map(section::kRoot);
  file.cell.name = root.at("name").name();
  file.network = read_network(root);
  file.hosts = read_hosts(root);
  file.world_host = read_world_host(root, file.hosts);
  file.supervision = read_supervision(root, file.hosts);
  file.cell.timing = read_timing(root);
  file.real_time = read_real_time(root);
  file.cell.tasks = read_tasks(root);
  check_relations(root, file);
  read_arms(root, methods, file);
  check_task_poses(root, file.cell);
  file.cell.scene = read_scene(root, file.cell.arms);
  check_start(file.cell, source.path);
  file.sources = source.sources;
  return file;
}

}  // namespace

CellFile load_cell_file(const std::string& path, const std::filesystem::path& snapshot,
                        const planner::MethodRegistry& methods) {
  planner::SourceFiles sources(snapshot);
  const YamlNode tree = read_yaml_file(path, sources);
  return read_cell(tree, {path, sources}, methods);
}

CellFile parse_cell_file(const std::string& text, const std::string& path, const planner::MethodRegistry& methods) {
  planner::SourceFiles sources;
  return read_cell(read_yaml_text(text, path), {path, sources}, methods);
}

}  // namespace hecaton::config
