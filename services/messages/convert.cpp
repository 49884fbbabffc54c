#include "services/messages/convert.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "services/messages/checks.hpp"

namespace hecaton::messages {
namespace {

/// The tolerance of a ray direction's length: a unit vector within rounding.
constexpr double kUnitTolerance = 1e-3;
/// Bounds the work of a planner in one period.
constexpr std::size_t kMostRays = 4096;

}  // namespace

std::vector<double> to_message(const planner::JointVector& q) {
  return {q.data(), q.data() + q.size()};
}

void to_message(const planner::JointVector& q, std::vector<double>& field) {
  field.assign(q.data(), q.data() + q.size());
}

msg::Vec3 to_message(const Eigen::Vector3d& vector) {
  msg::Vec3 message;
  message.x(vector.x());
  message.y(vector.y());
  message.z(vector.z());
  return message;
}

msg::Pose to_message(const world::Pose& pose) {
  const Eigen::Quaterniond rotation = Eigen::Quaterniond(pose.rotation()).normalized();
  msg::Pose message;
  message.position(to_message(Eigen::Vector3d(pose.translation())));
  message.qw(rotation.w());
  message.qx(rotation.x());
  message.qy(rotation.y());
  message.qz(rotation.z());
  return message;
}

msg::Twist to_message(const world::Twist& twist) {
  msg::Twist message;
  message.linear(to_message(twist.linear));
  message.angular(to_message(twist.angular));
  return message;
}

msg::Separation to_message(const world::Separation& separation) {
  msg::Separation message;
  message.distance(separation.distance);
  message.kind(static_cast<msg::ContactKind>(separation.kind));
  message.a(separation.a);
  message.b(separation.b);
  message.time(separation.time);
  return message;
}

static_assert(static_cast<msg::ContactKind>(world::ContactKind::kArmArm) == msg::ContactKind::CONTACT_ARM_ARM);
static_assert(static_cast<msg::ContactKind>(world::ContactKind::kArmObstacle) ==
              msg::ContactKind::CONTACT_ARM_OBSTACLE);
static_assert(static_cast<msg::ContactKind>(world::ContactKind::kArmSelf) == msg::ContactKind::CONTACT_ARM_SELF);
static_assert(planner::kMaxJoints == msg::MAX_JOINTS);

Converted<planner::JointVector> joints_from_message(std::span<const double> values, const ValueName& what, int size) {
  if (values.size() > static_cast<std::size_t>(planner::kMaxJoints)) {
    return {{},
            what.text() + " has " + std::to_string(values.size()) + " joints, more than the " +
                std::to_string(planner::kMaxJoints) + " an arm may have"};
  }
  if (size >= 0 && values.size() != static_cast<std::size_t>(size)) {
    return {{}, what.text() + " has " + std::to_string(values.size()) + " joints, the arm has " + std::to_string(size)};
  }
  planner::JointVector q(static_cast<Eigen::Index>(values.size()));
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!std::isfinite(values[i])) return {{}, not_finite(what.text() + "[" + std::to_string(i) + "]", values[i])};
    q[static_cast<Eigen::Index>(i)] = values[i];
  }
  return {q, {}};
}

Converted<Eigen::Vector3d> from_message(const msg::Vec3& vector, const std::string& what) {
  const Eigen::Vector3d value(vector.x(), vector.y(), vector.z());
  if (!value.allFinite()) return {{}, what + " must be finite"};
  return {value, {}};
}

Converted<world::Pose> from_message(const msg::Pose& pose, const std::string& what) {
  const auto position = from_message(pose.position(), what + ": position");
  if (!position) return {{}, position.error};
  Eigen::Quaterniond rotation(pose.qw(), pose.qx(), pose.qy(), pose.qz());
  constexpr double kTolerance = 1e-6;
  if (!(std::abs(rotation.squaredNorm() - 1.0) < kTolerance)) {
    return {{}, what + ": quaternion must be of unit length, its square is " + std::to_string(rotation.squaredNorm())};
  }
  world::Pose value = world::Pose::Identity();
  value.translation() = *position;
  value.linear() = rotation.normalized().toRotationMatrix();
  return {value, {}};
}

