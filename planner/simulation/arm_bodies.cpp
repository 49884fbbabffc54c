#include "planner/simulation/arm_bodies.hpp"

#include "planner/collision/cell_geometry.hpp"

namespace hecaton::planner {

world::ArmBodies arm_bodies(const Arm& arm) {
  world::ArmBodies bodies;
  bodies.name = arm.name;
  for (const LinkGeometry& geometry : arm.model->geometry) {
    bodies.parts.push_back({geometry.link,
                            arm.model->links[geometry.link].name,
                            {geometry.shape, geometry.X_LS},
                            joints_before(*arm.model, geometry.link) > 0});
  }
  bodies.self_pairs = arm.model->self_pairs;
  bodies.grasp_links = grasp_links(*arm.model);
  return bodies;
}

void set_measured(world::BulletWorld& world, int index, const Arm& arm, const JointVector& q, Kinematics& scratch) {
  forward_kinematics(*arm.model, arm.X_WB, q, scratch);
  world.set_arm(index, std::span<const Pose>(scratch.X_WL).first(scratch.links), scratch.X_WT);
}

}  // namespace hecaton::planner
