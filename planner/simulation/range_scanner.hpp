#pragma once
/// The simulated distance sensors of one arm: beams cast into the world from where the arm was measured.

#include <cstdint>
#include <span>
#include <vector>

#include "planner/cell.hpp"
#include "planner/local/random.hpp"
#include "planner/model/kinematics.hpp"
#include "world/sim/ray_caster.hpp"

namespace hecaton::planner {

class RangeScanner {
 public:
  /// `arm` must outlive it. `seed` of the sensors' noise.
  RangeScanner(const PlannedArm& arm, std::uint64_t seed);

  /// What the sensors measure that are due at `now` [s], with the arm at `q`. At the first call all are due.
  [[nodiscard]] std::vector<RangeScan> scan(double now, const JointVector& q, const world::RayCaster& caster,
                                            std::span<const world::ObstacleState> obstacles);

 private:
  [[nodiscard]] RangeReading read(const RangeSensor& sensor, const SensorRay& ray, const world::RayCaster& caster,
                                  std::span<const world::ObstacleState> obstacles);

  const PlannedArm& arm_;
  Random random_;
  std::vector<double> due_;  ///< of each sensor [s]
  Kinematics kinematics_;
};

}  // namespace hecaton::planner
