#include "services/config/moveit_files.hpp"

#include <array>

#include "services/config/fields.hpp"
#include "services/config/yaml_tree.hpp"
#include "services/config/yaml_view.hpp"

namespace hecaton::config {
namespace {

constexpr std::size_t kMost = 10'000;
constexpr std::array<std::string_view, 3> kPrimitives = {"box", "sphere", "cylinder"};

YamlView required(const YamlView& map, std::string_view key) {
  const auto found = map.entry(key);
  if (!found) map.fail_with("has no key '" + std::string(key) + "'");
  return *found;
}

bool is_given(const YamlView& map, std::string_view key) {
  const auto found = map.entry(key);
  return found && found->is_sequence() && !found->items(0, kMost, "items").empty();
}

std::vector<double> numbers(const YamlView& view, std::size_t count, const Bounds& bounds, std::string_view of) {
  std::vector<double> result;
  for (const YamlView& item : view.items(count, count, of)) result.push_back(item.number(bounds));
  return result;
}

world::Pose pose(const YamlView& view) {
  const auto p = numbers(required(view, "position"), 3, kCoordinate, "numbers [x, y, z] in m");
  const YamlView orientation = required(view, "orientation");
  const auto q = numbers(orientation, 4, {-2.0, 2.0, ""}, "numbers [x, y, z, w]");
  Eigen::Quaterniond turn(q[3], q[0], q[1], q[2]);
  if (turn.norm() < 1e-3) orientation.fail("a quaternion that is not zero");
  world::Pose result = world::Pose::Identity();
  result.translation() = Eigen::Vector3d(p[0], p[1], p[2]);
  result.linear() = turn.normalized().toRotationMatrix();
  return result;
}

world::Shape primitive(const YamlView& view) {
  const YamlView dimensions = required(view, "dimensions");
  const auto values = [&](std::size_t count, std::string_view of) { return numbers(dimensions, count, kLength, of); };
  switch (required(view, "type").choice(kPrimitives)) {
    case 0: {
      const auto size = values(3, "numbers [x, y, z] in m");
      return world::Box{0.5 * Eigen::Vector3d(size[0], size[1], size[2])};
    }
    case 1:
      return world::Sphere{values(1, "numbers [radius] in m")[0]};
    default: {
      const auto size = values(2, "numbers [height, radius] in m");
      return world::Cylinder{size[1], 0.5 * size[0]};
    }
  }
}

world::Obstacle collision_object(const YamlView& view) {
  for (const char* key : {"meshes", "planes"}) {
    if (is_given(view, key)) view.fail_with(std::string("has ") + key + ", which are not read; give primitives");
  }
  world::Obstacle obstacle;
  obstacle.name = required(view, "id").text();
  if (const auto own = view.entry("pose")) obstacle.X_WO = pose(*own);
  const YamlView poses = required(view, "primitive_poses");
  const auto shapes = required(view, "primitives").items(1, kMost, "primitives");
  const auto places = poses.items(shapes.size(), shapes.size(), "poses, one for each primitive");
  for (std::size_t i = 0; i < shapes.size(); ++i) obstacle.shapes.push_back({primitive(shapes[i]), pose(places[i])});
  return obstacle;
}

}  // namespace

std::vector<world::Obstacle> read_moveit_scene(const std::string& path) {
  const YamlNode tree = read_yaml_file(path);
  const YamlView root(tree, path, "");
  if (const auto state = root.entry("robot_state"); state && is_given(*state, "attached_collision_objects")) {
    state->fail_with("has attached_collision_objects, which are not read");
  }
  std::vector<world::Obstacle> obstacles;
  for (const YamlView& item : required(required(root, "world"), "collision_objects").items(0, kMost, "objects")) {
    obstacles.push_back(collision_object(item));
  }
  return obstacles;
}

MoveItRequest read_moveit_request(const std::string& path) {
  const YamlNode tree = read_yaml_file(path);
  const YamlView root(tree, path, "");
  MoveItRequest request;
  const YamlView state = required(required(root, "start_state"), "joint_state");
  const auto names = required(state, "name").items(1, kMost, "joint names");
  const YamlView positions = required(state, "position");
  const auto values = positions.items(names.size(), names.size(), "numbers, one for each name");
  for (std::size_t i = 0; i < names.size(); ++i) request.start[names[i].text()] = values[i].number(kAngle);
  const auto goals = required(root, "goal_constraints").items(1, kMost, "constraints");
  for (const YamlView& item : required(goals.front(), "joint_constraints").items(1, kMost, "joint constraints")) {
    request.goal[required(item, "joint_name").text()] = required(item, "position").number(kAngle);
  }
  return request;
}

}  // namespace hecaton::config
