#include "planner/tick.hpp"

#include <algorithm>
#include <vector>

#include "planner/collision/exact_distance.hpp"
#include "planner/local/velocity_damper.hpp"
#include "planner/trajectory/stop_profile.hpp"

namespace hecaton::planner {

struct TickScratch::Storage {
  explicit Storage(const CellGeometry& geometry) : distance(geometry), arms(geometry.arms().size()) {
    rebuild(geometry);
  }

  void rebuild(const CellGeometry& geometry) {
    distance.rebuild(geometry);
    margins.assign(geometry.arms().size(), 0.0);
    extra_influence.assign(geometry.arms().size(), 0.0);
    clearances.resize(kMaxRows);
  }

  ExactDistance distance;
  Kinematics own;
  std::vector<Kinematics> arms;
  std::vector<double> margins;          ///< against each arm, for the age of its state [m]
  std::vector<double> extra_influence;  ///< beyond dᵢ, for the speeds involved [m]
  std::vector<Clearance> clearances;
  std::array<Row, kMaxRows> rows;
};

TickScratch::TickScratch(const CellGeometry& geometry) : storage_(std::make_unique<Storage>(geometry)) {}
TickScratch::~TickScratch() = default;
TickScratch::TickScratch(TickScratch&&) noexcept = default;
TickScratch& TickScratch::operator=(TickScratch&&) noexcept = default;
void TickScratch::rebuild(const CellGeometry& geometry) {
  storage_->rebuild(geometry);
}

namespace {

/// Who is too old or unknown: the arm's index, `kObstacles`, or −1.
constexpr int kNobody = -1;
constexpr int kObstacles = -2;

int find_stale(const CellGeometry& geometry, const LocalParameters& parameters, const TickInput& input) {
  for (int i = 0; i < static_cast<int>(input.arms.size()); ++i) {
    if (i == geometry.self()) continue;
    if (!input.arms[i].known || input.arms[i].age > parameters.state_age_limit) return i;
  }
  for (const auto& obstacle : input.obstacles) {
    if (obstacle.age > parameters.state_age_limit) return kObstacles;
  }
  return kNobody;
}

/// A bound on the speed of every point of an arm [m/s]: Σⱼ |q̇ⱼ| times the farthest point from axis j.
double fastest_point(const RobotModel& model, const std::vector<Body>& bodies, const Kinematics& kinematics,
                     const JointVector& speed) {
  double fastest = 0.0;
  for (int j = 0; j < model.joints(); ++j) {
    double lever = kinematics.prismatic[j] ? 1.0 : 0.0;
    if (!kinematics.prismatic[j]) {
      for (const Body& body : bodies) {
        if (!body.moves) continue;
        const Eigen::Vector3d centre_W = kinematics.X_WL[body.link] * body.bound.centre;
        lever = std::max(lever, (centre_W - kinematics.origin_W[j]).norm() + body.bound.radius);
      }
    }
    fastest += speed[j] * lever;
  }
  return fastest;
}

double fastest_obstacle(const CellGeometry& geometry, std::span<const world::ObstacleState> obstacles) {
  double fastest = 0.0;
  for (int i = 0; i < geometry.obstacle_count(); ++i) {
    double reach = 0.0;
    for (const Body& body : geometry.obstacle_bodies(i)) {
      reach = std::max(reach, body.bound.centre.norm() + body.bound.radius);
    }
    const world::Twist& v = obstacles[i].velocity;
    fastest = std::max(fastest, v.linear.norm() + v.angular.norm() * reach);
  }
  return fastest;
}

/// Extrapolates every other arm to now at constant velocity and widens the margins for what it may have done instead:
/// with acceleration a for its age τ a joint strays by ½aτ².
void look_around(const CellGeometry& geometry, const LocalParameters& parameters, const TickInput& input,
                 double own_speed, double influence, TickScratch::Storage& s) {
  const DamperParameters& damper = parameters.damper;
  for (int i = 0; i < static_cast<int>(geometry.arms().size()); ++i) {
    if (i == geometry.self()) continue;
    const ArmObservation& other = input.arms[i];
    const Arm& arm = geometry.arms()[i];
    forward_kinematics(*arm.model, arm.X_WB, other.q + other.qd * other.age, s.arms[i]);
    const JointVector one = JointVector::Ones(other.q.size());
    const double reach =
        fastest_point(*arm.model, geometry.arm_bodies(i), s.arms[i], one) / static_cast<double>(one.size());
    s.margins[i] = 0.5 * parameters.acceleration_of_others * other.age * other.age * reach;
    // A row matters while its bound can be reached: k (d − dₛ) below the approach speed (half of it when both give
    // way).
    const double approach =
        other.plans ? 2.0 * own_speed
                    : own_speed + fastest_point(*arm.model, geometry.arm_bodies(i), s.arms[i], other.qd.cwiseAbs());
    s.extra_influence[i] = s.margins[i] + std::max(0.0, damper.distance_of(approach) - influence);
  }
}

int build_rows(const DamperScene& scene, const JointVector& fastest, std::span<const Clearance> clearances,
               std::span<Row> rows) {
  int count = 0;
  for (int i = 0; i < static_cast<int>(clearances.size()) && count < static_cast<int>(rows.size()); ++i) {
    Row& row = rows[count];
    row = velocity_damper(scene, clearances[i]);
    row.clearance = i;
    // What no joint moves cannot be helped by moving: such a row would only make the others infeasible.
    const double reach = row.g.cwiseAbs().dot(fastest);
    const bool can_bind = reach > row.h;
    if (reach > 0.0 && (row.influences || can_bind)) ++count;
  }
  return count;
}

TickResult brake(const CellGeometry& geometry, const TickInput& input, TickStatus status) {
  TickResult result;
  result.status = status;
  result.qd = braking_velocity(geometry.own_arm().limits, input.qd, input.dt);
  result.q = input.q + 0.5 * (input.qd + result.qd) * input.dt;
  return result;
}

}  // namespace

TickResult tick(const CellGeometry& geometry, const LocalParameters& parameters, const TickInput& input,
                TickMemory& memory, TickScratch& scratch) {
  TickScratch::Storage& s = scratch.storage();
  const Arm& arm = geometry.own_arm();
  if (input.hold) return brake(geometry, input, TickStatus::kHolding);
  if (const int stale = find_stale(geometry, parameters, input); stale != kNobody) {
    TickResult result = brake(geometry, input, TickStatus::kStaleInput);
    result.stale_arm = stale;
    return result;
  }

  forward_kinematics(*arm.model, arm.X_WB, input.q, s.own);
  const JointVector fastest = (input.qd.cwiseAbs() + arm.limits.acceleration * input.dt).cwiseMin(arm.limits.velocity);
  const double own_speed = fastest_point(*arm.model, geometry.own_bodies(), s.own, fastest);

  const DamperParameters& damper = parameters.damper;
  const double influence =
      std::max(damper.influence_distance, damper.distance_of(own_speed + fastest_obstacle(geometry, input.obstacles)));
  const double self_influence = std::max(damper.self_influence_distance, damper.self_distance_of(2.0 * own_speed));
  look_around(geometry, parameters, input, own_speed, influence, s);
  const int near = s.distance.clearances(
      {&s.own, s.arms, input.obstacles},
      {.others = influence, .self = self_influence, .extra_of_arm = s.extra_influence}, s.clearances);
  const DamperScene scene{geometry, s.own, s.arms, input.arms, input.obstacles, s.margins, damper};
  const int rows = build_rows(scene, fastest, std::span(s.clearances).first(near), s.rows);

  const JointVector& q_goal = input.has_goal ? input.q_goal : input.q;
  const LocalResult local = plan_locally(
      {arm.limits, parameters, input.q, input.qd, q_goal, input.dt, std::span(s.rows).first(rows)}, memory.local);

  TickResult result;
  result.qd = local.qd;
  result.q = input.q + 0.5 * (input.qd + local.qd) * input.dt;
  result.rows = rows;
  result.relaxed = local.relaxed;
  result.redraws = memory.local.follower.redraws;
  if (local.binding_row >= 0) {
    result.has_binding = true;
    result.binding = s.clearances[s.rows[local.binding_row].clearance];
  }
  const bool at_goal = input.has_goal && (input.q_goal - input.q).cwiseAbs().maxCoeff() < parameters.goal_tolerance &&
                       input.qd.cwiseAbs().maxCoeff() < 10.0 * parameters.goal_tolerance;
  result.status = !input.has_goal   ? TickStatus::kIdle
                  : at_goal         ? TickStatus::kReached
                  : local.blocked   ? TickStatus::kBlocked
                  : local.following ? TickStatus::kFollowing
                                    : TickStatus::kMoving;
  return result;
}

}  // namespace hecaton::planner
