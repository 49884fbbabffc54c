#include "planner/methods/potential_field/potential_field.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Cholesky>

#include "planner/local/goal_objective.hpp"
#include "planner/model/capsules.hpp"

namespace hecaton::planner::potential {
namespace {

/// Below this share of Q*, and inside obstacles, the potential continues as a straight line, which has a gradient.
constexpr double kNearest = 0.02;

}  // namespace

// [Cardenas10] eq. 2 and 6.
Potential attraction(double d, double goal_distance) {
  if (d <= goal_distance) return {0.5 * d * d, d};
  return {goal_distance * d - 0.5 * goal_distance * goal_distance, goal_distance};
}

// [Cardenas10] eq. 3 and 7:   U = ½ η (1/d − 1/Q*)²,   dU/dd = −η (1/d − 1/Q*) / d²
// differs from paper: eq. 7 prints the factor (1/d − 1/Q*) squared and without the sign of the derivative of 1/d. As
// printed it would attract.
Potential repulsion(double d, double influence_distance, double repulsion) {
  if (d >= influence_distance) return {};
  const double at = std::max(d, kNearest * influence_distance);
  const double excess = 1.0 / at - 1.0 / influence_distance;
  const double slope = -repulsion * excess / (at * at);
  return {0.5 * repulsion * excess * excess + slope * (d - at), slope};
}

namespace {

/// Radius of the ball that represents a point [m].
constexpr double kPoint = 1e-5;

/// Thinner boxes get points in their middle plane only [m].
constexpr double kThin = 0.02;

int pieces(double length, double spacing) {
  return std::max(1, static_cast<int>(std::ceil(length / spacing - 1e-9)));
}

class PointsOfBody {
 public:
  PointsOfBody(const Body& body, double spacing, std::vector<ControlPoint>& out)
      : link_(body.link), spacing_(spacing), out_(out) {
    if (body.capsule) {
      on_axis(body.capsule->X_FS, body.capsule->capsule.half_length, body.capsule->capsule.radius);
    } else {
      std::visit([&](const auto& shape) { of(body.X_CS, shape); }, body.shape);
    }
  }

 private:
  void add(const Eigen::Vector3d& p_L, double radius) { out_.push_back({link_, p_L, radius}); }

  void on_axis(const Pose& X_LS, double half_length, double radius) {
    const int count = half_length > 0.0 ? pieces(2.0 * half_length, spacing_) : 0;
    for (int i = 0; i <= count; ++i) {
      const double z = count == 0 ? 0.0 : half_length * (2.0 * i / count - 1.0);
      add(X_LS * Eigen::Vector3d(0.0, 0.0, z), radius);
    }
  }

  void of(const Pose& X_LS, const world::Sphere& sphere) { add(X_LS.translation(), sphere.radius); }
  void of(const Pose& X_LS, const world::Capsule& capsule) { on_axis(X_LS, capsule.half_length, capsule.radius); }
  // Balls on the axis that stay inside. A flat cylinder gets one ball that fits.
  void of(const Pose& X_LS, const world::Cylinder& cylinder) {
    const double radius = std::min(cylinder.radius, cylinder.half_length);
    on_axis(X_LS, cylinder.half_length - radius, radius);
  }
  // A hull may have hundreds of vertices: it gets points on its axis without radius, because a capsule would protrude.
  void of(const Pose& X_LS, const world::Convex& convex) {
    const PlacedCapsule around = bounding_capsule(convex);
    on_axis(X_LS * around.X_FS, around.capsule.half_length, 0.0);
  }
  void of(const Pose& X_LS, const world::Points& points) { add(X_LS * points.cloud->centre(), 0.0); }
  void of(const Pose& X_LS, const world::Box& box) {
    for (int axis = 0; axis < 3; ++axis) edges_along(X_LS, box.half_extents, axis);
  }

  /// The four edges along an axis; the first axis includes the vertices.
  void edges_along(const Pose& X_LS, const Eigen::Vector3d& half, int axis) {
    const int count = pieces(2.0 * half[axis], spacing_);
    const int first = axis == 0 ? 0 : 1;
    for (int corner = 0; corner < 4; ++corner) {
      Eigen::Vector3d p = half;
      for (int k = 0; k < 2; ++k) {
        const int other = (axis + 1 + k) % 3;
        const bool low = (corner >> k & 1) != 0;
        if (half[other] < kThin && low) p[other] = std::nan("");  // the opposite edge is enough
        if (half[other] < kThin && !low) p[other] = 0.0;
        if (half[other] >= kThin && low) p[other] = -half[other];
      }
      if (p.hasNaN()) continue;
      if (half[axis] < kThin && first == 0) {
        p[axis] = 0.0;
        add(X_LS * p, 0.0);
        continue;
      }
      for (int i = first; i <= count - first; ++i) {
        p[axis] = half[axis] * (2.0 * i / count - 1.0);
        add(X_LS * p, 0.0);
      }
    }
  }

  int link_;
  double spacing_;
  std::vector<ControlPoint>& out_;
};

}  // namespace

std::vector<ControlPoint> control_points(const CellGeometry& geometry, double spacing) {
  std::vector<ControlPoint> points;
  for (const Body& body : geometry.own_bodies()) {
    if (body.moves) PointsOfBody(body, spacing, points);
  }
  return points;
}

std::vector<ControlPoint> tool_points(const RobotModel& model, double spacing) {
  const Pose& X_LT = model.X_LT;
  return {{model.tool_link, X_LT.translation(), 0.0},
          {model.tool_link, X_LT * Eigen::Vector3d(spacing, 0.0, 0.0), 0.0},
          {model.tool_link, X_LT * Eigen::Vector3d(0.0, spacing, 0.0), 0.0}};
}

CellGeometry control_geometry(const CellGeometry& geometry, const std::vector<ControlPoint>& points) {
  std::vector<Arm> arms = geometry.arms();
  auto model = std::make_shared<RobotModel>(*arms[geometry.self()].model);
  model->geometry.clear();
  model->self_pairs.clear();
  for (const ControlPoint& point : points) {
    LinkGeometry& ball = model->geometry.emplace_back();
    ball.link = point.link;
    ball.shape = world::Sphere{std::max(point.radius, kPoint)};
    ball.X_LS.translation() = point.p_L;
  }
  arms[geometry.self()].model = std::move(model);
  CellGeometry of_points(std::move(arms), geometry.self());

  // Carried objects have no bodies of their own: their indices stay without shapes.
  std::vector<world::Obstacle> obstacles(geometry.obstacle_count());
  for (int i = 0; i < geometry.obstacle_count(); ++i) {
    obstacles[i].name = std::to_string(i);
    for (const Body& body : geometry.obstacle_bodies(i)) obstacles[i].shapes.push_back({body.shape, body.X_CS});
  }
  of_points.set_obstacles(obstacles);
  return of_points;
}

namespace {

/// Links of one arm are always near each other: they repel within this share of Q* only.
constexpr double kSelfShare = 0.25;
/// Regularisation of the metric as a share of its mean diagonal.
constexpr double kLeastMetric = 1e-3;
/// Largest number of clearances; the nearest ones count.
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

/// ∇d = −nᵀJ in joint space, because n points from the own body to the other one. Forces are summed in joint space as
/// in [Cardenas10].
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
