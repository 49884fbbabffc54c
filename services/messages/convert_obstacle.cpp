#include <cmath>
#include <stdexcept>

#include "services/messages/checks.hpp"
#include "services/messages/convert.hpp"

namespace hecaton::messages {
namespace {

msg::Vec3 dimensions(double x, double y, double z) {
  return to_message(Eigen::Vector3d(x, y, z));
}

void set_hull(msg::PlacedShape& message, const world::ConvexHull& hull) {
  for (const auto& vertex : hull.vertices) message.vertices().push_back(to_message(vertex));
  for (const auto& face : hull.faces) {
    message.face_sizes().push_back(static_cast<std::uint32_t>(face.size()));
    for (const int corner : face) message.face_corners().push_back(static_cast<std::uint32_t>(corner));
  }
}

Converted<world::Shape> hull_from_message(const msg::PlacedShape& message, const std::string& what) {
  auto hull = std::make_shared<world::ConvexHull>();
  for (std::size_t i = 0; i < message.vertices().size(); ++i) {
    const auto vertex = from_message(message.vertices()[i], what + ".vertices[" + std::to_string(i) + "]");
    if (!vertex) return {{}, vertex.error};
    hull->vertices.push_back(*vertex);
  }
  if (hull->vertices.size() < 4) return {{}, what + " is convex and must have at least 4 vertices"};
  std::size_t next = 0;
  for (const auto size : message.face_sizes()) {
    if (size < 3 || size > message.face_corners().size() - next) {
      return {{}, what + ".face_sizes must each be at least 3 and add up to the number of face_corners"};
    }
    std::vector<int> face;
    for (std::size_t i = 0; i < size; ++i) {
      const auto corner = message.face_corners()[next++];
      if (corner >= hull->vertices.size()) {
        return {{},
                what + ".face_corners names vertex " + std::to_string(corner) + " of " +
                    std::to_string(hull->vertices.size())};
      }
      face.push_back(static_cast<int>(corner));
    }
    hull->faces.push_back(std::move(face));
  }
  if (next != message.face_corners().size() || hull->faces.size() < 4) {
    return {{}, what + " is convex and must have at least 4 faces whose sizes add up to the number of face_corners"};
  }
  return {world::Shape{world::Convex{std::move(hull)}}, {}};
}

Converted<world::Shape> cloud_from_message(const msg::PlacedShape& message, const std::string& what) {
  const auto& numbers = message.points();
  if (numbers.size() % 3 != 0) {
    return {{}, what + ".points must have three numbers for each point, not " + std::to_string(numbers.size())};
  }
  std::vector<Eigen::Vector3f> points(numbers.size() / 3);
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    points[i / 3][static_cast<Eigen::Index>(i % 3)] = static_cast<float>(numbers[i]);
  }
  try {
    const auto cloud = std::make_shared<const world::PointCloud>(std::move(points), message.dimensions().x());
    return {world::Shape{world::Points{cloud}}, {}};
  } catch (const std::invalid_argument& error) {
    return {{}, what + ": " + error.what()};
  }
}

std::optional<std::string> first_of(std::initializer_list<std::optional<std::string>> errors) {
  for (const auto& error : errors) {
    if (error) return error;
  }
  return std::nullopt;
}

Converted<world::Shape> shape_from_message(const msg::PlacedShape& message, const std::string& what) {
  const double x = message.dimensions().x();
  const double y = message.dimensions().y();
  const double z = message.dimensions().z();
  const std::string name = what + ".dimensions.";
  std::optional<std::string> error;
  switch (message.kind()) {
    case msg::ShapeKind::SHAPE_BOX:
      error = first_of({check_above(name + "x", x, 0), check_above(name + "y", y, 0), check_above(name + "z", z, 0)});
      if (!error) return {world::Shape{world::Box{{x, y, z}}}, {}};
      break;
    case msg::ShapeKind::SHAPE_SPHERE:
      error = check_above(name + "x", x, 0);
      if (!error) return {world::Shape{world::Sphere{x}}, {}};
      break;
    case msg::ShapeKind::SHAPE_CAPSULE:
      error = first_of({check_above(name + "x", x, 0), check_above(name + "y", y, 0, true)});
      if (!error) return {world::Shape{world::Capsule{x, y}}, {}};
      break;
    case msg::ShapeKind::SHAPE_CYLINDER:
      error = first_of({check_above(name + "x", x, 0), check_above(name + "y", y, 0)});
      if (!error) return {world::Shape{world::Cylinder{x, y}}, {}};
      break;
    case msg::ShapeKind::SHAPE_CONVEX:
      return hull_from_message(message, what);
    case msg::ShapeKind::SHAPE_POINTS:
      return cloud_from_message(message, what);
    default:
      error = what + ": unknown kind of shape";
  }
  return {{}, *error};
}

/// Sets the fields of one kind of motion.
struct MotionWriter {
  msg::Motion& to;

