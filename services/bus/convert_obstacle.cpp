#include <cmath>
#include <stdexcept>

#include "services/bus/convert.hpp"
#include "services/bus/validate.hpp"

namespace hecaton::bus {
namespace {

msg::Motion message_of(const world::StaticMotion&) {
  return {};
}

msg::Motion message_of(const world::WaypointMotion& motion) {
  msg::Motion message;
  message.kind(msg::MotionKind::MOTION_WAYPOINTS);
  for (const auto& pose : motion.poses_W) message.poses_W().push_back(to_message(pose));
  message.speed(motion.speed);
  message.loop(motion.loop);
  return message;
}

msg::Motion message_of(const world::CircleMotion& motion) {
  msg::Motion message;
  message.kind(msg::MotionKind::MOTION_CIRCLE);
  message.centre_W(to_message(motion.centre_W));
  message.direction_W(to_message(motion.axis_W));
  message.angular_speed(motion.angular_speed);
  message.turn_with_motion(motion.turn_with_motion);
  return message;
}

msg::Motion message_of(const world::SineMotion& motion) {
  msg::Motion message;
  message.kind(msg::MotionKind::MOTION_SINE);
  message.direction_W(to_message(motion.direction_W));
  message.amplitude(motion.amplitude);
  message.period(motion.period);
  message.phase(motion.phase);
  return message;
}

msg::Motion message_of(const world::ConveyorMotion& motion) {
  msg::Motion message;
  message.kind(msg::MotionKind::MOTION_CONVEYOR);
  message.direction_W(to_message(motion.direction_W));
  message.speed(motion.speed);
  message.length(motion.length);
  return message;
}

msg::Motion message_of(const world::DynamicMotion& motion) {
  msg::Motion message;
  message.kind(msg::MotionKind::MOTION_DYNAMIC);
  message.mass(motion.mass);
  message.friction(motion.friction);
  message.rolling_friction(motion.rolling_friction);
  message.restitution(motion.restitution);
  message.initial_velocity(to_message(motion.initial_velocity));
  return message;
}

/// A unit vector, or the reason why it is none.
Converted<Eigen::Vector3d> direction_from_message(const msg::Vec3& vector, const std::string& what) {
  auto direction = from_message(vector, what);
  constexpr double kTolerance = 1e-6;
  if (direction && !(std::abs(direction->squaredNorm() - 1.0) < kTolerance)) {
    return {{}, what + " must be of unit length"};
  }
  return direction;
}

Converted<world::Motion> waypoints_from_message(const msg::Motion& message, const std::string& what) {
  world::WaypointMotion motion{{}, message.speed(), message.loop()};
  for (std::size_t i = 0; i < message.poses_W().size(); ++i) {
    const auto pose = from_message(message.poses_W()[i], what + ".poses_W[" + std::to_string(i) + "]");
    if (!pose) return {{}, pose.error};
    motion.poses_W.push_back(*pose);
  }
  if (motion.poses_W.size() < 2) return {{}, what + ".poses_W must have at least 2 poses"};
  if (auto error = check_above(what + ".speed", motion.speed, 0); !error.empty()) return {{}, error};
  return {world::Motion{motion}, {}};
}

Converted<world::Motion> circle_from_message(const msg::Motion& message, const std::string& what) {
  const auto centre = from_message(message.centre_W(), what + ".centre_W");
  if (!centre) return {{}, centre.error};
  const auto axis = direction_from_message(message.direction_W(), what + ".direction_W");
  if (!axis) return {{}, axis.error};
  if (!std::isfinite(message.angular_speed())) {
    return {{}, not_finite(what + ".angular_speed", message.angular_speed())};
  }
  return {world::Motion{world::CircleMotion{*centre, *axis, message.angular_speed(), message.turn_with_motion()}}, {}};
}

Converted<world::Motion> sine_from_message(const msg::Motion& message, const std::string& what) {
  const auto direction = direction_from_message(message.direction_W(), what + ".direction_W");
  if (!direction) return {{}, direction.error};
  if (!std::isfinite(message.amplitude())) return {{}, not_finite(what + ".amplitude", message.amplitude())};
  if (!std::isfinite(message.phase())) return {{}, not_finite(what + ".phase", message.phase())};
  if (auto error = check_above(what + ".period", message.period(), 0); !error.empty()) return {{}, error};
  return {world::Motion{world::SineMotion{*direction, message.amplitude(), message.period(), message.phase()}}, {}};
}

Converted<world::Motion> conveyor_from_message(const msg::Motion& message, const std::string& what) {
  const auto direction = direction_from_message(message.direction_W(), what + ".direction_W");
  if (!direction) return {{}, direction.error};
  if (!std::isfinite(message.speed())) return {{}, not_finite(what + ".speed", message.speed())};
  if (auto error = check_above(what + ".length", message.length(), 0); !error.empty()) return {{}, error};
  return {world::Motion{world::ConveyorMotion{*direction, message.speed(), message.length()}}, {}};
}

Converted<world::Motion> dynamic_from_message(const msg::Motion& message, const std::string& what) {
  const auto velocity = from_message(message.initial_velocity(), what + ".initial_velocity");
  if (!velocity) return {{}, velocity.error};
  for (const auto& error :
       {check_above(what + ".mass", message.mass(), 0), check_above(what + ".friction", message.friction(), 0, true),
        check_above(what + ".rolling_friction", message.rolling_friction(), 0, true),
        check_above(what + ".restitution", message.restitution(), 0, true)}) {
    if (!error.empty()) return {{}, error};
  }
  if (message.restitution() > 1) return {{}, what + ".restitution must not be above 1"};
  return {world::Motion{world::DynamicMotion{message.mass(), message.friction(), message.rolling_friction(),
                                             message.restitution(), *velocity}},
          {}};
}

}  // namespace

msg::Motion to_message(const world::Motion& motion) {
  return std::visit([](const auto& kind) { return message_of(kind); }, motion);
}

Converted<world::Motion> from_message(const msg::Motion& motion, const std::string& what) {
  switch (motion.kind()) {
    case msg::MotionKind::MOTION_STATIC:
      return {world::Motion{world::StaticMotion{}}, {}};
    case msg::MotionKind::MOTION_WAYPOINTS:
      return waypoints_from_message(motion, what);
    case msg::MotionKind::MOTION_CIRCLE:
      return circle_from_message(motion, what);
    case msg::MotionKind::MOTION_SINE:
      return sine_from_message(motion, what);
    case msg::MotionKind::MOTION_CONVEYOR:
      return conveyor_from_message(motion, what);
    case msg::MotionKind::MOTION_DYNAMIC:
      return dynamic_from_message(motion, what);
  }
  return {{}, what + ": unknown kind of motion"};
}

msg::Obstacle to_message(const world::Obstacle& obstacle) {
  msg::Obstacle message;
  message.name(obstacle.name);
  for (const auto& shape : obstacle.shapes) message.shapes().push_back(to_message(shape));
  message.X_WO(to_message(obstacle.X_WO));
  message.motion(to_message(obstacle.motion));
  if (obstacle.attachment) {
    message.attached_to(obstacle.attachment->arm);
    message.X_TO(to_message(obstacle.attachment->X_TO));
  }
  return message;
}

Converted<world::Obstacle> from_message(const msg::Obstacle& message) {
  world::Obstacle obstacle;
  obstacle.name = message.name();
  if (obstacle.name.empty()) return {{}, "obstacle: name must not be empty"};
  const std::string what = "obstacle \"" + obstacle.name + "\": ";
  for (std::size_t i = 0; i < message.shapes().size(); ++i) {
    const auto shape = from_message(message.shapes()[i], what + "shapes[" + std::to_string(i) + "]");
    if (!shape) return {{}, shape.error};
    obstacle.shapes.push_back(*shape);
  }
  if (obstacle.shapes.empty()) return {{}, what + "shapes must have at least one"};
  const auto X_WO = from_message(message.X_WO(), what + "X_WO");
  if (!X_WO) return {{}, X_WO.error};
  obstacle.X_WO = *X_WO;
  const auto motion = from_message(message.motion(), what + "motion");
  if (!motion) return {{}, motion.error};
  obstacle.motion = *motion;
  if (!message.attached_to().empty()) {
    const auto X_TO = from_message(message.X_TO(), what + "X_TO");
    if (!X_TO) return {{}, X_TO.error};
    obstacle.attachment = world::Attachment{message.attached_to(), *X_TO};
  }
  return {obstacle, {}};
}

msg::ObstacleStates to_message(const world::ObstacleSnapshot& snapshot, std::span<const world::Obstacle> obstacles) {
  if (snapshot.states.size() != obstacles.size()) {
    throw std::invalid_argument("bus: the snapshot has " + std::to_string(snapshot.states.size()) +
                                " obstacles, the scene " + std::to_string(obstacles.size()));
  }
  msg::ObstacleStates message;
  message.edition(snapshot.edition);
  message.sequence_number(snapshot.sequence);
  message.time(snapshot.time);
  message.states().resize(obstacles.size());
  for (std::size_t i = 0; i < obstacles.size(); ++i) {
    auto& state = message.states()[i];
    state.name(obstacles[i].name);
    state.X_WO(to_message(snapshot.states[i].X_WO));
    state.velocity(to_message(snapshot.states[i].velocity));
  }
  return message;
}

Converted<NamedSnapshot> from_message(const msg::ObstacleStates& message, double age) {
  NamedSnapshot result;
  result.snapshot.edition = message.edition();
  result.snapshot.sequence = message.sequence_number();
  result.snapshot.time = message.time();
  if (!std::isfinite(message.time())) return {{}, not_finite("ObstacleStates: time", message.time())};
  for (const auto& state : message.states()) {
    const std::string what = "ObstacleStates: \"" + state.name() + "\": ";
    const auto pose = from_message(state.X_WO(), what + "X_WO");
    if (!pose) return {{}, pose.error};
    const auto velocity = from_message(state.velocity(), what + "velocity");
    if (!velocity) return {{}, velocity.error};
    result.names.push_back(state.name());
    result.snapshot.states.push_back({*pose, *velocity, age});
  }
  return {result, {}};
}

std::string motion_name(msg::MotionKind kind) {
  switch (kind) {
    case msg::MotionKind::MOTION_STATIC:
      return "static";
    case msg::MotionKind::MOTION_WAYPOINTS:
      return "waypoints";
    case msg::MotionKind::MOTION_CIRCLE:
      return "circle";
    case msg::MotionKind::MOTION_SINE:
      return "sine";
    case msg::MotionKind::MOTION_CONVEYOR:
      return "conveyor";
    case msg::MotionKind::MOTION_DYNAMIC:
      return "dynamic";
  }
  return "unknown";
}

}  // namespace hecaton::bus
