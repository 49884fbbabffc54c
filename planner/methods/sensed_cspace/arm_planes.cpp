#include "planner/methods/sensed_cspace/arm_planes.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "planner/model/kinematics.hpp"

namespace hecaton::planner::cspace {
namespace {

constexpr double kParallel = 1e-6;
/// Least length of a link [m].
constexpr double kShortestLink = 1e-3;

/// A ball. A shape lies in the convex hull of a few balls.
struct Ball {
  Eigen::Vector3d centre;
  double radius;
};

std::vector<Ball> hull_of_balls(const world::Shape& shape) {
  struct Visitor {
    std::vector<Ball> operator()(const world::Box& box) const {
      std::vector<Ball> balls;
      for (int corner = 0; corner < 8; ++corner) {
        const Eigen::Vector3d sign((corner & 1) != 0 ? 1 : -1, (corner & 2) != 0 ? 1 : -1, (corner & 4) != 0 ? 1 : -1);
        balls.push_back({sign.cwiseProduct(box.half_extents), 0.0});
      }
      return balls;
    }
    std::vector<Ball> operator()(const world::Sphere& sphere) const {
      return {{Eigen::Vector3d::Zero(), sphere.radius}};
    }
    std::vector<Ball> operator()(const world::Capsule& capsule) const {
      const Eigen::Vector3d end(0, 0, capsule.half_length);
      return {{end, capsule.radius}, {-end, capsule.radius}};
    }
    std::vector<Ball> operator()(const world::Cylinder& cylinder) const {
      const Eigen::Vector3d end(0, 0, cylinder.half_length);
      return {{end, cylinder.radius}, {-end, cylinder.radius}};
    }
    std::vector<Ball> operator()(const world::Convex& convex) const {
      std::vector<Ball> balls;
      for (const Eigen::Vector3d& vertex : convex.hull->vertices) balls.push_back({vertex, 0.0});
      return balls;
    }
    std::vector<Ball> operator()(const world::Points& points) const {
      return {{points.cloud->centre(), points.cloud->bounding_radius()}};
    }
  };
  return std::visit(Visitor{}, shape);
}

Kinematics at_zero(const RobotModel& model) {
  Kinematics kinematics;
  forward_kinematics(model, Pose::Identity(), JointVector::Zero(model.joints()), kinematics);
  return kinematics;
}

double distance_to_segment(const Point& p, const Point& a, const Point& b) {
  const double x = b.x - a.x;
  const double y = b.y - a.y;
  const double t = std::clamp(((p.x - a.x) * x + (p.y - a.y) * y) / (x * x + y * y), 0.0, 1.0);
  return std::hypot(p.x - a.x - t * x, p.y - a.y - t * y);
}

}  // namespace

std::optional<std::string> ArmPlanes::why_not(const RobotModel& model) {
  const int joints = model.joints();
  if (joints != 2 && joints != 3) return "it has " + std::to_string(joints) + " joints, not 2 or 3";
  if (model.has_followers) return "some of its links follow a joint of another one";
  const Kinematics k = at_zero(model);
  for (int j = 0; j < joints; ++j) {
    if (k.prismatic[j]) return "its joint " + model.joint_names[j] + " does not turn";
  }
  const int shoulder = joints - 2;
  const Eigen::Vector3d n = k.axis_W[shoulder];
  if (n.cross(k.axis_W[shoulder + 1]).norm() > kParallel) return "the axes of its last two joints are not parallel";
  const auto across = [&](const Eigen::Vector3d& way) { return (way - way.dot(n) * n).norm(); };
  if (across(k.origin_W[shoulder + 1] - k.origin_W[shoulder]) < kShortestLink) {
    return "its last two joints turn about the same axis";
  }
  if (across(k.X_WT.translation() - k.origin_W[shoulder + 1]) < kShortestLink) {
    return "its tool frame is on the axis of its last joint";
  }
  return std::nullopt;
}

ArmPlanes::ArmPlanes(const RobotModel& model) : spatial_(model.joints() == 3) {
  const Kinematics k = at_zero(model);
  const int shoulder = model.joints() - 2;
  axis0_B_ = k.axis_W[0];
  centre0_B_ = k.origin_W[0];
  n_B_ = k.axis_W[shoulder];
  origin_B_ = k.origin_W[shoulder];
  const Eigen::Vector3d link1 = k.origin_W[shoulder + 1] - origin_B_;
  x_B_ = (link1 - link1.dot(n_B_) * n_B_).normalized();  // so that θ₁ is the joint's own angle
  y_B_ = n_B_.cross(x_B_);
  const auto flat = [&](const Eigen::Vector3d& p_B) {
    return Point{(p_B - origin_B_).dot(x_B_), (p_B - origin_B_).dot(y_B_)};
  };
  const Point elbow = flat(k.origin_W[shoulder + 1]);
  const Point tip = flat(k.X_WT.translation());
  arm_.length1 = elbow.x;
  arm_.length2 = std::hypot(tip.x - elbow.x, tip.y - elbow.y);
  // Rounding removes differences of C libraries in the last bit.
  offset2_ = std::nearbyint(std::atan2(tip.y - elbow.y, tip.x - elbow.x) * 0x1p40) * 0x1p-40;
  sense2_ = n_B_.dot(k.axis_W[shoulder + 1]) > 0.0 ? 1.0 : -1.0;

  std::array<double, 2> widths{};
  for (const LinkGeometry& geometry : model.geometry) {
    const int link = axes_before(model, geometry.link) - shoulder - 1;
    if (link < 0) continue;  // the column does not move in the plane
    for (const Ball& ball : hull_of_balls(geometry.shape)) {
      const Eigen::Vector3d p_B = k.X_WL[geometry.link] * geometry.X_LS * ball.centre;
      const double off_axis =
          link == 0 ? distance_to_segment(flat(p_B), {0.0, 0.0}, elbow) : distance_to_segment(flat(p_B), elbow, tip);
      widths[link] = std::max(widths[link], off_axis + ball.radius);
      const double off_plane = (p_B - origin_B_).dot(n_B_);
      Slab& slab = slabs_[link];
      const bool first = slab.low == slab.high;
      slab.low = std::min(first ? off_plane - ball.radius : slab.low, off_plane - ball.radius);
      slab.high = std::max(first ? off_plane + ball.radius : slab.high, off_plane + ball.radius);
    }
  }
  arm_.width1 = std::max(widths[0], kShortestLink);
  arm_.width2 = std::max(widths[1], kShortestLink);
  if (spatial_) {
    const Eigen::Vector3d to_plane = origin_B_ - centre0_B_;
    const double aside = (to_plane - to_plane.dot(axis0_B_) * axis0_B_).norm();
    const double thick = std::max({-slabs_[0].low, slabs_[0].high, -slabs_[1].low, slabs_[1].high, 0.0});
    radius_ = std::hypot(arm_.reach() + std::max(arm_.width1, arm_.width2), thick) + aside;
  }
}

Angles ArmPlanes::angles(const JointVector& q) const {
  const Eigen::Index shoulder = q.size() - 2;
  return {spatial_ ? q[0] : 0.0, q[shoulder], sense2_ * q[shoulder + 1] + offset2_};
}

JointVector ArmPlanes::joints(const Angles& angles) const {
  JointVector q(spatial_ ? 3 : 2);
  if (spatial_) q[0] = angles[0];
  q[q.size() - 2] = angles[1];
  q[q.size() - 1] = sense2_ * (angles[2] - offset2_);
  return q;
}

PlacedPoint ArmPlanes::place(const Eigen::Vector3d& p_B, const Turn& theta0) const {
  Eigen::Vector3d p = p_B;
  if (spatial_) {  // Rodrigues: turned by −θ₀ about the axis
    const Eigen::Vector3d v = p_B - centre0_B_;
    const Eigen::Vector3d along = axis0_B_.dot(v) * axis0_B_;
    p = centre0_B_ + along + theta0.cosine * (v - along) - theta0.sine * axis0_B_.cross(v);
  }
  const Eigen::Vector3d d = p - origin_B_;
  return {{d.dot(x_B_), d.dot(y_B_)}, d.dot(n_B_)};
}

}  // namespace hecaton::planner::cspace
