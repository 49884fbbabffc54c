#pragma once
/// The velocity damper: how fast a pair of bodies may approach, as a row g · q̇ ≤ h for the own arm.

#include <span>

#include "planner/collision/cell_geometry.hpp"
#include "planner/local/observation.hpp"
#include "planner/local/parameters.hpp"
#include "planner/local/row.hpp"

namespace hecaton::planner {

/// Allowed approach speed [m/s] at distance d: ξ (d − dₛ)/(dᵢ − dₛ); zero at dₛ, negative (retreat) below.
[[nodiscard]] double damper_speed(double d, double security_distance, double influence_distance, double xi);

/// What a clearance's row depends on besides the clearance itself.
struct DamperScene {
  const CellGeometry& geometry;
  const Kinematics& own;                         ///< of the own arm at its reference position
  std::span<const Kinematics> arms;              ///< of every arm of the cell, extrapolated to now
  std::span<const ArmObservation> observations;  ///< of every arm of the cell
  std::span<const world::ObstacleState> obstacles;
  std::span<const double> arm_margins;  ///< added to dₛ and dᵢ against arm i [m]
  const DamperParameters& parameters;
};

[[nodiscard]] Row velocity_damper(const DamperScene& scene, const Clearance& clearance);

}  // namespace hecaton::planner
