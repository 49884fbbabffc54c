#pragma once
/// Numerical inverse kinematics: damped least squares from several seeds.

#include <cstdint>
#include <functional>
#include <optional>
#include <random>

#include "planner/model/arm.hpp"
#include "planner/model/tool_goal.hpp"

namespace hecaton::planner {

struct IkOptions {
  /// The part of the orientation that a solution need not meet. With fewer than 6 joints most poses have no solution
  /// unless some rotation is free.
  FreeRotation free_rotation = FreeRotation::kNone;
  int seeds = 32;                       ///< random restarts after the given start
  int iterations = 200;                 ///< per seed
  double position_tolerance = 1e-4;     ///< [m]
  double orientation_tolerance = 1e-3;  ///< without the free rotation [rad]
  std::uint64_t random_seed = 1;
  /// A further condition on solutions, such as no collision; empty: none.
  std::function<bool(const JointVector&)> accept;
};

/// Joint positions within the limits that bring the tool frame T to X_WT. The search begins at `start`, then at random
/// configurations; joints that turn are unwound towards `start`. Empty when no seed converges. Deterministic for a
/// random_seed.
[[nodiscard]] std::optional<JointVector> inverse_kinematics(const Arm& arm, const Pose& X_WT, const JointVector& start,
                                                            const IkOptions& options = {});

/// A configuration that meets a position, and its orientation.
struct NearestOrientation {
  JointVector q;                 ///< [rad | m]
  Pose X_WT = Pose::Identity();  ///< tool frame at q
  double angle = 0.0;            ///< from the wanted orientation, without the free rotation [rad]
};

/// The accepted configuration within the limits that meets the position of X_WT and has the nearest orientation to it.
/// A local search from `start` and from random configurations: a nearer orientation may exist. Empty when no accepted
/// configuration meets the position. Ignores options.orientation_tolerance. Deterministic for a random_seed.
[[nodiscard]] std::optional<NearestOrientation> nearest_orientation(const Arm& arm, const Pose& X_WT,
                                                                    const JointVector& start,
                                                                    const IkOptions& options = {});

/// A configuration and the pose of its tool.
struct NearestPose {
  JointVector q;                 ///< [rad | m]
  Pose X_WT = Pose::Identity();  ///< tool frame at q
  ToolError error;               ///< from the wanted pose; orientation without the free rotation
};

/// The configuration within the limits with the locally nearest tool pose to X_WT, where 1 rad counts as 0.3 m. It
/// searches from `start` alone and so follows a pose that moves without a leap; elsewhere a nearer pose may exist.
/// Ignores the seeds and `accept` of the options. Deterministic.
[[nodiscard]] NearestPose nearest_pose(const Arm& arm, const Pose& X_WT, const JointVector& start,
                                       const IkOptions& options = {});

/// True for an arm whose tool stays on a surface or a line, such as one of two joints or a planar one. Nearly no point
/// of a volume lies on it. Samples postures, always the same ones.
[[nodiscard]] bool tool_stays_on_surface(const Arm& arm);

/// A random configuration within the limits; joints without limits are within ±π. The same on every platform.
[[nodiscard]] JointVector random_configuration(const JointLimits& limits, std::mt19937_64& random);

}  // namespace hecaton::planner
