#pragma once
/// How far an arm can reach, from the lengths between its joints alone.

#include <vector>

#include "planner/model/arm.hpp"

namespace hecaton::planner {

/// No frame of link i is ever farther than `links[i]` from `centre`, whatever the joints do (within limits, if they
/// shift it).
struct ArmReach {
  Eigen::Vector3d centre;     ///< the first joint's origin, in W [m]
  std::vector<double> links;  ///< by index into RobotModel::links [m]
  double tool = 0.0;          ///< of the tool's frame T [m]
};

[[nodiscard]] ArmReach arm_reach(const Arm& arm);

}  // namespace hecaton::planner
