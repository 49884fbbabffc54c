#pragma once
/// What of a cell can matter to an arm in its next period, brought forward to now, and how near it must be to matter.

#include <span>
#include <vector>

#include "planner/collision/pass_input.hpp"
#include "planner/local/velocity_damper.hpp"
#include "planner/model/kinematics_kernels.hpp"
#include "planner/tick.hpp"

namespace hecaton::planner {

/// Storage is reused from tick to tick; nothing but rebuild() allocates. Its parts point at each other: it stays where
/// it is.
class LocalScene {
 public:
  explicit LocalScene(const CellGeometry& geometry);
  LocalScene(const LocalScene&) = delete;
  LocalScene& operator=(const LocalScene&) = delete;
  /// After CellGeometry::set_obstacles. Allocates.
  void rebuild(const CellGeometry& geometry);

  /// Looks from the arm at `input` whose joints get no faster than `fastest` [rad/s | m/s] in the next period. Valid
  /// until the next look, as long as the input lives.
  void update(const CellGeometry& geometry, const LocalParameters& parameters, const TickInput& input,
              const JointVector& fastest);

  [[nodiscard]] CellPoses poses() const { return {&own_, arms_, obstacles_now_}; }
  /// Pairs that are farther apart cannot make a row that binds.
  [[nodiscard]] InfluenceDistances influence() const;
  /// `distances`: that of the cell, for what obstacles sweep.
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

  // Of the cell, whatever its arms do.
  std::vector<double> gap_to_arm_;                      ///< the least distance to each arm, wherever both are [m]
  std::vector<double> lever_;                           ///< no point of it is farther from a joint's axis [m]
  std::vector<double> acceleration_;                    ///< nor gets faster than this in a second [m/s²]
  std::vector<double> stop_times_;                      ///< against each arm: the longer of both arms' longest stop [s]
  double longest_stop_ = 0.0;                           ///< of any arm [s]
  double fastest_other_ = 0.0;                          ///< no point of any arm moves faster [m/s]
  double strongest_other_ = 0.0;                        ///< nor gets faster in a second [m/s²]
  std::vector<std::vector<CarriedBall>> balls_of_arm_;  ///< around each body of each arm, the own one included
  std::vector<std::vector<JointVector>> levers_;        ///< of each body of each arm: longest_levers()
  std::vector<double> radius_of_obstacle_;              ///< no point is farther from its origin [m]

  // Now.
  Kinematics own_;
  std::vector<double> own_speed_;  ///< of each own body's fastest point in the next period, at most [m/s]
  double own_fastest_ = 0.0;       ///< the largest of them [m/s]
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
