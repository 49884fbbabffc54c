#pragma once
/// Compares the kinematics that a controller reports with those of the robot description. Pure.

#include <optional>

#include "services/arm_driver/devices/universal_robots/primary.hpp"

namespace hecaton::planner {
struct RobotModel;
}

namespace hecaton::device::universal_robots {

/// The largest distance between the flanges of both robots in some postures [m], finite. Both are laid on each other at
/// the shoulder, and have the controller's flange on the last axis: a description may have a mount below the robot, and
/// any tool. So the height of the shoulder, and the length from the wrist to the flange, do not count. Empty: the
/// description is not of six joints that turn.
[[nodiscard]] std::optional<double> flange_difference(const DhParameters& robot, const planner::RobotModel& model);

/// The larger difference of two lengths that flange_difference() leaves out [m]: of the shoulder's height above
/// `base_link`, and from the wrist to `tool0`. Frames of ROS have these names, also with a prefix. A length counts if
/// its frame is on the axis, and the difference at most `most`. Else it contains a mount or a tool. Empty: none
/// counts. The zeros of joints 1 and 6 turn the arm's base and its tool: their places in the cell contain them.
/// Precondition: flange_difference() is not empty.
[[nodiscard]] std::optional<double> length_difference(const DhParameters& robot, const planner::RobotModel& model,
                                                      double most);

}  // namespace hecaton::device::universal_robots
