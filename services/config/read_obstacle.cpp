#include "services/config/read_obstacle.hpp"

#include <algorithm>

#include "services/config/fields.hpp"
#include "services/config/obstacle_rules.hpp"
#include "services/config/read_motion.hpp"
#include "services/config/read_shape.hpp"
#include "services/config/text.hpp"

namespace hecaton::config {
namespace {

world::Attachment read_attachment(const YamlView& view, std::span<const planner::PlannedArm> arms) {
  const MapView map = view.map(section::kAttachment);
  const YamlView arm = map.at("arm");
  world::Attachment attachment{arm.name(), read_pose(map, "pose")};
  std::vector<std::string_view> names;
  for (const auto& planned : arms) names.push_back(planned.arm.name);
  if (std::find(names.begin(), names.end(), attachment.arm) == names.end()) {
    arm.fail("an arm of this cell: " + alternatives(names));
  }
  return attachment;
}

// Where a moving obstacle is at t = 0 follows from its motion for some motions; two answers would contradict.
void read_place(const MapView& map, world::Obstacle& obstacle) {
  const auto pose = map.find("pose");
  const auto motion = map.find("motion");
  if (pose) obstacle.X_WO = read_pose(*pose);
  if (motion) obstacle.motion = read_motion(*motion);
  if (const auto* waypoints = std::get_if<world::WaypointMotion>(&obstacle.motion)) {
    if (pose) pose->fail("left out, because the waypoints say where the obstacle starts");
    obstacle.X_WO = waypoints->poses_W.front();
  }
}

world::Obstacle read_obstacle(const YamlView& view, std::span<const planner::PlannedArm> arms) {
  const MapView map = view.map(section::kObstacle);
  world::Obstacle obstacle;
  obstacle.name = map.at("name").name();
  for (const YamlView& shape : map.at("shapes").items(1, kMostShapes, "shapes")) {
    obstacle.shapes.push_back(read_shape(shape));
  }
  read_place(map, obstacle);
  if (const auto attached = map.find("attached_to")) {
    obstacle.attachment = read_attachment(*attached, arms);
    if (const auto pose = map.find("pose")) pose->fail("left out, because attached_to.pose says where the obstacle is");
  }
  if (const auto complaint = complain(obstacle)) view.at_path(complaint->key).fail(complaint->must_be);
  return obstacle;
}

}  // namespace

world::Scene read_scene(const MapView& root, std::span<const planner::PlannedArm> arms) {
  world::Scene scene;
  if (const auto view = root.find("world")) {
    const MapView map = view->map(section::kWorld);
    read_number(map, "floor_z", kCoordinate, scene.floor_z);
    if (const auto gravity = map.find("gravity")) {
      scene.gravity = read_vector(*gravity, {-100.0, 100.0, "m/s²"}, "numbers [x, y, z] in m/s²");
    }
  }
  const auto obstacles = root.find("obstacles");
  if (!obstacles) return scene;
  std::vector<std::string> arm_names;
  for (const auto& planned : arms) arm_names.push_back(planned.arm.name);
  std::vector<std::string> obstacle_names;
  for (const YamlView& view : obstacles->items(0, kMostObstacles, "obstacles")) {
    world::Obstacle obstacle = read_obstacle(view, arms);
    if (const auto complaint = complain_about_name(obstacle.name, arm_names, obstacle_names)) {
      view.at_path(complaint->key).fail(complaint->must_be);
    }
    obstacle_names.push_back(obstacle.name);
    scene.obstacles.push_back(std::move(obstacle));
  }
  return scene;
}

}  // namespace hecaton::config
