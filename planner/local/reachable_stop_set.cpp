#include "planner/local/reachable_stop_set.hpp"

#include <algorithm>

#include "planner/model/kinematics.hpp"
#include "planner/model/reach.hpp"
#include "planner/trajectory/stop_profile.hpp"

namespace hecaton::planner {
namespace {

/// How far a joint gets in its positive direction at most [rad | m], from rate `v`: as fast as it can for `moved_for`,
/// then on a stop that takes `stop` [s].
double farthest(double v, double most, double acceleration, double moved_for, double stop) {
  const double fastest = std::min(most, v + acceleration * moved_for);
  const double speeding_up = (fastest - v) / acceleration;
  return 0.5 * (v + fastest) * speeding_up + fastest * (moved_for - speeding_up) + 0.5 * std::max(0.0, fastest) * stop;
}

}  // namespace

ReachableStopSet reachable_stop_set(const JointLimits& limits, const JointVector& q, const JointVector& qd,
                                    double moved_for) {
  // All joints brake together, as long as the one that needs longest.
  const JointVector fastest = (qd.cwiseAbs() + limits.acceleration * moved_for).cwiseMin(limits.velocity);
  const double stop = stop_time(limits, fastest);
  ReachableStopSet region{q, q};
  for (Eigen::Index j = 0; j < q.size(); ++j) {
    const double most = limits.velocity[j];
    const double v = std::clamp(qd[j], -most, most);
    const double a = limits.acceleration[j];
    const double up = std::min(limits.upper[j], q[j] + farthest(v, most, a, moved_for, stop));
    const double down = std::max(limits.lower[j], q[j] - farthest(-v, most, a, moved_for, stop));
    region.q[j] = 0.5 * (up + down);
    region.position_uncertainty[j] = std::max(0.0, 0.5 * (up - down));
  }
  return region;
}

// No point of a link is farther from the axis of a joint before it than the links between them are long altogether.
JointVector longest_levers(const Arm& arm, int link, double extent) {
  const RobotModel& model = *arm.model;
  const std::vector<double> along = arm_reach(arm).links;
  const int joints = joints_before(model, link);
  JointVector levers = JointVector::Zero(model.joints());
  for (std::size_t i = 0; i < model.links.size(); ++i) {
    const int joint = model.links[i].joint;
    if (joint < 0 || joint >= joints) continue;
    const bool shifts = model.links[i].joint_type == JointType::kPrismatic;
    levers[joint] = shifts ? 1.0 : along[link] - along[i] + extent;
  }
  return levers;
}

}  // namespace hecaton::planner
