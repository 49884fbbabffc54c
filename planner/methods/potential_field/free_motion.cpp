#include "planner/methods/potential_field/free_motion.hpp"

#include <algorithm>

namespace hecaton::planner::potential {
namespace {

/// Bound of the speed of any point of the arm per unit rate of each joint. For a joint that turns it is the distance
/// from its axis to the farthest point of the bodies after it. Prismatic joints count at their limit.
JointVector levers(const CellGeometry& geometry) {
  const Arm& arm = geometry.own_arm();
  const RobotModel& model = *arm.model;
  JointVector lever = JointVector::Zero(model.joints());
  for (const Body& body : geometry.own_bodies()) {
    double reach = body.bound.centre.norm() + body.bound.radius;
    JointVector of_body = JointVector::Zero(model.joints());
    for (int link = body.link; link >= 0; link = model.links[link].parent) {
      const Link& at = model.links[link];
      if (at.joint >= 0) {
        const bool shifts = at.joint_type == JointType::kPrismatic;
        of_body[at.joint] += std::abs(at.multiplier) * (shifts ? 1.0 : reach);
        if (shifts) reach += largest_position(at, arm.limits);
      }
      reach += at.X_PJ.translation().norm();
    }
    lever = lever.cwiseMax(of_body);
  }
  return lever;
}

}  // namespace

FreeMotion::FreeMotion(const CellGeometry& geometry, std::span<const world::ObstacleState> obstacles,
                       std::span<const JointVector> others, double margin)
    : arm_(geometry.own_arm()),
      distance_(geometry),
      obstacles_(obstacles.begin(), obstacles.end()),
      arms_(geometry.arms().size()),
      nearest_(64),
      lever_(levers(geometry)),
      margin_(margin) {
  for (std::size_t i = 0; i < others.size(); ++i) {
    const Arm& other = geometry.arms()[i];
    if (static_cast<int>(i) != geometry.self()) forward_kinematics(*other.model, other.X_WB, others[i], arms_[i]);
  }
}

CellPoses FreeMotion::poses(const JointVector& q) {
  forward_kinematics(*arm_.model, arm_.X_WB, q, own_);
  return {&own_, arms_, obstacles_};
}

double FreeMotion::free_distance(const JointVector& q, double most) {
  const int count = distance_.clearances(poses(q), {.others = margin_ + most, .self = most}, nearest_);
  double least = most;
  for (int i = 0; i < count; ++i) {
    const double kept = nearest_[i].counterpart == Counterpart::kSelf ? 0.0 : margin_;
    least = std::min(least, nearest_[i].distance - kept);
  }
  return least;
}

// Distances shrink by at most the swept bound: with a margin of r, the next motion of length r is free.
bool FreeMotion::free(const JointVector& from, const JointVector& to) {
  const JointVector way = to - from;
  const double length = sweep(way);
  if (!free(to)) return false;
  for (double gone = 0.0;;) {
    const JointVector q = length > 0.0 ? JointVector(from + gone / length * way) : from;
    const double step = free_distance(q, std::max(length - gone, 2.0 * kTolerance));
    if (step <= kTolerance) return false;
    gone += step;
    if (gone >= length) return true;
  }
}

}  // namespace hecaton::planner::potential
