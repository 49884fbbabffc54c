#pragma once
/// What the world (Bullet) needs to know of a cell's arms.

#include <vector>

#include "planner/model/arm.hpp"
#include "planner/model/kinematics.hpp"
#include "world/sim/bullet_world.hpp"

namespace hecaton::planner {

/// The arm's shapes, self pairs and grasp links, as the contact monitor judges them.
[[nodiscard]] world::ArmBodies arm_bodies(const Arm& arm);

/// Moves arm `index` of the world to the measured configuration q. `scratch` is overwritten.
void set_measured(world::BulletWorld& world, int index, const Arm& arm, const JointVector& q, Kinematics& scratch);

}  // namespace hecaton::planner
