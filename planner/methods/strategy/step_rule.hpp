#pragma once
/// The published on-line stage of motion strategies as an arm runs it.

#include <span>

#include "planner/methods/motion_method.hpp"
#include "planner/methods/strategy/strategy.hpp"

namespace hecaton::planner {

/// Where the arm goes now: the configuration that the last step of [Mediavilla02, section 4] led to; a new step is
/// taken where the arm is nearly there. A configuration is free if it is within limits, at least h from all arms and
/// obstacles as they are now, and clear of itself.
///
/// differs from paper: the arm does not jump there but moves, under dampers, velocity and acceleration limits; joints
/// that do not avoid go straight to the goal; and when what it goes to is no longer free, it decides anew from where it
/// is. `arms`: scratch, one per arm of the cell.
[[nodiscard]] JointVector step_way_point(const StrategyParameters& parameters, const MethodInput& input,
                                         const MethodScene& scene, std::span<Kinematics> arms, StrategyMemory& memory);

}  // namespace hecaton::planner
