#include "planner/local/velocity_damper.hpp"

#include <algorithm>

#include "planner/local/latency_compensation.hpp"

namespace hecaton::planner {
namespace {

/// An obstacle has at most 64 shapes: above them is room for the parts of a cloud.
constexpr int kShapeBits = 6;

std::uint32_t pair_key(const Clearance& c) {
  const std::uint32_t body = static_cast<std::uint32_t>(c.other_body) ^ static_cast<std::uint32_t>(c.part)
                                                                            << kShapeBits;
  return static_cast<std::uint32_t>(c.counterpart) << 28 | (static_cast<std::uint32_t>(c.other) & 0x3FF) << 18 |
         (body & 0x1FF) << 9 | (static_cast<std::uint32_t>(c.own_body) & 0x1FF);
}

/// Reduction of the distance by the tracking error of the drive [m].
double lag(const DamperScene& scene, const Row& row) {
  return scene.tracking_error.size() == 0 ? 0.0 : std::max(0.0, row.g.dot(scene.tracking_error));
}

/// Bound of the own point's approach speed since an old state [m/s]. The direction to a body that passes has turned
/// since, so that motion across it now may have been an approach then.
double fastest_approach(const DamperScene& scene, const Clearance& clearance, double approach) {
  PointJacobian J;
  point_jacobian(*scene.geometry.own_arm().model, scene.own, clearance.own_link, clearance.p_own_W, J);
  const Eigen::Vector3d velocity = J * scene.own_qd;
  return approach >= 0.0 ? velocity.norm() : (velocity - approach * clearance.n_W).norm();
}

void keep(const DamperScene& scene, const Damper& damper, double distance, double share, double approach, Row& row) {
  row.h = share * damper.speed(distance) - approach;
  row.stop_time = damper.time_constant(distance) - scene.dt;
  row.influences = distance < damper.security_distance + damper.width;
}

void against_self(const DamperScene& scene, const Clearance& clearance, Row& row) {
  const double widest = scene.geometry.widest(clearance.own_body, clearance.other_body);
  const Damper damper = scene.parameters.damper.against_self(scene.response(scene.geometry.self()), widest);
  JointVector other;
  directional_jacobian(*scene.geometry.own_arm().model, scene.own, clearance.other_link, clearance.p_other_W,
                       clearance.n_W, other);
  row.g -= other;
  const double distance = clearance.distance - lag(scene, row);
  keep(scene, damper, distance, 1.0, 0.0, row);
  row.influences = row.influences && distance < kRestShare * widest;
}

/// A lost arm is anywhere in its stop set. The row never asks for a retreat: retreating from the whole set would move
/// the own arm far away. It may stay, and it may leave.
void against_lost_arm(const DamperScene& scene, const Clearance& clearance, Row& row) {
  const Damper damper = scene.parameters.damper.against_others(scene.response(clearance.other));
  const double uncertainty = scene.body_uncertainty[clearance.other][clearance.other_body];
  keep(scene, damper, clearance.distance - lag(scene, row) - uncertainty, 1.0, 0.0, row);
  row.h = std::max(row.h, 0.0);
}

void against_arm(const DamperScene& scene, const Clearance& clearance, Row& row) {
  const Damper damper = scene.parameters.damper.against_others(scene.response(clearance.other));
  const ArmObservation& other = scene.observations[clearance.other];
  if (other.lost()) {
    against_lost_arm(scene, clearance, row);
    return;
  }
  if (other.plans && other.age <= 0.0) {  // independent of the other arm's motion
    keep(scene, damper, clearance.distance - lag(scene, row), 0.5, 0.0, row);
    return;
  }
  const Arm& arm = scene.geometry.arms()[clearance.other];
  JointVector g_other;
  directional_jacobian(*arm.model, scene.arms[clearance.other], clearance.other_link, clearance.p_other_W,
                       -clearance.n_W, g_other);
  const double approach = g_other.dot(other.qd);
  const double own_approach = row.g.dot(scene.own_qd);
  const AgedPair pair{.distance = clearance.distance - lag(scene, row),
                      .age = other.age,
                      .own_speed = own_approach,
                      .own_fastest = fastest_approach(scene, clearance, own_approach),
                      .other_speed = approach,
                      .other_acceleration = g_other.cwiseAbs().dot(arm.limits.acceleration)};
  const double distance =
      other.foreign ? least_distance(pair) : least_distance(pair, damper.security_distance, 0.5 * damper.slope());
  if (other.plans) {
    keep(scene, damper, distance, 0.5, 0.0, row);
  } else {
    keep(scene, damper, distance, 1.0, approach, row);
  }
}

/// The volume that the obstacle's body can sweep within `seconds` from now, for any motion within its acceleration.
Sweep swept_by(const DamperScene& scene, const Clearance& clearance, double seconds) {
  const world::ObstacleState& state = scene.obstacles[clearance.other];
  const world::BoundingSphere& ball = scene.geometry.obstacle_bodies(clearance.other)[clearance.other_body].bound;
  const double half = 0.5 * scene.parameters.acceleration_of_obstacles;
  const double end = state.age + seconds;
  return {.way_W = seconds * state.velocity.at(state.X_WO * ball.centre, state.X_WO.translation()),
          .radius_begin = half * state.age * state.age,
          .radius_end = half * end * end + state.velocity.angular.norm() * ball.radius * seconds};
}

/// An obstacle that passes by approaches for a while without reaching the arm. The volume that it sweeps while the arm
/// stops counts as a static body. The damper against this volume replaces the row when it is less restrictive
/// (docs/explanation/0010-passing-obstacles.md).
void allow_passing(const DamperScene& scene, const Clearance& clearance, double security_distance, Row& row) {
  const double seconds = row.stop_time + scene.dt;
  const ShapeDistance swept = scene.distances->sweep_distance(clearance, {&scene.own, scene.arms, scene.obstacles},
                                                              swept_by(scene, clearance, seconds));
  if (swept.distance <= 0.0) return;
  Row aside = row;
  directional_jacobian(*scene.geometry.own_arm().model, scene.own, clearance.own_link, swept.p_a_W, swept.n_W, aside.g);
  aside.h = (swept.distance - lag(scene, aside) - security_distance) / seconds;
  const auto slack = [&](const Row& of) { return of.h - of.g.dot(scene.own_qd); };
  if (slack(aside) > slack(row)) row = aside;
}

void against_obstacle(const DamperScene& scene, const Clearance& clearance, Row& row) {
  const Damper damper = scene.parameters.damper.against_others(scene.response(scene.geometry.self()));
  const world::ObstacleState& state = scene.obstacles[clearance.other];
  const double approach = -clearance.n_W.dot(state.velocity.at(clearance.p_other_W, state.X_WO.translation()));
  const double distance = least_distance({.distance = clearance.distance - lag(scene, row),
                                          .age = state.age,
                                          .other_acceleration = scene.parameters.acceleration_of_obstacles});
  keep(scene, damper, distance, 1.0, approach, row);
  if (approach > 0.0 && scene.distances != nullptr) allow_passing(scene, clearance, damper.security_distance, row);
}

}  // namespace

// [Lahouar06] eq. 4, after [Faverjon87]:
//
//     ḋ ≥ −f(d − dₛ),   f(x) = ξ x/(dᵢ − dₛ) within dᵢ
//
// differs from paper: eq. 4–9 are printed with dᵢ and dₛ exchanged, which would let bodies pass through each other.
// With n from the own body towards the other and v the velocities of the two nearest points:
//
//     obstacle    [Lahouar06] eq. 6    nᵀJ q̇            ≤ f(d − dₛ) + n·v_other
//     planned arm [Lahouar06] eq. 8    nᵀJ q̇            ≤ ½ f(d − dₛ)          the other arm keeps its half
//     own link                         nᵀ(J_a − J_b) q̇  ≤ f(d − dₛ)
//
// differs from paper: rows also hold beyond dᵢ as long as the arm can reach their bound within one period. An arm with
// bounded acceleration must brake before dᵢ, and braking alone can keep the continued f
// (docs/explanation/0001-braking.md). differs from paper: d is the least distance for the age of the state
// (docs/explanation/0006-latency-compensation.md).
Row velocity_damper(const DamperScene& scene, const Clearance& clearance) {
  Row row;
  row.key = pair_key(clearance);
  directional_jacobian(*scene.geometry.own_arm().model, scene.own, clearance.own_link, clearance.p_own_W, clearance.n_W,
                       row.g);
  switch (clearance.counterpart) {
    case Counterpart::kSelf:
      against_self(scene, clearance, row);
      break;
    case Counterpart::kArm:
      row.arm = clearance.other;
      against_arm(scene, clearance, row);
      break;
    case Counterpart::kObstacle:
      against_obstacle(scene, clearance, row);
      break;
  }
  return row;
}

}  // namespace hecaton::planner
