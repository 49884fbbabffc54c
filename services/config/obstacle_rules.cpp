#include "services/config/obstacle_rules.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <variant>

#include "planner/collision/exact_distance.hpp"
#include "services/config/shape_types.hpp"
#include "services/config/text.hpp"
#include "world/model/scene_checks.hpp"

namespace hecaton::config {
namespace {

using Answer = std::optional<Complaint>;

constexpr Bounds kExtent{kThinnest, kFarthest, "m"};
constexpr Bounds kOptionalLength{0.0, kFarthest, "m"};
constexpr Bounds kSpeed{0.0, 100.0, "m/s", true};
constexpr Bounds kVelocity{-100.0, 100.0, "m/s"};
constexpr Bounds kAngularVelocity{-100.0, 100.0, "rad/s"};
constexpr Bounds kPeriod{0.01, 3600.0, "s"};
constexpr Bounds kMass{0.0, 1e5, "kg", true};
constexpr Bounds kCoefficient{0.0, 10.0, ""};
constexpr Bounds kFraction{0.0, 1.0, ""};
constexpr double kSlowestTurn = 1e-6;    // [rad/s]
constexpr double kSamePlace = 1e-6;      // [m]
constexpr double kUnitTolerance = 1e-6;  // of a direction's length

Answer unless(const Bounds& bounds, const std::string& key, double value) {
  if (bounds.allow(value)) return std::nullopt;
  std::string text = number_text(value);
  if (!bounds.unit.empty()) text.append(" ").append(bounds.unit);
  return Complaint{key, text, std::isfinite(value) ? bounds.text() : "a finite number, " + bounds.text()};
}

std::string indexed(const std::string& key, std::size_t index) {
  return key + "[" + std::to_string(index) + "]";
}

Answer unless(const Bounds& bounds, const std::string& key, const Eigen::Vector3d& vector) {
  for (int axis = 0; axis < 3; ++axis) {
    if (auto answer = unless(bounds, indexed(key, static_cast<std::size_t>(axis)), vector[axis])) return answer;
  }
  return std::nullopt;
}

Answer first_of(std::initializer_list<Answer> answers) {
  const auto found = std::find_if(answers.begin(), answers.end(), [](const Answer& answer) { return !!answer; });
  return found == answers.end() ? std::nullopt : *found;
}

std::string vector_text(const Eigen::Vector3d& v) {
  return "[" + number_text(v.x()) + ", " + number_text(v.y()) + ", " + number_text(v.z()) + "]";
}

Answer unless_unit(const std::string& key, const Eigen::Vector3d& v) {
  if (std::abs(v.norm() - 1.0) <= kUnitTolerance) return std::nullopt;
  return Complaint{key, vector_text(v), "a direction, of length 1"};
}

struct ShapeRules {
  std::string key;

  Answer operator()(const world::Box& box) const { return unless(kExtent, key + ".size", 2.0 * box.half_extents); }
  Answer operator()(const world::Sphere& sphere) const { return unless(kExtent, key + ".radius", sphere.radius); }
  Answer operator()(const world::Capsule& capsule) const {
    return first_of({unless(kExtent, key + ".radius", capsule.radius),
                     unless(kOptionalLength, key + ".length", 2.0 * capsule.half_length)});
  }
  Answer operator()(const world::Cylinder& cylinder) const {
    return first_of({unless(kExtent, key + ".radius", cylinder.radius),
                     unless(kExtent, key + ".height", 2.0 * cylinder.half_length)});
  }
  Answer operator()(const world::Convex& convex) const {
    if (const auto reason = world::why_invalid(world::Shape{convex})) {
      return Complaint{key, "a convex hull", "one that encloses a volume, but " + *reason};
    }
    for (const Eigen::Vector3d& vertex : convex.hull->vertices) {
      if (auto answer = unless(kCoordinate, key + ".vertices", vertex)) return answer;
    }
    return std::nullopt;
  }
  Answer operator()(const world::Points& points) const {
    if (auto answer = unless(kExtent, key + ".radius", points.cloud->radius())) return answer;
    const world::PointBox& box = points.cloud->box();
    for (int axis = 0; axis < 3; ++axis) {
      for (const float side : {box.low[axis], box.high[axis]}) {
        if (auto answer = unless(kCoordinate, key + ".points", static_cast<double>(side))) {
          answer->must_be = "points with coordinates " + answer->must_be + "; one has " + answer->value;
          return answer;
        }
      }
    }
    return std::nullopt;
  }
};

struct MotionRules {
  const world::Obstacle& obstacle;

