#include "planner/simulation/velocity_reversals.hpp"

#include <cmath>

namespace hecaton::planner {

void ReversalCounter::add(const JointVector& qd, const JointLimits& limits, bool near, double dt) {
  for (int j = 0; j < static_cast<int>(qd.size()); ++j) {
    Joint& joint = joints_[j];
    if (!near) {
      joint = {};
      continue;
    }
    total_.joint_time += dt;
    joint.since_turn += dt;
    if (std::abs(qd[j]) <= kStillShare * limits.velocity[j]) continue;
    const int sign = qd[j] > 0.0 ? 1 : -1;
    if (joint.sign == -sign) {
      ++total_.turns;
      if (joint.since_turn < kQuick) ++total_.quick;
      joint.since_turn = 0.0;
    }
    joint.sign = sign;
  }
}

}  // namespace hecaton::planner
