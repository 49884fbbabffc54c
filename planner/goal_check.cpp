#include "planner/goal_check.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <vector>

#include "planner/collision/exact_distance.hpp"

namespace hecaton::planner {
namespace {

/// Limit for joints without limits [rad]: larger angles lose precision within one turn.
constexpr double kFarthest = 1e4;

std::optional<Rejection> outside_limits(const Arm& arm, const JointVector& q) {
  for (int j = 0; j < arm.model->joints(); ++j) {
    const std::string& joint = arm.model->joint_names[j];
    std::ostringstream out;
    if (!std::isfinite(q[j])) {
      out << "joint " << joint << " = " << q[j] << " must be a finite number";
      return Rejection{RejectionKind::kMalformed, joint, out.str()};
    }
    const double lower = std::max(arm.limits.lower[j], -kFarthest);
    const double upper = std::min(arm.limits.upper[j], kFarthest);
    if (q[j] < lower || q[j] > upper) {
      out << "joint " << joint << " = " << q[j] << " must be within " << lower << " … " << upper;
      return Rejection{RejectionKind::kOutsideLimits, joint, out.str()};
    }
  }
  return std::nullopt;
}

}  // namespace

std::optional<Rejection> reject_goal(const CellGeometry& geometry, const JointVector& q_goal,
                                     std::span<const world::ObstacleState> obstacles) {
  const Arm& arm = geometry.own_arm();
  std::ostringstream out;
  if (q_goal.size() != arm.model->joints()) {
    out << "goal has " << q_goal.size() << " joint values, arm " << arm.name << " has " << arm.model->joints()
        << " joints";
    return Rejection{RejectionKind::kMalformed, arm.name, out.str()};
  }
  if (auto rejection = outside_limits(arm, q_goal)) return rejection;

  // Other arms will move, but their bases stay.
  const CellGeometry lasting = geometry.without_moving_others();
  ExactDistance distance(lasting);
  std::vector<Kinematics> arms(lasting.arms().size());
  for (std::size_t i = 0; i < arms.size(); ++i) {
    const Arm& other = lasting.arms()[i];
    forward_kinematics(*other.model, other.X_WB, JointVector::Zero(other.model->joints()), arms[i]);
  }
  Kinematics own;
  forward_kinematics(*arm.model, arm.X_WB, q_goal, own);
  std::vector<Clearance> touching(1);
  const int count = distance.clearances({&own, arms, obstacles}, {.others = 0.0, .self = 0.0}, touching);
  if (count == 0 || touching[0].distance > 0.0) return std::nullopt;
  const std::string other = lasting.other_name(touching[0]);
  out << "goal is in collision: " << lasting.own_name(touching[0]) << " and " << other << " overlap by "
      << -touching[0].distance * 1000.0 << " mm";
  return Rejection{RejectionKind::kInCollision, other, out.str()};
}

}  // namespace hecaton::planner
