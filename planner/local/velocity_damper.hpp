#pragma once
/// The velocity damper: how fast a pair of bodies may approach, as a row g · q̇ ≤ h for the own arm.

#include <span>
#include <vector>

#include "planner/collision/exact_distance.hpp"
#include "planner/local/observation.hpp"
#include "planner/local/parameters.hpp"
#include "planner/local/velocity_constraints.hpp"

namespace hecaton::planner {

/// What a clearance's row depends on besides the clearance itself.
struct DamperScene {
  const CellGeometry& geometry;
  const Kinematics& own;                            ///< of the own arm at its reference position
  const JointVector& own_qd;                        ///< its reference velocity [rad/s | m/s]
  const JointVector& tracking_error;                ///< measured minus reference position [rad | m]; empty: none
  std::span<const Kinematics> arms;                 ///< of every arm of the cell, extrapolated to now
  std::span<const ArmObservation> observations;     ///< of every arm of the cell, extrapolated to now
  std::span<const double> stop_times;               ///< the longer of the own arm's and arm i's longest stop [s]
  std::span<const world::ObstacleState> obstacles;  ///< extrapolated to now
  double dt;                                        ///< control period [s]
  const LocalParameters& parameters;
  /// How far each body of each arm may be from where it is placed [m]; read for arms that were lost.
  std::span<const std::vector<double>> body_uncertainty = {};
  /// Measures what obstacles sweep; none: each counts as if it came straight on.
  const ExactDistance* distances = nullptr;

  /// Of the own arm together with arm i: one period until they react, then the stop [s].
  [[nodiscard]] double response(int arm) const { return dt + stop_times[arm]; }
};

[[nodiscard]] Row velocity_damper(const DamperScene& scene, const Clearance& clearance);

}  // namespace hecaton::planner
