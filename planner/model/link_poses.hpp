#pragma once
/// Where an arm's links are, for those who do not ask how its joints move them.

#include "planner/model/kinematics.hpp"

namespace hecaton::planner {

/// What forward_kinematics does, of it only links, joints and X_WL.
void place_links(const RobotModel& model, const Pose& X_WB, const JointVector& q, Kinematics& out);

}  // namespace hecaton::planner
