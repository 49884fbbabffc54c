#include "services/client/convert.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string_view>

#include "planner/model/convex_hull.hpp"
#include "services/messages/convert.hpp"

namespace hecaton {

Pose Pose::xyz_rpy(double x, double y, double z, double roll, double pitch, double yaw) {
  const double cr = std::cos(0.5 * roll), sr = std::sin(0.5 * roll);
  const double cp = std::cos(0.5 * pitch), sp = std::sin(0.5 * pitch);
  const double cy = std::cos(0.5 * yaw), sy = std::sin(0.5 * yaw);
  return {{x, y, z},
          {cr * cp * cy + sr * sp * sy, sr * cp * cy - cr * sp * sy, cr * sp * cy + sr * cp * sy,
           cr * cp * sy - sr * sp * cy}};
}

}  // namespace hecaton

namespace hecaton::client {
namespace {

// Public enumerations are generated from idl/ with the same values.
template <class Public, class Message>
Public same(Message value) {
  return static_cast<Public>(value);
}

std::optional<std::string> if_any(const std::string& name) {
  return name.empty() ? std::nullopt : std::optional(name);
}

/// The names in "crate, lid".
std::vector<std::string> names_in(std::string_view listed) {
  constexpr std::string_view kComma = ", ";
  std::vector<std::string> names;
  for (std::size_t begin = 0; begin < listed.size();) {
    const std::size_t end = std::min(listed.find(kComma, begin), listed.size());
    names.emplace_back(listed.substr(begin, end - begin));
    begin = end + kComma.size();
  }
  return names;
}

Vector3 to_public(const msg::Vec3& v) {
  return {v.x(), v.y(), v.z()};
}

/// Sets the direction and returns the length. A vector of length 0 gets an arbitrary direction; the world service
/// rejects it.
double split(const Vector3& v, msg::Motion& motion) {
  const double length = std::hypot(v.x, v.y, v.z);
  motion.direction_W(to_message(length > 0.0 ? Vector3{v.x / length, v.y / length, v.z / length} : Vector3{1.0}));
  return length;
}

ContactReport to_public(const msg::ContactReport& report) {
  ContactReport contacts;
  contacts.contacts = report.contacts();
  const msg::Separation& smallest = report.smallest();
  if (report.has_smallest()) contacts.smallest = {smallest.a(), smallest.b(), smallest.distance()};
  return contacts;
}

struct ShapeToMessage {
  msg::PlacedShape& message;
  void set(msg::ShapeKind kind, const Vector3& dimensions) const {
    message.kind(kind);
    message.dimensions(client::to_message(dimensions));
  }
  void operator()(const Box& box) const { set(msg::ShapeKind::SHAPE_BOX, {0.5 * box.x, 0.5 * box.y, 0.5 * box.z}); }
  void operator()(const Sphere& sphere) const { set(msg::ShapeKind::SHAPE_SPHERE, {sphere.radius}); }
  void operator()(const Cylinder& cylinder) const {
    set(msg::ShapeKind::SHAPE_CYLINDER, {cylinder.radius, 0.5 * cylinder.height});
  }
  void operator()(const Capsule& capsule) const {
    set(msg::ShapeKind::SHAPE_CAPSULE, {capsule.radius, 0.5 * capsule.length});
  }
  void operator()(const ConvexHull& hull) const {
    std::vector<Eigen::Vector3d> points;
    for (const Vector3& point : hull.points) points.emplace_back(point.x, point.y, point.z);
    try {
      message = messages::to_message(world::PlacedShape{planner::convex_shape(points)});
    } catch (const std::invalid_argument& error) {
      throw InvalidArgument(std::string("the points of a convex hull: ") + error.what());
    }
  }
  void operator()(const Points& cloud) const {
    std::vector<Eigen::Vector3f> points;
    points.reserve(cloud.points.size());
    for (const Vector3& p : cloud.points) points.push_back(Eigen::Vector3d(p.x, p.y, p.z).cast<float>());
    try {
      const auto balls = std::make_shared<const world::PointCloud>(std::move(points), cloud.radius);
      message = messages::to_message(world::PlacedShape{world::Points{balls}});
    } catch (const std::invalid_argument& error) {
      throw InvalidArgument(std::string("the points of an obstacle: ") + error.what());
    }
  }
};

struct MotionToMessage {
  msg::Motion& message;
  void operator()(const Static&) const {}
  void operator()(const Conveyor& conveyor) const {
    message.kind(msg::MotionKind::MOTION_CONVEYOR);
    message.speed(split(conveyor.velocity, message));
    message.length(conveyor.length);
  }
  void operator()(const Sine& sine) const {
    message.kind(msg::MotionKind::MOTION_SINE);
    message.amplitude(split(sine.amplitude, message));
    message.period(sine.period.count());
  }
  void operator()(const Circle& circle) const {
    message.kind(msg::MotionKind::MOTION_CIRCLE);
    message.centre_W(client::to_message(circle.centre));
    message.direction_W(client::to_message(Vector3{0.0, 0.0, 1.0}));
    message.angular_speed(circle.angular_speed);
  }
  void operator()(const Dynamic& dynamic) const {
    constexpr double kFriction = 0.5, kRollingFriction = 0.01, kRestitution = 0.1;  // as a cell file's defaults
    message.kind(msg::MotionKind::MOTION_DYNAMIC);
    message.mass(dynamic.mass);
    message.friction(kFriction);
    message.rolling_friction(kRollingFriction);
    message.restitution(kRestitution);
  }
};

}  // namespace

Cause to_public(const msg::Cause& cause) {
  return {same<CauseKind>(cause.kind()), cause.subject(), cause.text()};
}

msg::TimedTrajectory to_message(const Trajectory& trajectory) {
  constexpr std::size_t kMostPoints = 4096;
  constexpr std::size_t kMostValues = 32768;
  const auto& points = trajectory.points;
  if (points.empty() || points.size() > kMostPoints || points.size() * points[0].q.size() > kMostValues) {
    throw InvalidArgument("a trajectory of " + std::to_string(points.size()) + " points must have 1 to " +
                          std::to_string(kMostPoints) + ", and points times joints at most " +
                          std::to_string(kMostValues));
  }
  const TrajectoryPoint& first = points.front();
  msg::TimedTrajectory message;
  // Readers refuse a sample with a greater number, so that its goal would never be answered.
  constexpr double kMost = 1e6;
  constexpr double kMostVelocity = 1e4;
  const auto append = [](std::size_t index, const char* name, const std::vector<double>& values, std::size_t size,
                         double most, std::vector<double>& field) {
    const std::string where = "points[" + std::to_string(index) + "]." + name;
    if (values.size() != size) {
      throw InvalidArgument(where + " has " + std::to_string(values.size()) + " values, but must have " +
                            std::to_string(size));
    }
    for (const double value : values) {
      if (std::abs(value) <= most) continue;
      throw InvalidArgument(where + " = " + std::to_string(value) + " must be at most " + std::to_string(most));
    }
    field.insert(field.end(), values.begin(), values.end());
  };
  if (first.q.size() > msg::MAX_JOINTS) {
    throw InvalidArgument("points[0].q has " + std::to_string(first.q.size()) + " values, but must have at most " +
                          std::to_string(msg::MAX_JOINTS));
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double time = points[i].time.count();
    if (!std::isfinite(time) || time < 0.0 || (i > 0 && time <= points[i - 1].time.count())) {
      throw InvalidArgument("points[" + std::to_string(i) + "].time = " + std::to_string(time) +
                            " s must be 0 or above, and above that of the point before");
    }
    message.time().push_back(time);
    append(i, "q", points[i].q, first.q.size(), kMost, message.q());
    append(i, "qd", points[i].qd, first.qd.empty() ? 0 : first.q.size(), kMostVelocity, message.qd());
    append(i, "qdd", points[i].qdd, first.qdd.empty() ? 0 : first.q.size(), kMost, message.qdd());
  }
  if (!trajectory.path_tolerance.empty()) {
    append(0, "path_tolerance", trajectory.path_tolerance, first.q.size(), kMost, message.path_tolerance());
    for (const double tolerance : trajectory.path_tolerance) {
      if (tolerance < 0.0) throw InvalidArgument("path_tolerance must be 0 (none) or above");
    }
  }
  return message;
}

Progress to_public(const msg::GoalStatus& status, Seconds age) {
  Progress progress;
  progress.age = age;
  progress.arm = status.arm();
  progress.goal = status.goal();
  progress.state = same<GoalState>(status.state());
  progress.cause = to_public(status.cause());
  if (status.has_binding()) {
    progress.binding = {status.binding_own(), status.binding_other(), status.binding_distance()};
  }
  progress.recovery_action = status.recovery_action();
  progress.blocked_duration = Seconds(status.blocked_duration());
  progress.distance = status.distance_to_goal();
  progress.elapsed = Seconds(status.elapsed());
  progress.q_goal = status.q_goal();
  progress.planner = status.node();
  progress.note = status.note();
  if (status.trajectory_time() >= 0.0) progress.trajectory_time = Seconds(status.trajectory_time());
  progress.trajectory_rate = status.trajectory_rate();
  if (status.has_tool() && status.position_error() >= 0.0) {
    progress.tool_error = {status.position_error(), status.orientation_error()};
  }
  if (status.has_nearest()) progress.nearest = {to_public(status.X_WT_nearest()), status.nearest_angle()};
  return progress;
}

Fault to_public(const msg::Fault& fault) {
  return {fault.id(), same<Severity>(fault.severity()), to_public(fault.cause()), fault.cleared()};
}

ToolState to_public(const msg::ToolState& state, Seconds age) {
  ToolState tool;
  tool.has_gripper = state.has_gripper();
  tool.moving = state.moving();
  if (state.width() >= 0.0) tool.width = state.width();
  tool.holding = state.holding();
  for (const msg::Signal& signal : state.signals()) {
    tool.signals.push_back({signal.name(), static_cast<SignalKind>(signal.kind()),
                            signal.known() ? std::optional(signal.value()) : std::nullopt});
  }
  tool.age = age;
  return tool;
}

ArmState to_public(const msg::ArmState& state, Seconds age) {
  ArmState arm;
  arm.mode = same<ArmMode>(state.mode());
  arm.cause = to_public(state.cause());
  arm.q = state.q();
  arm.qd = state.qd();
  arm.carried = names_in(state.carried());
  arm.age = age;
  return arm;
}

Pose to_public(const msg::Pose& pose) {
  return {to_public(pose.position()), {pose.qw(), pose.qx(), pose.qy(), pose.qz()}};
}

CellStatus to_public(const msg::CellStatus& status) {
  CellStatus cell;
  cell.cell = status.cell();
  cell.mode = same<CellMode>(status.mode().mode());
  cell.cause = to_public(status.mode().cause());
  cell.speed = status.mode().speed();
  for (const msg::ArmOrder& order : status.mode().arms()) {
    (order.mode() == msg::Mode::MODE_STOP ? cell.stopped_arms : cell.held_arms).push_back(order.arm());
  }
  cell.supervisor = status.supervisor();
  cell.standby = if_any(status.standby());
  for (const msg::ArmStatus& arm : status.arms()) {
    ArmStatus& entry = cell.arms.emplace_back();
    entry.name = arm.arm();
    entry.mode = same<CellMode>(arm.mode());
    entry.speed = arm.speed();
    entry.driver_alive = arm.driver_alive();
    entry.planner_alive = arm.planner_alive();
    if (arm.state_age() >= 0.0) entry.state = to_public(arm.state(), Seconds(arm.state_age()));
    if (arm.has_goal()) entry.goal = to_public(arm.goal());
    entry.waiting_for = to_public(arm.waiting_for());
  }
  for (const msg::NodeStatus& node : status.nodes()) {
    const msg::Heartbeat& beat = node.heartbeat();
    cell.nodes.push_back({beat.node(), same<NodeKind>(beat.kind()), same<NodeState>(beat.state()), beat.host(),
                          node.alive(), to_public(beat.cause()), Seconds(node.age())});
  }
  for (const msg::Fault& fault : status.faults()) cell.faults.push_back(to_public(fault));
  if (status.has_contact_report()) cell.contacts = to_public(status.contact_report());
  return cell;
}

msg::Vec3 to_message(const Vector3& v) {
  msg::Vec3 message;
  message.x(v.x);
  message.y(v.y);
  message.z(v.z);
  return message;
}

msg::Pose to_message(const Pose& pose) {
  msg::Pose message;
  message.position(to_message(pose.position));
  message.qw(pose.rotation[0]);
  message.qx(pose.rotation[1]);
  message.qy(pose.rotation[2]);
  message.qz(pose.rotation[3]);
  return message;
}

msg::Obstacle to_message(const std::string& name, const Shape& shape, const Pose& pose, const Motion& motion) {
  msg::Obstacle obstacle;
  obstacle.name(name);
  obstacle.X_WO(to_message(pose));
  obstacle.shapes().resize(1);
  std::visit(ShapeToMessage{obstacle.shapes().front()}, shape);
  std::visit(MotionToMessage{obstacle.motion()}, motion);
  return obstacle;
}

}  // namespace hecaton::client