  Answer operator()(const world::StaticMotion&) const { return std::nullopt; }
  Answer operator()(const world::WaypointMotion& motion) const {
    const std::string count = std::to_string(motion.poses_W.size()) + " poses";
    double length = 0.0;
    for (std::size_t i = 0; i < motion.poses_W.size(); ++i) {
      if (auto answer = complain(motion.poses_W[i], indexed("motion.poses", i))) return answer;
      if (i > 0) length += (motion.poses_W[i].translation() - motion.poses_W[i - 1].translation()).norm();
    }
    if (motion.poses_W.size() < 2) return Complaint{"motion.poses", count, "at least 2"};
    if (length < kSamePlace) {
      return Complaint{"motion.poses", count + " in one place", "poses of which at least two differ in position"};
    }
    if (auto answer = unless(kSpeed, "motion.speed", motion.speed)) return answer;
    // The remaining error is a rotation in place, which world::why_invalid() describes.
    world::Obstacle moved;
    moved.name = obstacle.name;
    moved.shapes = obstacle.shapes;
    moved.motion = motion;
    const auto reason = world::why_invalid(moved);
    return reason ? Answer(Complaint{"motion.poses", count, "possible to follow, but " + *reason}) : std::nullopt;
  }
  Answer operator()(const world::CircleMotion& motion) const {
    if (auto answer =
            first_of({unless(kCoordinate, "motion.centre", motion.centre_W), unless_unit("motion.axis", motion.axis_W),
                      unless(kAngularVelocity, "motion.angular_speed", motion.angular_speed)})) {
      return answer;
    }
    if (std::abs(motion.angular_speed) < kSlowestTurn) {
      return Complaint{"motion.angular_speed", number_text(motion.angular_speed) + " rad/s",
                       "other than 0 rad/s (use type: static)"};
    }
    const Eigen::Vector3d arm = obstacle.X_WO.translation() - motion.centre_W;
    const double radius = (arm - arm.dot(motion.axis_W) * motion.axis_W).norm();
    if (radius >= kSamePlace || motion.turn_with_motion) return std::nullopt;
    return Complaint{"motion.centre", vector_text(motion.centre_W),
                     "off the line along the axis through the obstacle's own position, or turn_with_motion be true"};
  }
  Answer operator()(const world::SineMotion& motion) const {
    return first_of({unless_unit("motion.direction", motion.direction_W),
                     unless(kLength, "motion.amplitude", motion.amplitude),
                     unless(kPeriod, "motion.period", motion.period), unless(kAngle, "motion.phase", motion.phase)});
  }
  Answer operator()(const world::ConveyorMotion& motion) const {
    return first_of({unless_unit("motion.direction", motion.direction_W), unless(kSpeed, "motion.speed", motion.speed),
                     unless(kLength, "motion.length", motion.length)});
  }
  Answer operator()(const world::DynamicMotion& motion) const {
    return first_of({unless(kMass, "motion.mass", motion.mass),
                     unless(kCoefficient, "motion.friction", motion.friction),
                     unless(kCoefficient, "motion.rolling_friction", motion.rolling_friction),
                     unless(kFraction, "motion.restitution", motion.restitution),
                     unless(kVelocity, "motion.linear_velocity", motion.initial_velocity.linear),
                     unless(kAngularVelocity, "motion.angular_velocity", motion.initial_velocity.angular)});
  }
};

/// Distance of the carried obstacle's nearest point from the tool frame's origin [m].
double distance_from_tool(const world::Obstacle& obstacle) {
  constexpr world::Sphere kPoint{1e-6};
  double nearest = std::numeric_limits<double>::infinity();
  for (const world::PlacedShape& placed : obstacle.shapes) {
    const world::Pose X_TS = obstacle.attachment->X_TO * placed.X_BS;
    nearest = std::min(nearest, planner::shape_distance(kPoint, world::Pose::Identity(), placed.shape, X_TS).distance);
  }
  return nearest;
}

/// Points stand, or move along a script.
Answer complain_about_points(const world::Obstacle& obstacle) {
  const auto is_points = [](const world::PlacedShape& placed) {
    return std::holds_alternative<world::Points>(placed.shape);
  };
  const auto points = std::find_if(obstacle.shapes.begin(), obstacle.shapes.end(), is_points);
  if (points == obstacle.shapes.end()) return std::nullopt;
  const std::string key = indexed("shapes", static_cast<std::size_t>(points - obstacle.shapes.begin()));
  std::size_t count = 0;
  for (const world::PlacedShape& placed : obstacle.shapes) {
    if (is_points(placed)) count += std::get<world::Points>(placed.shape).cloud->size();
  }
  constexpr std::size_t kMost = world::PointCloud::kMostPoints;
  if (count > kMost) {
    return Complaint{"shapes", std::to_string(count) + " points",
                     "at most " + std::to_string(kMost) + " points in all"};
  }
  if (obstacle.attachment) return Complaint{key, "points", "a box, cylinder or mesh when an arm carries the obstacle"};
  if (!std::holds_alternative<world::DynamicMotion>(obstacle.motion)) return std::nullopt;
  return Complaint{key, "points", "a box, cylinder or mesh when the motion is dynamic: points cannot fall"};
}

Answer complain_about_attachment(const world::Obstacle& obstacle) {
  if (auto answer = complain(obstacle.attachment->X_TO, "attached_to.pose")) return answer;
  const bool scripted = !std::holds_alternative<world::StaticMotion>(obstacle.motion) &&
                        !std::holds_alternative<world::DynamicMotion>(obstacle.motion);
  if (scripted)
    return Complaint{"motion", "a scripted one", "static or dynamic while the obstacle is attached to an arm"};
  const double apart = distance_from_tool(obstacle);
  if (apart <= kGrasp) return std::nullopt;
  return Complaint{"attached_to.pose", number_text(apart) + " m from the tool",
                   "at most " + number_text(kGrasp) + " m from the tool, counted to the object's nearest point"};
}

Answer taken(const std::string& name, std::span<const std::string> names, const std::string& by) {
  if (std::find(names.begin(), names.end(), name) == names.end()) return std::nullopt;
  return Complaint{"name", name, "unique, but " + by + " has the same name"};
}

}  // namespace

Answer complain(const world::Pose& pose, const std::string& key) {
  if (auto answer = unless(kCoordinate, key + ".xyz", pose.translation())) return answer;
  if (world::is_rigid(pose)) return std::nullopt;
  return Complaint{key + ".rpy", "no rotation", "a rotation, of finite numbers"};
}

Answer complain(const world::Obstacle& obstacle) {
  if (!is_name(obstacle.name)) {
    return Complaint{"name", "\"" + printable(obstacle.name) + "\"", std::string(kNameRule)};
  }
  if (obstacle.shapes.empty() || obstacle.shapes.size() > kMostShapes) {
    return Complaint{"shapes", std::to_string(obstacle.shapes.size()) + " shapes",
                     "a list of 1 to " + std::to_string(kMostShapes) + " shapes"};
  }
  for (std::size_t i = 0; i < obstacle.shapes.size(); ++i) {
    const std::string key = indexed("shapes", i);
    if (auto answer = std::visit(ShapeRules{key}, obstacle.shapes[i].shape)) return answer;
    if (auto answer = complain(obstacle.shapes[i].X_BS, key + ".pose")) return answer;
  }
  if (auto answer = complain(obstacle.X_WO, "pose")) return answer;
  if (auto answer = complain_about_points(obstacle)) return answer;
  if (obstacle.attachment) {
    if (auto answer = complain_about_attachment(obstacle)) return answer;
  }
  return std::visit(MotionRules{obstacle}, obstacle.motion);
}

Answer complain_about_name(const std::string& name, std::span<const std::string> arms,
                           std::span<const std::string> obstacles) {
  return first_of({taken(name, arms, "an arm"), taken(name, obstacles, "another obstacle")});
}

}  // namespace hecaton::config
