#pragma once
/// The way of a tool along the points that a planner publishes.

#include <vector>

#include <Eigen/Core>

#include "planner/model/arm.hpp"
#include "world/model/scene.hpp"

namespace hecaton::messages {

/// The points of a field of PlannedMotion [rad | m]. Empty: one is not usable.
[[nodiscard]] std::vector<planner::JointVector> points_of(const std::vector<double>& values, int joints);

/// Where the tool of an arm is at q, in W.
[[nodiscard]] world::Pose tool_at(const planner::Arm& arm, const planner::JointVector& q);

/// Positions in W of the tool while the joints move from `q` straight from point to point [m]. Empty without points.
[[nodiscard]] std::vector<Eigen::Vector3d> tool_way(const planner::Arm& arm, planner::JointVector q,
                                                    const std::vector<planner::JointVector>& points);

}  // namespace hecaton::messages
