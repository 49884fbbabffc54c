#include "services/config/read_motion.hpp"

#include <array>

#include "services/config/fields.hpp"

namespace hecaton::config {
namespace {

// What the numbers may be, obstacle_rules says.
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

using MotionReader = world::Motion (*)(const MapView&);
constexpr std::array<std::string_view, 6> kTypes = {"static", "waypoints", "circle", "sine", "conveyor", "dynamic"};
constexpr std::array<const Section*, 6> kSections = {&section::kStatic, &section::kWaypoints, &section::kCircle,
                                                     &section::kSine,   &section::kConveyor,  &section::kDynamic};
constexpr std::array<MotionReader, 6> kReaders = {read_static, read_waypoints, read_circle,
                                                  read_sine,   read_conveyor,  read_dynamic};

}  // namespace

world::Motion read_motion(const YamlView& view) {
  const std::size_t type = view.type(kTypes);
  return kReaders[type](view.map(*kSections[type]));
}

}  // namespace hecaton::config
