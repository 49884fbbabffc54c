#include "services/config/read_motion.hpp"

#include <array>
#include <cmath>

#include "services/config/fields.hpp"

namespace hecaton::config {
namespace {

constexpr Bounds kSpeed{0.0, 100.0, "m/s", true};
constexpr Bounds kVelocity{-100.0, 100.0, "m/s"};
constexpr Bounds kAngularVelocity{-100.0, 100.0, "rad/s"};
constexpr Bounds kCoefficient{0.0, 10.0, ""};
constexpr double kSlowestTurn = 1e-6;  // [rad/s]
constexpr std::size_t kMostWaypoints = 1000;

world::Motion read_static(const MapView& /*map*/) {
  return world::StaticMotion{};
}

world::Motion read_waypoints(const MapView& map) {
  world::WaypointMotion motion;
  const YamlView poses = map.at("poses");
  for (const YamlView& pose : poses.items(2, kMostWaypoints, "poses")) motion.poses_W.push_back(read_pose(pose));
  double length = 0.0;
  for (std::size_t i = 1; i < motion.poses_W.size(); ++i) {
    length += (motion.poses_W[i].translation() - motion.poses_W[i - 1].translation()).norm();
  }
  if (length < 1e-6) poses.fail("poses of which at least two differ in position");
  motion.speed = map.at("speed").number(kSpeed);
  read_boolean(map, "loop", motion.loop);
  return motion;
}

world::Motion read_circle(const MapView& map) {
  world::CircleMotion motion;
  motion.centre_W = read_vector(map.at("centre"), kCoordinate, "numbers [x, y, z] in m");
  if (const auto axis = map.find("axis")) motion.axis_W = read_direction(*axis);
  const YamlView speed = map.at("angular_speed");
  motion.angular_speed = speed.number(kAngularVelocity);
  if (std::abs(motion.angular_speed) < kSlowestTurn) speed.fail("other than 0 rad/s (use type: static)");
  read_boolean(map, "turn_with_motion", motion.turn_with_motion);
  return motion;
}

world::Motion read_sine(const MapView& map) {
  world::SineMotion motion;
  motion.direction_W = read_direction(map.at("direction"));
  motion.amplitude = map.at("amplitude").number(kLength);
  motion.period = map.at("period").seconds({0.01, 3600.0, "s"});
  read_number(map, "phase", kAngle, motion.phase);
  return motion;
}

world::Motion read_conveyor(const MapView& map) {
  world::ConveyorMotion motion;
  motion.direction_W = read_direction(map.at("direction"));
  motion.speed = map.at("speed").number(kSpeed);
  motion.length = map.at("length").number(kLength);
  return motion;
}

world::Motion read_dynamic(const MapView& map) {
  world::DynamicMotion motion;
  motion.mass = map.at("mass").number({0.0, 1e5, "kg", true});
  read_number(map, "friction", kCoefficient, motion.friction);
  read_number(map, "rolling_friction", kCoefficient, motion.rolling_friction);
  read_number(map, "restitution", {0.0, 1.0, ""}, motion.restitution);
  if (const auto view = map.find("linear_velocity")) {
    motion.initial_velocity.linear = read_vector(*view, kVelocity, "numbers [x, y, z] in m/s");
  }
  if (const auto view = map.find("angular_velocity")) {
    motion.initial_velocity.angular = read_vector(*view, kAngularVelocity, "numbers [x, y, z] in rad/s");
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