msg::ToolGoal to_message(const planner::ToolGoal& goal) {
  msg::ToolGoal message;
  message.X_WT(to_message(goal.X_WT));
  message.free_rotation(static_cast<msg::FreeRotation>(goal.free_rotation));
  message.position_tolerance(goal.position_tolerance);
  message.orientation_tolerance(goal.orientation_tolerance);
  return message;
}

Converted<planner::ToolGoal> from_message(const msg::ToolGoal& goal, const std::string& what) {
  const auto X_WT = from_message(goal.X_WT(), what + ": X_WT");
  if (!X_WT) return {{}, X_WT.error};
  planner::ToolGoal value{.X_WT = *X_WT};
  const auto free_rotation = static_cast<std::uint32_t>(goal.free_rotation());
  if (free_rotation > static_cast<std::uint32_t>(msg::FreeRotation::FREE_ALL)) {
    return {{}, what + ": free_rotation = " + std::to_string(free_rotation) + " is unknown"};
  }
  value.free_rotation = static_cast<planner::FreeRotation>(free_rotation);
  const auto read = [&](const char* name, double given, double least, double most,
                        double& tolerance) -> std::optional<std::string> {
    if (given != 0.0) tolerance = given;
    if (tolerance >= least && tolerance <= most) return std::nullopt;
    return what + ": " + name + " = " + std::to_string(given) + " must be 0 (default) or from " +
           std::to_string(least) + " to " + std::to_string(most);
  };
  auto error = read("position_tolerance", goal.position_tolerance(), planner::kLeastPositionTolerance,
                    planner::kMostPositionTolerance, value.position_tolerance);
  if (error) return {{}, *error};
  error = read("orientation_tolerance", goal.orientation_tolerance(), planner::kLeastOrientationTolerance,
               planner::kMostOrientationTolerance, value.orientation_tolerance);
  if (error) return {{}, *error};
  return {value, {}};
}

msg::TimedTrajectory to_message(const planner::TimedTrajectory& trajectory) {
  msg::TimedTrajectory message;
  const auto append = [](const planner::JointVector& values, std::vector<double>& field) {
    field.insert(field.end(), values.begin(), values.end());
  };
  const auto& points = trajectory.points;
  const auto all_have = [&](auto member) {
    return std::all_of(points.begin(), points.end(), [&](const auto& point) { return (point.*member).size() > 0; });
  };
  const bool qd = all_have(&planner::TimedPoint::qd);
  const bool qdd = qd && all_have(&planner::TimedPoint::qdd);
  for (const planner::TimedPoint& point : points) {
    message.time().push_back(point.time);
    append(point.q, message.q());
    if (qd) append(point.qd, message.qd());
    if (qdd) append(point.qdd, message.qdd());
  }
  for (const double tolerance : trajectory.path_tolerance) {
    message.path_tolerance().push_back(std::isfinite(tolerance) ? tolerance : 0.0);
  }
  return message;
}

