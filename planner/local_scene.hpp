#pragma once
/// The bodies that can constrain an arm in its next period, at their expected present positions.

#include <span>
#include <vector>

#include "planner/collision/pass_input.hpp"
#include "planner/local/velocity_damper.hpp"
#include "planner/model/kinematics_kernels.hpp"
#include "planner/tick.hpp"

namespace hecaton::planner {

/// Bounds for every body how near it must be to constrain the arm, so that the distance pass can skip far bodies. Only
/// the constructor and rebuild() allocate. Members point at each other: neither copied nor moved. Not thread-safe.
class LocalScene {
 public:
  explicit LocalScene(const CellGeometry& geometry);
  LocalScene(const LocalScene&) = delete;
  LocalScene& operator=(const LocalScene&) = delete;
  /// Call after CellGeometry::set_obstacles. Allocates.
  void rebuild(const CellGeometry& geometry);

  /// Updates the scene to `input`. `fastest`: bound of the joint velocities in the next period [rad/s | m/s]. The other
  /// functions refer to the last update and to its input, which must stay alive.
  void update(const CellGeometry& geometry, const LocalParameters& parameters, const TickInput& input,
              const JointVector& fastest);

  [[nodiscard]] CellPoses poses() const { return {&own_, arms_, obstacles_now_}; }
  /// Pairs beyond these distances cannot make a binding row.
  [[nodiscard]] InfluenceDistances influence() const;
  /// `distances`: of the cell; measures the volumes that obstacles sweep.
  [[nodiscard]] DamperScene scene(const CellGeometry& geometry, const LocalParameters& parameters,
                                  const TickInput& input, const ExactDistance& distances) const;

 private:
  void update_self(const CellGeometry& geometry, const LocalParameters& parameters, const TickInput& input,
                   const JointVector& fastest);
  void update_arms(const CellGeometry& geometry, const LocalParameters& parameters, const TickInput& input);
  void update_obstacles(const CellGeometry& geometry, const LocalParameters& parameters, const TickInput& input);
  [[nodiscard]] bool may_matter(const CellGeometry& geometry, const LocalParameters& parameters, int arm,
                                const ArmObservation& other, double dt) const;
  double update_body_uncertainty(int arm, const JointVector& position_uncertainty);
  [[nodiscard]] double farthest_influence(const LocalParameters& parameters, double dt) const;

  // Constant bounds of the cell, valid in every configuration.
  std::vector<double> gap_to_arm_;    ///< least distance to each arm [m]
  std::vector<double> lever_;         ///< of each arm: largest distance of a point from a joint axis [m]
  std::vector<double> acceleration_;  ///< of each arm: largest acceleration of a point [m/s²]
  std::vector<double> stop_times_;    ///< for each arm: the longer of its and the own longest stop [s]
  double longest_stop_ = 0.0;         ///< of any arm [s]
  double fastest_other_ = 0.0;        ///< largest velocity of a point of any arm [m/s]
  double strongest_other_ = 0.0;      ///< largest acceleration of a point of any arm [m/s²]
  std::vector<std::vector<CarriedBall>> balls_of_arm_;  ///< around each body of each arm, the own one included
  std::vector<std::vector<JointVector>> levers_;        ///< longest_levers() of each body of each arm
  std::vector<double> radius_of_obstacle_;              ///< largest distance of a point from the obstacle's origin [m]

  // Present period.
  Kinematics own_;
  std::vector<double> own_speed_;  ///< bound of the speed of each own body's points in the next period [m/s]
  double own_fastest_ = 0.0;       ///< largest of them [m/s]
  Reach reach_of_self_;
  std::vector<Kinematics> arms_;
  std::vector<int> near_arms_;                         ///< those that can matter, ascending
  std::vector<ArmObservation> observations_;           ///< extrapolated
  std::vector<Reach> reach_of_arm_;                    ///< how near each arm must be to matter
  std::vector<std::vector<double>> body_uncertainty_;  ///< of the bodies of lost arms, from where they are placed [m]
  std::vector<world::ObstacleState> extrapolated_;
  std::span<const world::ObstacleState> obstacles_now_;
  std::vector<Reach> reach_of_obstacle_;  ///< of each, or once for all that are alike
  std::size_t obstacle_reaches_ = 0;
};

}  // namespace hecaton::planner
