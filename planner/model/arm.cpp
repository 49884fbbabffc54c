#include "planner/model/arm.hpp"

#include "planner/model/kinematics.hpp"

namespace hecaton::planner {

// The first joint's origin never moves. Around it, the longest arm is the stretched one: the links' lengths add up.
ArmReach arm_reach(const Arm& arm) {
  const RobotModel& model = *arm.model;
  Kinematics at_zero;
  forward_kinematics(model, arm.X_WB, JointVector::Zero(model.joints()), at_zero);
  ArmReach reach;
  reach.centre = model.joints() > 0 ? at_zero.origin_W[0] : arm.X_WB.translation();
  reach.links.assign(model.links.size(), 0.0);
  for (std::size_t i = 0; i < model.links.size(); ++i) {
    const Link& link = model.links[i];
    const int axes = axes_before(model, static_cast<int>(i));
    if (axes == 0) {
      reach.links[i] = (at_zero.X_WL[i].translation() - reach.centre).norm();
      continue;
    }
    const bool is_first = axes == 1 && link.joint >= 0;
    reach.links[i] = is_first ? 0.0 : reach.links[link.parent] + link.X_PJ.translation().norm();
    if (link.joint >= 0 && link.joint_type == JointType::kPrismatic) {
      reach.links[i] += largest_position(link, arm.limits);
    }
  }
  reach.tool = reach.links[model.tool_link] + model.X_LT.translation().norm();
  return reach;
}

}  // namespace hecaton::planner