Converted<planner::TimedTrajectory> from_message(const msg::TimedTrajectory& trajectory, const std::string& what,
                                                 int joints) {
  const std::size_t points = trajectory.time().size();
  const auto size = static_cast<std::size_t>(joints);
  const auto wrong = [&](const char* field, std::size_t has, const std::string& must) {
    return Converted<planner::TimedTrajectory>{
        {}, what + "." + field + " has " + std::to_string(has) + " values, but must have " + must};
  };
  if (points == 0 || points > planner::TimedTrajectory::kMostPoints) {
    return wrong("time", points, "1 to " + std::to_string(planner::TimedTrajectory::kMostPoints));
  }
  const std::string each = std::to_string(points * size);
  if (trajectory.q().size() != points * size) return wrong("q", trajectory.q().size(), each);
  const auto optional = [&](const std::vector<double>& field) {
    return field.empty() || field.size() == points * size;
  };
  if (!optional(trajectory.qd())) return wrong("qd", trajectory.qd().size(), "0 or " + each);
  if (!optional(trajectory.qdd())) return wrong("qdd", trajectory.qdd().size(), "0 or " + each);
  const std::vector<double>& tolerance = trajectory.path_tolerance();
  if (!tolerance.empty() && tolerance.size() != size) {
    return wrong("path_tolerance", tolerance.size(), "0 or " + std::to_string(size));
  }
  planner::TimedTrajectory value;
  const auto part = [&](const std::vector<double>& field, std::size_t point) -> planner::JointVector {
    if (field.empty()) return {};
    return Eigen::Map<const Eigen::VectorXd>(&field[point * size], joints);
  };
  for (std::size_t i = 0; i < points; ++i) {
    value.points.push_back(
        {trajectory.time()[i], part(trajectory.q(), i), part(trajectory.qd(), i), part(trajectory.qdd(), i)});
  }
  value.path_tolerance.resize(static_cast<Eigen::Index>(tolerance.size()));
  for (std::size_t j = 0; j < tolerance.size(); ++j) {
    if (!std::isfinite(tolerance[j]) || tolerance[j] < 0.0) {
      return {{},
              what + ".path_tolerance[" + std::to_string(j) + "] = " + std::to_string(tolerance[j]) +
                  " must be 0 (none) or above"};
    }
    value.path_tolerance[static_cast<Eigen::Index>(j)] =
        tolerance[j] > 0.0 ? tolerance[j] : std::numeric_limits<double>::infinity();
  }
  return {std::move(value), {}};
}

Converted<world::Twist> from_message(const msg::Twist& twist, const std::string& what) {
  const auto linear = from_message(twist.linear(), what + ": linear");
  if (!linear) return {{}, linear.error};
  const auto angular = from_message(twist.angular(), what + ": angular");
  if (!angular) return {{}, angular.error};
  return {world::Twist{*linear, *angular}, {}};
}

Converted<world::Separation> from_message(const msg::Separation& separation, const std::string& what) {
  // The enumeration is signed in Fast DDS 3.
  constexpr auto kLast = static_cast<std::uint32_t>(msg::ContactKind::CONTACT_ARM_SELF);
  if (static_cast<std::uint32_t>(separation.kind()) > kLast) return {{}, what + ": unknown kind of contact"};
  if (!std::isfinite(separation.distance())) return {{}, not_finite(what + ": distance", separation.distance())};
  if (!std::isfinite(separation.time())) return {{}, not_finite(what + ": time", separation.time())};
  return {world::Separation{separation.distance(), static_cast<world::ContactKind>(separation.kind()), separation.a(),
                            separation.b(), separation.time()},
          {}};
}

msg::RangeScan to_message(const planner::RangeScan& scan, const planner::RangeSensor& sensor) {
  msg::RangeScan message;
  message.max_range(sensor.range);
  message.rays().resize(scan.readings.size());
  for (std::size_t i = 0; i < scan.readings.size(); ++i) {
    msg::RangeRay& ray = message.rays()[i];
    ray.origin_L(to_message(scan.readings[i].ray.origin_L));
    ray.direction_L(to_message(scan.readings[i].ray.direction_L));
    ray.distance(scan.readings[i].distance);
    ray.hit(scan.readings[i].hit);
  }
  return message;
}

Converted<std::vector<planner::RangeReading>> from_message(const msg::RangeScan& message) {
  const std::string what = "RangeScan \"" + message.sensor() + "\": ";
  if (message.rays().size() > kMostRays) {
    return {{},
            what + std::to_string(message.rays().size()) + " rays must be " + std::to_string(kMostRays) + " at most"};
  }
  std::vector<planner::RangeReading> readings;
  for (const msg::RangeRay& ray : message.rays()) {
    const auto origin = from_message(ray.origin_L(), what + "origin_L");
    if (!origin) return {{}, origin.error};
    const auto direction = from_message(ray.direction_L(), what + "direction_L");
    if (!direction) return {{}, direction.error};
    if (std::abs(direction->norm() - 1.0) > kUnitTolerance) return {{}, what + "direction_L must be a unit vector"};
    if (auto error = check_above(what + "distance", ray.distance(), 0.0, true)) return {{}, *error};
    readings.push_back({{*origin, direction->normalized()}, ray.distance(), ray.hit()});
  }
  return {std::move(readings), {}};
}

}  // namespace hecaton::messages
