#pragma once
/// An arm in the simulated world: its bodies, its measured pose, and the readings of its distance sensors.

#include <cstdint>
#include <span>
#include <vector>

#include "planner/cell.hpp"
#include "planner/local/random.hpp"
#include "planner/model/kinematics.hpp"
#include "world/sim/bullet_world.hpp"
#include "world/sim/ray_caster.hpp"

namespace hecaton::planner {

/// Shapes, self pairs and grasp links of `arm`.
[[nodiscard]] world::ArmBodies arm_bodies(const Arm& arm);

/// The same with the shapes that joints outside the chain move as they are, each on a link of its own behind those of
/// the model.
[[nodiscard]] world::ArmBodies live_arm_bodies(const Arm& arm);

/// Moves arm `index` of the world to the measured configuration q [rad | m]. Overwrites `scratch`.
void set_measured(world::BulletWorld& world, int index, const Arm& arm, const JointVector& q, Kinematics& scratch);
/// The same for live_arm_bodies(). `outside`: positions of the joints outside the chain [rad | m].
void set_measured(world::BulletWorld& world, int index, const Arm& arm, const JointVector& q,
                  const std::vector<double>& outside, Kinematics& scratch);

/// Simulates the distance sensors of one arm by ray casts from its measured pose. Not thread-safe.
class RangeScanner {
 public:
  /// `arm` must outlive the scanner. `seed`: of the sensors' noise.
  RangeScanner(const PlannedArm& arm, std::uint64_t seed);

  /// Scans of all sensors that are due at `now` [s], with the arm at `q`. All are due at the first call.
  [[nodiscard]] std::vector<RangeScan> scan(double now, const JointVector& q, const world::RayCaster& caster);

 private:
  [[nodiscard]] RangeReading read(const RangeSensor& sensor, const SensorRay& ray, const world::RayCaster& caster);

  const PlannedArm& arm_;
  Random random_;
  std::vector<double> due_;  ///< of each sensor [s]
  Kinematics kinematics_;
};

}  // namespace hecaton::planner
