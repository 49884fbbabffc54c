#include <algorithm>
#include <array>
#include <stdexcept>
#include <vector>

#include "planner/model/mesh_shape.hpp"
#include "services/config/cloud_file.hpp"
#include "services/config/obstacle_rules.hpp"
#include "services/config/readers.hpp"
#include "services/config/shape_types.hpp"
#include "services/config/text.hpp"

namespace hecaton::config {
namespace {

// obstacle_rules checks the numbers of boxes and motions.
world::PlacedShape read_box(const MapView& map) {
  const Eigen::Vector3d size = read_vector(map.at("size"), "numbers [x, y, z] in m");
  return {world::Box{size / 2.0}, read_pose(map, "pose")};
}

world::PlacedShape read_sizes(const MapView& map, const ShapeType& type) {
  std::vector<double> sizes;
  for (const ShapeSize& size : type.sizes) sizes.push_back(map.at(size.key).number(size.bounds()));
  try {
    return {make_shape(type, sizes), read_pose(map, "pose")};
  } catch (const std::invalid_argument& error) {
    map.view().fail_with(error.what());
  }
}

world::PlacedShape read_mesh(const MapView& map) {
  const YamlView file = map.at("file");
  Eigen::Vector3d scale = Eigen::Vector3d::Ones();
  if (const auto view = map.find("scale")) {
    constexpr Bounds kScale{1e-6, 1e6, ""};
    scale = view->is_sequence() ? read_vector(*view, kScale, "factors [x, y, z]")
                                : Eigen::Vector3d::Constant(view->number(kScale));
  }
  const std::string where = file.file() + ": " + file.path();
  try {
    const planner::LinkGeometry geometry =
        planner::mesh_shape(beside(file.file(), file.text()), scale, planner::MeshGeometry::kConvexHull, where,
                            file.sources())
            .geometry;
    return {geometry.shape, read_pose(map, "pose") * geometry.X_LS};
  } catch (const planner::ModelError& error) {
    throw ConfigError(error.what());
  }
}

world::PlacedShape read_points(const MapView& map) {
  const YamlView file = map.at("file");
  const double radius = map.at("radius").number({kThinnest, kFarthest, "m"});
  const std::string path = beside(file.file(), file.text());
  try {
    auto points = read_cloud_file(file.sources().open(path), printable_path(path));
    const auto cloud = std::make_shared<const world::PointCloud>(std::move(points), radius);
    return {world::Points{cloud}, read_pose(map, "pose")};
  } catch (const std::invalid_argument& error) {
    throw ConfigError(file.file() + ": " + file.path() + ": " + error.what());
  }
}

world::PlacedShape read_shape(const YamlView& view, const ShapeSections& shapes) {
  const std::size_t index = view.type(shapes.names());
  const MapView map = view.map(shapes.all()[index]);
  if (const ShapeType* type = shapes.type(index)) return read_sizes(map, *type);
  if (shapes.names()[index] == "points") return read_points(map);
  return index == 0 ? read_box(map) : read_mesh(map);
}

constexpr std::size_t kMostWaypoints = 1000;

world::Motion read_static(const MapView& /*map*/) {
  return world::StaticMotion{};
}

world::Motion read_waypoints(const MapView& map) {
  world::WaypointMotion motion;
  for (const YamlView& pose : map.at("poses").items(2, kMostWaypoints, "poses")) {
    motion.poses_W.push_back(read_pose(pose));
  }
  motion.speed = map.at("speed").number();
  read_boolean(map, "loop", motion.loop);
  return motion;
}

world::Motion read_circle(const MapView& map) {
  world::CircleMotion motion;
  motion.centre_W = read_vector(map.at("centre"), "numbers [x, y, z] in m");
  if (const auto axis = map.find("axis")) motion.axis_W = read_direction(*axis);
  motion.angular_speed = map.at("angular_speed").number();
  read_boolean(map, "turn_with_motion", motion.turn_with_motion);
  return motion;
}

world::Motion read_sine(const MapView& map) {
  world::SineMotion motion;
  motion.direction_W = read_direction(map.at("direction"));
  motion.amplitude = map.at("amplitude").number();
  motion.period = map.at("period").seconds();
  read_number(map, "phase", motion.phase);
  return motion;
}

world::Motion read_conveyor(const MapView& map) {
  world::ConveyorMotion motion;
  motion.direction_W = read_direction(map.at("direction"));
  motion.speed = map.at("speed").number();
  motion.length = map.at("length").number();
  return motion;
}

world::Motion read_dynamic(const MapView& map) {
  world::DynamicMotion motion;
  motion.mass = map.at("mass").number();
  read_number(map, "friction", motion.friction);
  read_number(map, "rolling_friction", motion.rolling_friction);
  read_number(map, "restitution", motion.restitution);
  if (const auto view = map.find("linear_velocity")) {
    motion.initial_velocity.linear = read_vector(*view, "numbers [x, y, z] in m/s");
  }
  if (const auto view = map.find("angular_velocity")) {
    motion.initial_velocity.angular = read_vector(*view, "numbers [x, y, z] in rad/s");
  }
  return motion;
}

constexpr std::array<std::string_view, 6> kMotionNames = {"static", "waypoints", "circle",
                                                          "sine",   "conveyor",  "dynamic"};
/// What the value of `type` selects: the keys of the map, and their reader.
struct MotionType {
  const Section& section;
  world::Motion (*read)(const MapView&);
};
const std::array<MotionType, 6> kMotionTypes = {{{section::kStatic, read_static},
                                                 {section::kWaypoints, read_waypoints},
                                                 {section::kCircle, read_circle},
                                                 {section::kSine, read_sine},
                                                 {section::kConveyor, read_conveyor},
                                                 {section::kDynamic, read_dynamic}}};

world::Motion read_motion(const YamlView& view) {
  const auto& type = kMotionTypes[view.type(kMotionNames)];
  return type.read(view.map(type.section));
}

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

// For waypoints, the motion defines the pose at t = 0: a second definition is an error.
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

world::Obstacle read_obstacle(const YamlView& view, std::span<const planner::PlannedArm> arms,
                              const ShapeSections& shapes) {
  const MapView map = view.map(section::kObstacle);
  world::Obstacle obstacle;
  obstacle.name = map.at("name").name();
  for (const YamlView& shape : map.at("shapes").items(1, kMostShapes, "shapes")) {
    obstacle.shapes.push_back(read_shape(shape, shapes));
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

world::Scene read_scene(const MapView& root, std::span<const planner::PlannedArm> arms, const ShapeSections& shapes) {
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
    world::Obstacle obstacle = read_obstacle(view, arms, shapes);
    if (const auto complaint = complain_about_name(obstacle.name, arm_names, obstacle_names)) {
      view.at_path(complaint->key).fail(complaint->must_be);
    }
    obstacle_names.push_back(obstacle.name);
    scene.obstacles.push_back(std::move(obstacle));
  }
  return scene;
}

}  // namespace hecaton::config
