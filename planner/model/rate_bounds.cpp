#include "planner/model/rate_bounds.hpp"

#include <algorithm>
#include <cmath>
#include <variant>

namespace hecaton::planner {
namespace {

/// Points in S whose convex hull, inflated by a ball, is the shape or a superset of it.
std::vector<Eigen::Vector3d> core_points(const world::Shape& shape) {
  const auto corners = [](const Eigen::Vector3d& half) {
    std::vector<Eigen::Vector3d> points;
    for (const double x : {-half.x(), half.x()}) {
      for (const double y : {-half.y(), half.y()}) {
        for (const double z : {-half.z(), half.z()}) points.emplace_back(x, y, z);
      }
    }
    return points;
  };
  if (const auto* box = std::get_if<world::Box>(&shape)) return corners(box->half_extents);
  if (const auto* capsule = std::get_if<world::Capsule>(&shape)) return corners({0.0, 0.0, capsule->half_length});
  if (const auto* cylinder = std::get_if<world::Cylinder>(&shape)) {
    return corners({cylinder->radius, cylinder->radius, cylinder->half_length});
  }
  if (const auto* convex = std::get_if<world::Convex>(&shape)) return convex->hull->vertices;
  return {Eigen::Vector3d::Zero()};
}

}  // namespace

LinkPart link_part(int link, const world::Shape& shape, const Pose& X_LS) {
  LinkPart part{link, core_points(shape)};
  for (Eigen::Vector3d& p : part.core_L) p = X_LS * p;
  return part;
}

// With witness points p_a, p_b and n from a to b:
//
//     ḋ = n·(v_b − v_a) = q̇ n·(z × (p_b − o)) = q̇ n·(z × (p_a − o)),   n is parallel to p_b − p_a
//
// Balls do not contribute: n·(z × r n) = 0. So |ḋ| ≤ |q̇| times the distance of the furthest core point from the axis,
// for either part. For a prismatic axis |ḋ| ≤ |q̇|.
RateBounds::RateBounds(const RobotModel& model, const LinkPart& a, const LinkPart& b)
    : model_(model), rates_(JointVector::Zero(model.joints())) {
  const int axes_a = axes_before(model, a.link);
  const int axes_b = axes_before(model, b.link);
  const LinkPart& nearer = axes_a <= axes_b ? a : b;
  const LinkPart& farther = axes_a <= axes_b ? b : a;
  forward_kinematics(model, Pose::Identity(), reference(model), kinematics_);
  first_ = std::min(axes_a, axes_b);
  last_ = std::max(axes_a, axes_b) - 1;
  for (const Link& link : model.links) {
    if (link.joint >= 0) moving_.push_back(&link);
  }
  for (int axis = first_; axis <= last_; ++axis) {
    const double rate =
        kinematics_.prismatic[axis] ? 1.0 : std::min(reach_from_first(nearer, axis), reach_from_last(farther, axis));
    rates_[moving_[axis]->joint] += std::abs(moving_[axis]->multiplier) * rate;
    joints_.insert(moving_[axis]->joint);
  }
}

JointVector RateBounds::reference(const RobotModel& model) {
  JointVector q = JointVector::Zero(model.joints());
  for (int j = 0; j < model.joints(); ++j) {
    if (std::isfinite(model.limits.lower[j])) q[j] = std::clamp(0.0, model.limits.lower[j], model.limits.upper[j]);
  }
  return q;
}

double RateBounds::off_axis(const Eigen::Vector3d& p_W, int axis) const {
  return kinematics_.axis_W[axis].cross(p_W - kinematics_.origin_W[axis]).norm();
}

/// Travel along a prismatic axis: distances across the axis grow by at most this from the reference.
double RateBounds::travel(int axis) const {
  if (!kinematics_.prismatic[axis]) return 0.0;
  const int joint = moving_[axis]->joint;
  return std::abs(moving_[axis]->multiplier) * (model_.limits.upper[joint] - model_.limits.lower[joint]);
}

/// Between axis and axis + 1.
double RateBounds::between_origins(int axis) const {
  return (kinematics_.origin_W[axis + 1] - kinematics_.origin_W[axis]).norm() + travel(axis);
}

template <typename Measure>
double RateBounds::furthest(const LinkPart& part, Measure measure) const {
  double result = 0.0;
  for (const auto& p_L : part.core_L) result = std::max(result, measure(kinematics_.X_WL[part.link] * p_L));
  return result;
}

/// The largest distance from an axis of a part that axis last_ carries. Exact for last_; for axes before it by the
/// triangle inequality along the chain.
double RateBounds::reach_from_last(const LinkPart& part, int axis) const {
  if (axis == last_) return furthest(part, [&](const auto& p_W) { return off_axis(p_W, axis); });
  double reach = off_axis(kinematics_.origin_W[axis + 1], axis);
  for (int j = axis + 1; j < last_; ++j) reach += between_origins(j);
  return reach + travel(last_) +
         furthest(part, [&](const auto& p_W) { return (p_W - kinematics_.origin_W[last_]).norm(); });
}

/// The same of a part on which axis first_ is mounted: exact for first_.
double RateBounds::reach_from_first(const LinkPart& part, int axis) const {
  if (axis == first_) return furthest(part, [&](const auto& p_W) { return off_axis(p_W, axis); });
  double reach = off_axis(kinematics_.origin_W[axis - 1], axis) + travel(axis - 1);
  for (int j = first_; j < axis - 1; ++j) reach += between_origins(j);
  return reach + furthest(part, [&](const auto& p_W) { return (p_W - kinematics_.origin_W[first_]).norm(); });
}

}  // namespace hecaton::planner