  void operator()(const world::StaticMotion&) const { to.kind(msg::MotionKind::MOTION_STATIC); }
  void operator()(const world::WaypointMotion& motion) const {
    to.kind(msg::MotionKind::MOTION_WAYPOINTS);
    for (const auto& pose : motion.poses_W) to.poses_W().push_back(to_message(pose));
    to.speed(motion.speed);
    to.loop(motion.loop);
  }
  void operator()(const world::CircleMotion& motion) const {
    to.kind(msg::MotionKind::MOTION_CIRCLE);
    to.centre_W(to_message(motion.centre_W));
    to.direction_W(to_message(motion.axis_W));
    to.angular_speed(motion.angular_speed);
    to.turn_with_motion(motion.turn_with_motion);
  }
  void operator()(const world::SineMotion& motion) const {
    to.kind(msg::MotionKind::MOTION_SINE);
    to.direction_W(to_message(motion.direction_W));
    to.amplitude(motion.amplitude);
    to.period(motion.period);
    to.phase(motion.phase);
  }
  void operator()(const world::ConveyorMotion& motion) const {
    to.kind(msg::MotionKind::MOTION_CONVEYOR);
    to.direction_W(to_message(motion.direction_W));
    to.speed(motion.speed);
    to.length(motion.length);
  }
  void operator()(const world::DynamicMotion& motion) const {
    to.kind(msg::MotionKind::MOTION_DYNAMIC);
    to.mass(motion.mass);
    to.friction(motion.friction);
    to.rolling_friction(motion.rolling_friction);
    to.restitution(motion.restitution);
    to.initial_velocity(to_message(motion.initial_velocity));
  }
};

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
  if (auto error = check_above(what + ".speed", motion.speed, 0)) return {{}, *error};
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

/// Far below the shortest period that a cell file or an edit may have. With a period near 0 a phase is infinite [s].
constexpr double kLeastPeriod = 1e-3;

Converted<world::Motion> sine_from_message(const msg::Motion& message, const std::string& what) {
  const auto direction = direction_from_message(message.direction_W(), what + ".direction_W");
  if (!direction) return {{}, direction.error};
  if (!std::isfinite(message.amplitude())) return {{}, not_finite(what + ".amplitude", message.amplitude())};
  if (!std::isfinite(message.phase())) return {{}, not_finite(what + ".phase", message.phase())};
  if (auto error = check_above(what + ".period", message.period(), kLeastPeriod, true)) return {{}, *error};
  return {world::Motion{world::SineMotion{*direction, message.amplitude(), message.period(), message.phase()}}, {}};
}

Converted<world::Motion> conveyor_from_message(const msg::Motion& message, const std::string& what) {
  const auto direction = direction_from_message(message.direction_W(), what + ".direction_W");
  if (!direction) return {{}, direction.error};
  if (!std::isfinite(message.speed())) return {{}, not_finite(what + ".speed", message.speed())};
  if (auto error = check_above(what + ".length", message.length(), 0)) return {{}, *error};
  return {world::Motion{world::ConveyorMotion{*direction, message.speed(), message.length()}}, {}};
}

Converted<world::Motion> dynamic_from_message(const msg::Motion& message, const std::string& what) {
  const auto velocity = from_message(message.initial_velocity(), what + ".initial_velocity");
  if (!velocity) return {{}, velocity.error};
  for (const auto& error :
       {check_above(what + ".mass", message.mass(), 0), check_above(what + ".friction", message.friction(), 0, true),
        check_above(what + ".rolling_friction", message.rolling_friction(), 0, true),
        check_above(what + ".restitution", message.restitution(), 0, true)}) {
    if (error) return {{}, *error};
  }
  if (message.restitution() > 1) return {{}, what + ".restitution must not be above 1"};
  return {world::Motion{world::DynamicMotion{message.mass(), message.friction(), message.rolling_friction(),
                                             message.restitution(), *velocity}},
          {}};
}

}  // namespace

msg::PlacedShape to_message(const world::PlacedShape& shape) {
  msg::PlacedShape message;
  message.X_OS(to_message(shape.X_BS));
  struct Visitor {
    msg::PlacedShape& to;
    void operator()(const world::Box& box) const {
      to.kind(msg::ShapeKind::SHAPE_BOX);
      to.dimensions(to_message(box.half_extents));
    }
    void operator()(const world::Sphere& sphere) const {
      to.kind(msg::ShapeKind::SHAPE_SPHERE);
      to.dimensions(dimensions(sphere.radius, 0, 0));
    }
    void operator()(const world::Capsule& capsule) const {
      to.kind(msg::ShapeKind::SHAPE_CAPSULE);
      to.dimensions(dimensions(capsule.radius, capsule.half_length, 0));
    }
    void operator()(const world::Cylinder& cylinder) const {
      to.kind(msg::ShapeKind::SHAPE_CYLINDER);
      to.dimensions(dimensions(cylinder.radius, cylinder.half_length, 0));
    }
    void operator()(const world::Convex& convex) const {
      to.kind(msg::ShapeKind::SHAPE_CONVEX);
      set_hull(to, *convex.hull);
    }
    void operator()(const world::Points& points) const {
      to.kind(msg::ShapeKind::SHAPE_POINTS);
      to.dimensions(dimensions(points.cloud->radius(), 0, 0));
      to.points().reserve(3 * points.cloud->size());
      for (const Eigen::Vector3f& point : points.cloud->points()) {
        for (int axis = 0; axis < 3; ++axis) to.points().push_back(static_cast<double>(point[axis]));
      }
    }
  };
  std::visit(Visitor{message}, shape.shape);
  return message;
}

Converted<world::PlacedShape> from_message(const msg::PlacedShape& message, const std::string& what) {
  const auto shape = shape_from_message(message, what);
  if (!shape) return {{}, shape.error};
  const auto pose = from_message(message.X_OS(), what + ".X_OS");
  if (!pose) return {{}, pose.error};
  return {world::PlacedShape{*shape, *pose}, {}};
}

msg::Motion to_message(const world::Motion& motion) {
  msg::Motion message;
  std::visit(MotionWriter{message}, motion);
  return message;
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
    throw std::invalid_argument("messages: the snapshot has " + std::to_string(snapshot.states.size()) +
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

}  // namespace hecaton::messages
