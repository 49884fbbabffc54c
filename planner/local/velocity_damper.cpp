#include "planner/local/velocity_damper.hpp"

namespace hecaton::planner {
namespace {

std::uint32_t pair_key(const Clearance& c) {
  return static_cast<std::uint32_t>(c.counterpart) << 28 | (static_cast<std::uint32_t>(c.other) & 0x3FF) << 18 |
         (static_cast<std::uint32_t>(c.other_body) & 0x1FF) << 9 | (static_cast<std::uint32_t>(c.own_body) & 0x1FF);
}

}  // namespace

// [Lahouar06] eq. 4, after [Faverjon87]:   ḋ ≥ −ξ (d − dₛ)/(dᵢ − dₛ)
// differs from paper: eq. 4–9 are printed with dᵢ and dₛ exchanged, which would let bodies pass through each other.
double damper_speed(double d, double security_distance, double influence_distance, double xi) {
  return xi * (d - security_distance) / (influence_distance - security_distance);
}

// With n from the own body towards the other and v the velocities of the two nearest points:
//   own arm     [Lahouar06] eq. 6    nᵀJ q̇            ≤ ξ (d − dₛ)/(dᵢ − dₛ) + n·v_other
//   planned arm [Lahouar06] eq. 8    nᵀJ q̇            ≤ ξ/2 (d − dₛ)/(dᵢ − dₛ)          the other does its half
//   own link                         nᵀ(J_a − J_b) q̇  ≤ ξ (d − dₛ)/(dᵢ − dₛ)
// differs from paper: the rows are not dropped beyond dᵢ but hold as long as the arm can reach their bound within one
// period. An arm with bounded acceleration must begin to brake earlier than dᵢ, and the same line tells when: with
// k = ξ/(dᵢ − dₛ) ≤ 1/T it can be kept by braking alone (docs/design/0001-braking.md).
Row velocity_damper(const DamperScene& scene, const Clearance& clearance) {
  const RobotModel& model = *scene.geometry.own_arm().model;
  const DamperParameters& p = scene.parameters;
  Row row;
  row.key = pair_key(clearance);
  directional_jacobian(model, scene.own, clearance.own_link, clearance.p_own_W, clearance.n_W, row.g);

  switch (clearance.counterpart) {
    case Counterpart::kSelf: {
      JointVector other;
      directional_jacobian(model, scene.own, clearance.other_link, clearance.p_other_W, clearance.n_W, other);
      row.g -= other;
      row.h =
          damper_speed(clearance.distance, p.self_security_distance, p.self_influence_distance, p.convergence_speed);
      row.influences = clearance.distance < p.self_influence_distance;
      return row;
    }
    case Counterpart::kArm: {
      const ArmObservation& other = scene.observations[clearance.other];
      const double margin = scene.arm_margins[clearance.other];
      const double security = p.security_distance + margin;
      const double influence = p.influence_distance + margin;
      row.influences = clearance.distance < influence;
      if (other.plans) {
        row.h = damper_speed(clearance.distance, security, influence, 0.5 * p.convergence_speed);
      } else {
        const Eigen::Vector3d v_W =
            point_velocity(*scene.geometry.arms()[clearance.other].model, scene.arms[clearance.other],
                           clearance.other_link, clearance.p_other_W, other.qd);
        row.h = damper_speed(clearance.distance, security, influence, p.convergence_speed) + clearance.n_W.dot(v_W);
      }
      return row;
    }
    case Counterpart::kObstacle: {
      const world::ObstacleState& state = scene.obstacles[clearance.other];
      const Eigen::Vector3d v_W = state.velocity.at(clearance.p_other_W, state.X_WO.translation());
      row.h = damper_speed(clearance.distance, p.security_distance, p.influence_distance, p.convergence_speed) +
              clearance.n_W.dot(v_W);
      row.influences = clearance.distance < p.influence_distance;
      return row;
    }
  }
  return row;
}

}  // namespace hecaton::planner
