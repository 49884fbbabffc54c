#include "planner/model/separation_proof.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "planner/model/kinematics.hpp"

namespace hecaton::planner {
namespace {

/// A shape is the convex hull of `points` (in its own frame S), inflated by a ball: a superset of it, or itself.
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

/// What one joint between a and b can change their distance at most, per unit of motion.
///
/// With witness points p_a, p_b and n from a to b, ḋ = n·(v_b − v_a) = q̇ n·(z × (p_b − o)) = q̇ n·(z × (p_a − o)), as
/// n is parallel to p_b − p_a. Balls drop out likewise: n·(z × r n) = 0. So |ḋ| ≤ |q̇| times the distance from the axis
/// of the furthest core point, of either shape. A prismatic joint: |ḋ| ≤ |q̇|.
class RateBounds {
 public:
  RateBounds(const RobotModel& model, int a, int b) : model_(model) {
    forward_kinematics(model, Pose::Identity(), reference(model), kinematics_);
    first_ = joints_before(model, model.geometry[a].link);
    last_ = joints_before(model, model.geometry[b].link) - 1;
    for (int j = first_; j <= last_; ++j) {
      rates_.push_back(kinematics_.prismatic[j] ? 1.0 : std::min(reach_of_a(a, j), reach_of_b(b, j)));
    }
  }
  [[nodiscard]] int first() const { return first_; }
  [[nodiscard]] const std::vector<double>& rates() const { return rates_; }

  static JointVector reference(const RobotModel& model) {
    JointVector q = JointVector::Zero(model.joints());
    for (int j = 0; j < model.joints(); ++j) {
      if (std::isfinite(model.limits.lower[j])) q[j] = std::clamp(0.0, model.limits.lower[j], model.limits.upper[j]);
    }
    return q;
  }

 private:
  [[nodiscard]] double off_axis(const Eigen::Vector3d& p_W, int joint) const {
    return kinematics_.axis_W[joint].cross(p_W - kinematics_.origin_W[joint]).norm();
  }
  /// Travel of a prismatic joint away from the reference; distances across it grow by at most this.
  [[nodiscard]] double travel(int joint) const {
    return kinematics_.prismatic[joint] ? model_.limits.upper[joint] - model_.limits.lower[joint] : 0.0;
  }
  [[nodiscard]] double between_origins(int joint) const {  // joint and joint + 1
    return (kinematics_.origin_W[joint + 1] - kinematics_.origin_W[joint]).norm() + travel(joint);
  }
  [[nodiscard]] std::vector<Eigen::Vector3d> core_W(int geometry) const {
    const LinkGeometry& g = model_.geometry[geometry];
    std::vector<Eigen::Vector3d> points = core_points(g.shape);
    for (auto& p : points) p = kinematics_.X_WL[g.link] * (g.X_LS * p);
    return points;
  }
  template <typename Measure>
  [[nodiscard]] double furthest(int geometry, Measure measure) const {
    double result = 0.0;
    for (const auto& p_W : core_W(geometry)) result = std::max(result, measure(p_W));
    return result;
  }

  /// b hangs on joint last_: exact for that joint, the triangle inequality along the chain for those before.
  [[nodiscard]] double reach_of_b(int b, int joint) const {
    if (joint == last_) return furthest(b, [&](const auto& p_W) { return off_axis(p_W, joint); });
    double reach = off_axis(kinematics_.origin_W[joint + 1], joint);
    for (int j = joint + 1; j < last_; ++j) reach += between_origins(j);
    return reach + travel(last_) +
           furthest(b, [&](const auto& p_W) { return (p_W - kinematics_.origin_W[last_]).norm(); });
  }
  /// a is fixed to what carries joint first_: exact for that joint.
  [[nodiscard]] double reach_of_a(int a, int joint) const {
    if (joint == first_) return furthest(a, [&](const auto& p_W) { return off_axis(p_W, joint); });
    double reach = off_axis(kinematics_.origin_W[joint - 1], joint) + travel(joint - 1);
    for (int j = first_; j < joint - 1; ++j) reach += between_origins(j);
    return reach + furthest(a, [&](const auto& p_W) { return (p_W - kinematics_.origin_W[first_]).norm(); });
  }

  const RobotModel& model_;
  Kinematics kinematics_;
  int first_ = 0;
  int last_ = 0;
  std::vector<double> rates_;
};

struct Region {
  JointVector middle;
  JointVector half_width;
};

}  // namespace

bool proven_apart(const RobotModel& model, int a, int b, const PairDistance& distance, double apart, int budget) {
  const LinkGeometry* near_base = &model.geometry[a];
  const LinkGeometry* near_tip = &model.geometry[b];
  if (joints_before(model, near_base->link) > joints_before(model, near_tip->link)) {
    std::swap(near_base, near_tip);
    std::swap(a, b);
  }
  const RateBounds bounds(model, a, b);
  const int n = static_cast<int>(bounds.rates().size());
  Region everything{JointVector::Zero(n), JointVector::Zero(n)};
  for (int i = 0; i < n; ++i) {
    const double lower = model.limits.lower[bounds.first() + i];
    const double upper = model.limits.upper[bounds.first() + i];
    const bool endless = !std::isfinite(lower) || !std::isfinite(upper);
    everything.middle[i] = endless ? 0.0 : 0.5 * (lower + upper);
    everything.half_width[i] = endless ? std::numbers::pi : 0.5 * (upper - lower);
  }

  JointVector q = RateBounds::reference(model);
  Kinematics kinematics;
  std::vector<Region> open{everything};
  for (int evaluations = 0; !open.empty(); ++evaluations) {
    if (evaluations >= budget) return false;
    const Region region = open.back();
    open.pop_back();
    q.segment(bounds.first(), n) = region.middle;
    forward_kinematics(model, Pose::Identity(), q, kinematics);
    const double d = distance(near_base->shape, kinematics.X_WL[near_base->link] * near_base->X_LS, near_tip->shape,
                              kinematics.X_WL[near_tip->link] * near_tip->X_LS);
    if (!(d > apart)) return false;
    double change = 0.0;
    int widest = 0;
    for (int i = 0; i < n; ++i) {
      change += bounds.rates()[i] * region.half_width[i];
      if (bounds.rates()[i] * region.half_width[i] > bounds.rates()[widest] * region.half_width[widest]) widest = i;
    }
    if (d - change > apart) continue;
    Region half = region;
    half.half_width[widest] *= 0.5;
    half.middle[widest] = region.middle[widest] - half.half_width[widest];
    open.push_back(half);
    half.middle[widest] = region.middle[widest] + half.half_width[widest];
    open.push_back(half);
  }
  return true;
}

}  // namespace hecaton::planner
