#include "services/bus/convert.hpp"

#include <cmath>

#include "services/bus/validate.hpp"

namespace hecaton::bus {

std::vector<double> to_message(const planner::JointVector& q) {
  return {q.data(), q.data() + q.size()};
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

Converted<planner::JointVector> joints_from_message(const std::vector<double>& values, const std::string& what,
                                                    int size) {
  if (values.size() > static_cast<std::size_t>(planner::kMaxJoints)) {
    return {{},
            what + " has " + std::to_string(values.size()) + " joints, more than the " +
                std::to_string(planner::kMaxJoints) + " an arm may have"};
  }
  if (size >= 0 && values.size() != static_cast<std::size_t>(size)) {
    return {{}, what + " has " + std::to_string(values.size()) + " joints, the arm has " + std::to_string(size)};
  }
  planner::JointVector q(static_cast<Eigen::Index>(values.size()));
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!std::isfinite(values[i])) return {{}, not_finite(what + "[" + std::to_string(i) + "]", values[i])};
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

}  // namespace hecaton::bus
