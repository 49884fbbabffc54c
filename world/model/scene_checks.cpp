#include "world/model/scene_checks.hpp"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <numbers>
#include <sstream>

namespace hecaton::world {
namespace {

constexpr double kUnitTolerance = 1e-6;

bool positive(double value) {
  return std::isfinite(value) && value > 0.0;
}
bool not_negative(double value) {
  return std::isfinite(value) && value >= 0.0;
}
bool is_unit(const Eigen::Vector3d& v) {
  return v.allFinite() && std::abs(v.norm() - 1.0) < kUnitTolerance;
}

/// What is wrong, as a sentence; nothing: it is valid.
using Answer = std::optional<std::string>;

template <typename... Parts>
std::string sentence(const Parts&... parts) {
  std::ostringstream text;
  (text << ... << parts);
  return text.str();
}

Answer unless_positive(const char* what, double value) {
  return positive(value) ? Answer() : sentence(what, " = ", value, " must be finite and > 0");
}
Answer unless_not_negative(const char* what, double value) {
  return not_negative(value) ? Answer() : sentence(what, " = ", value, " must be finite and ≥ 0");
}
Answer unless_finite(const char* what, double value) {
  return std::isfinite(value) ? Answer() : sentence(what, " = ", value, " must be finite");
}
Answer unless_unit(const char* what, const Eigen::Vector3d& v) {
  return is_unit(v) ? Answer() : sentence(what, " = (", v.transpose(), ") must be a unit vector");
}

Answer first_of(std::initializer_list<Answer> answers) {
  const auto found =
      std::find_if(answers.begin(), answers.end(), [](const Answer& answer) { return answer.has_value(); });
  return found == answers.end() ? std::nullopt : *found;
}

/// [m³] by the divergence theorem over the faces' triangle fans.
double hull_volume(const ConvexHull& hull) {
  double six_volumes = 0.0;
  for (const auto& face : hull.faces) {
    for (std::size_t i = 2; i < face.size(); ++i) {
      const auto& a = hull.vertices[face[0]];
      six_volumes += a.dot(hull.vertices[face[i - 1]].cross(hull.vertices[face[i]]));
    }
  }
  return six_volumes / 6.0;
}

struct ShapeCheck {
  Answer operator()(const Box& box) const {
    const auto& half = box.half_extents;
    const bool good = positive(half.x()) && positive(half.y()) && positive(half.z());
    return good ? Answer() : sentence("box half extents (", half.transpose(), ") must be finite and > 0");
  }
  Answer operator()(const Sphere& sphere) const { return unless_positive("sphere radius", sphere.radius); }
  Answer operator()(const Capsule& capsule) const {
    return first_of({unless_positive("capsule radius", capsule.radius),
                     unless_not_negative("capsule half length", capsule.half_length)});
  }
  Answer operator()(const Cylinder& cylinder) const {
    return first_of({unless_positive("cylinder radius", cylinder.radius),
                     unless_positive("cylinder half length", cylinder.half_length)});
  }
  Answer operator()(const Convex& convex) const {
    if (!convex.hull) return "a convex shape needs a hull";
    const auto& vertices = convex.hull->vertices;
    if (vertices.size() < 4) return sentence("a convex hull needs at least 4 vertices, not ", vertices.size());
    for (const auto& vertex : vertices) {
      if (!vertex.allFinite()) return "the vertices of a convex hull must be finite";
    }
    for (const auto& face : convex.hull->faces) {
      for (const int index : face) {
        if (index < 0 || index >= static_cast<int>(vertices.size())) {
          return sentence("a face of the convex hull names vertex ", index, " of ", vertices.size());
        }
      }
    }
    return hull_volume(*convex.hull) > 0.0
               ? Answer()
               : "a convex hull needs faces, counter-clockwise from outside, that enclose a volume > 0";
  }
  Answer operator()(const Points& points) const { return points.cloud ? Answer() : "a shape of points needs a cloud"; }
};

struct MotionCheck {
  Answer operator()(const StaticMotion&) const { return std::nullopt; }
  Answer operator()(const WaypointMotion& motion) const {
    const std::size_t count = motion.poses_W.size();
    if (count < 2) return sentence("a motion through waypoints needs at least 2 of them, not ", count);
    for (std::size_t i = 0; i < count; ++i) {
      if (!is_rigid(motion.poses_W[i])) return sentence("waypoint ", i + 1, " is no finite, rigid pose");
      if (i + 1 == count && !motion.loop) break;
      const Pose& next = motion.poses_W[(i + 1) % count];
      const bool same_place = motion.poses_W[i].translation() == next.translation();
      if (same_place && !motion.poses_W[i].linear().isApprox(next.linear(), kUnitTolerance)) {
        return sentence("waypoint ", (i + 1) % count + 1,
                        " has the position of its predecessor with another orientation, which a speed along the line "
                        "cannot time; move it, too");
      }
    }
    return unless_positive("speed", motion.speed);
  }
  Answer operator()(const CircleMotion& motion) const {
    if (!motion.centre_W.allFinite()) return "the circle's centre must be finite";
    return first_of({unless_unit("axis", motion.axis_W), unless_finite("angular speed", motion.angular_speed)});
  }
  Answer operator()(const SineMotion& motion) const {
    return first_of({unless_unit("direction", motion.direction_W), unless_finite("amplitude", motion.amplitude),
                     unless_positive("period", motion.period), unless_finite("phase", motion.phase)});
  }
  Answer operator()(const ConveyorMotion& motion) const {
    return first_of({unless_unit("direction", motion.direction_W), unless_finite("speed", motion.speed),
                     unless_positive("length", motion.length)});
  }
  Answer operator()(const DynamicMotion& motion) const {
    if (!motion.initial_velocity.linear.allFinite() || !motion.initial_velocity.angular.allFinite()) {
      return "the initial velocity must be finite";
    }
    if (!(motion.restitution >= 0.0 && motion.restitution <= 1.0)) {
      return sentence("restitution = ", motion.restitution, " must lie in [0, 1]");
    }
    return first_of({unless_positive("mass", motion.mass), unless_not_negative("friction", motion.friction),
                     unless_not_negative("rolling friction", motion.rolling_friction)});
  }
};

Answer body_complaint(const Obstacle& obstacle) {
  if (obstacle.shapes.empty()) return "it needs at least one shape";
  const bool falls = !obstacle.attachment && std::holds_alternative<DynamicMotion>(obstacle.motion);
  for (const PlacedShape& placed : obstacle.shapes) {
    if (auto reason = why_invalid(placed.shape)) return reason;
    if (!std::holds_alternative<Points>(placed.shape)) continue;
    if (obstacle.attachment) return "an arm cannot carry points; give what it carries a box, cylinder or mesh";
    if (falls) return "points cannot fall; make the motion static, or give the obstacle a box, cylinder or mesh";
  }
  for (const PlacedShape& placed : obstacle.shapes) {
    if (!is_rigid(placed.X_BS)) return "the pose of one of its shapes is no finite, rigid pose";
  }
  if (!is_rigid(obstacle.X_WO)) return "its pose is no finite, rigid pose";
  if (obstacle.attachment && !is_rigid(obstacle.attachment->X_TO))
    return "its place on the tool is no finite, rigid pose";
  return std::visit(MotionCheck{}, obstacle.motion);
}

}  // namespace

std::optional<std::string> why_invalid(const Shape& shape) {
  return std::visit(ShapeCheck{}, shape);
}

bool is_rigid(const Pose& pose) {
  const Eigen::Matrix3d R = pose.linear();
  return pose.matrix().allFinite() && (R.transpose() * R).isIdentity(kUnitTolerance) && R.determinant() > 0.0;
}

std::optional<std::string> why_invalid(const Obstacle& obstacle) {
  if (obstacle.name.empty()) return "an obstacle needs a name";
  const Answer complaint = body_complaint(obstacle);
  return complaint ? Answer("obstacle '" + obstacle.name + "': " + *complaint) : std::nullopt;
}

double volume(const Shape& shape) {
  struct Visitor {
    double operator()(const Box& box) const { return 8.0 * box.half_extents.prod(); }
    double operator()(const Sphere& sphere) const { return ball(sphere.radius); }
    double operator()(const Capsule& capsule) const {
      return ball(capsule.radius) + rod(capsule.radius, capsule.half_length);
    }
    double operator()(const Cylinder& cylinder) const { return rod(cylinder.radius, cylinder.half_length); }
    double operator()(const Convex& convex) const { return hull_volume(*convex.hull); }
    double operator()(const Points& points) const {
      return static_cast<double>(points.cloud->size()) * ball(points.cloud->radius());
    }
    static double ball(double radius) { return 4.0 / 3.0 * std::numbers::pi * radius * radius * radius; }
    static double rod(double radius, double half) { return std::numbers::pi * radius * radius * 2.0 * half; }
  };
  return std::visit(Visitor{}, shape);
}

}  // namespace hecaton::world
