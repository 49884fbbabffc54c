#include "planner/methods/potential_field/potential_field.hpp"

#include <algorithm>

#include <Eigen/Cholesky>

#include "planner/local/goal_objective.hpp"
#include "planner/methods/potential_field/potential.hpp"

namespace hecaton::planner::potential {
namespace {

/// Links of one arm repel each other within this share of Q*: they are always near each other.
constexpr double kSelfShare = 0.25;
/// Of the metric's mean diagonal, for what hardly moves any point.
constexpr double kLeastMetric = 1e-3;
/// Clearances that are looked at; when more are near, the nearest ones count.
constexpr std::size_t kMostClearances = 256;

std::vector<ControlPoint> joined(std::vector<ControlPoint> points, const std::vector<ControlPoint>& more) {
  points.insert(points.end(), more.begin(), more.end());
  return points;
}

}  // namespace

PotentialField::PotentialField(const CellGeometry& geometry, const PotentialParameters& parameters)
    : parameters_(parameters),
      arm_(geometry.own_arm()),
      points_(control_points(geometry, parameters.spacing)),
      attracted_(joined(points_, tool_points(*arm_.model, parameters.spacing))),
      of_points_(control_geometry(geometry, points_)),
      of_bodies_(geometry),
      clearances_(kMostClearances),
      goal_W_(attracted_.size()) {}

JointVector steepest_descent(const FieldValue& field) {
  JointMetric metric = field.metric;
  metric.diagonal().array() += kLeastMetric * field.metric.diagonal().mean();
  return -metric.llt().solve(field.gradient);
}

void PotentialField::rebuild(const CellGeometry& geometry) {
  points_ = control_points(geometry, parameters_.spacing);
  attracted_ = joined(points_, tool_points(*arm_.model, parameters_.spacing));
  of_points_.rebuild(control_geometry(geometry, points_));
  of_bodies_.rebuild(geometry);
  goal_W_.assign(attracted_.size(), Eigen::Vector3d::Zero());
  q_goal_ = {};
}

void PotentialField::set_goal(const JointVector& q_goal) {
  if (q_goal_.size() == q_goal.size() && q_goal_ == q_goal) return;
  q_goal_ = q_goal;
  Kinematics at_goal;
  forward_kinematics(*arm_.model, arm_.X_WB, q_goal, at_goal);
  for (std::size_t i = 0; i < attracted_.size(); ++i) {
    goal_W_[i] = at_goal.X_WL[attracted_[i].link] * attracted_[i].p_L;
  }
}

void PotentialField::attract(const Kinematics& own, const JointVector& q, FieldValue& out) const {
  if (parameters_.attraction == Attraction::kJoints) {
    const JointVector away = -joint_difference(arm_.limits, q, q_goal_);
    const double d = away.norm();
    const Potential u = potential::attraction(d, parameters_.goal_distance);
    out.attraction = u.value;
    if (d > 0.0) out.gradient = u.slope / d * away;
    out.metric.setIdentity(q.size(), q.size());
    return;
  }
  out.metric.setZero(q.size(), q.size());
  PointJacobian J;
  for (std::size_t i = 0; i < attracted_.size(); ++i) {
    const Eigen::Vector3d p_W = own.X_WL[attracted_[i].link] * attracted_[i].p_L;
    const Eigen::Vector3d away = p_W - goal_W_[i];
    const double d = away.norm();
    const Potential u = potential::attraction(d, parameters_.goal_distance);
    out.attraction += u.value;
    point_jacobian(*arm_.model, own, attracted_[i].link, p_W, J);
    out.metric.noalias() += J.transpose() * J;
    if (d > 0.0) out.gradient.noalias() += u.slope / d * (J.transpose() * away);
  }
}

/// ∇d = −nᵀJ in Q, since n points from the own body to what it is near. Forces are summed in Q: [Cardenas10] says why.
void PotentialField::repel(const Kinematics& own, const Clearance& clearance, double influence, FieldValue& out) const {
  const Potential u = potential::repulsion(clearance.distance, influence, parameters_.repulsion);
  JointVector row;
  directional_jacobian(*arm_.model, own, clearance.own_link, clearance.p_own_W, clearance.n_W, row);
  if (clearance.counterpart == Counterpart::kSelf) {
    JointVector other;
    directional_jacobian(*arm_.model, own, clearance.other_link, clearance.p_other_W, clearance.n_W, other);
    row -= other;
  }
  out.repulsion += u.value;
  out.gradient -= u.slope * row;
}

void PotentialField::evaluate(const CellPoses& poses, const JointVector& q, FieldValue& out) {
  out.attraction = out.repulsion = 0.0;
  out.gradient.setZero(q.size());
  attract(*poses.own, q, out);
  out.attraction_gradient = out.gradient;

  const double influence = parameters_.influence_distance;
  const InfluenceDistances near{.others = influence, .self = kSelfShare * influence};
  const int of_points = of_points_.clearances(poses, {.others = influence, .self = 0.0}, clearances_);
  for (int i = 0; i < of_points; ++i) {
    if (clearances_[i].own_body < static_cast<int>(points_.size())) repel(*poses.own, clearances_[i], influence, out);
  }
  out.clearance = influence;
  const int of_bodies = of_bodies_.clearances(poses, near, clearances_);
  for (int i = 0; i < of_bodies; ++i) {
    const bool self = clearances_[i].counterpart == Counterpart::kSelf;
    repel(*poses.own, clearances_[i], self ? near.self : near.others, out);
    out.clearance = std::min(out.clearance, clearances_[i].distance);
  }
}

}  // namespace hecaton::planner::potential
