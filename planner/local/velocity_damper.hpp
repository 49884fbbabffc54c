#pragma once
/// The velocity damper of a pair of bodies as a row g · q̇ ≤ h for the own arm [Lahouar06, eq. 4–9].

#include <span>
#include <vector>

#include "planner/collision/exact_distance.hpp"
#include "planner/local/observation.hpp"
#include "planner/local/parameters.hpp"
#include "planner/local/velocity_constraints.hpp"

namespace hecaton::planner {

/// Everything that a row depends on besides its clearance. References are valid during the call.
struct DamperScene {
  const CellGeometry& geometry;
  const Kinematics& own;                            ///< of the own arm at its reference position
  const JointVector& own_qd;                        ///< its reference velocity [rad/s | m/s]
  const JointVector& tracking_error;                ///< measured minus reference position [rad | m]; empty: none
  std::span<const Kinematics> arms;                 ///< of every arm of the cell, extrapolated to now
  std::span<const ArmObservation> observations;     ///< of every arm of the cell, extrapolated to now
  std::span<const double> stop_times;               ///< for arm i: the longer of its and the own longest stop [s]
  std::span<const world::ObstacleState> obstacles;  ///< extrapolated to now
  double dt;                                        ///< control period [s]
  const LocalParameters& parameters;
  /// Bound of each body's distance from its nominal position, for lost arms [m].
  std::span<const std::vector<double>> body_uncertainty = {};
  /// Measures the volumes that obstacles sweep; null: every obstacle counts as approaching.
  const ExactDistance* distances = nullptr;

  /// Response time of the own arm and arm i: one period until they react, then the stop [s].
  [[nodiscard]] double response(int arm) const { return dt + stop_times[arm]; }
};

/// The row of one clearance. Pure; no allocation.
[[nodiscard]] Row velocity_damper(const DamperScene& scene, const Clearance& clearance);

}  // namespace hecaton::planner
