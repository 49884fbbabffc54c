#pragma once
/// Numerical inverse kinematics: damped least squares from several seeds.

#include <cstdint>
#include <functional>
#include <optional>
#include <random>

#include "planner/model/arm.hpp"

namespace hecaton::planner {

/// The part of X_WT that a solution must meet.
enum class IkTask {
  kPose,             ///< position and orientation; with fewer than 6 joints most poses have no solution
  kPosition,         ///< position alone
  kPositionAndAxis,  ///< position and direction of the tool's z axis; the roll is free (5 joints suffice)
};

struct IkOptions {
  IkTask task = IkTask::kPose;
  int seeds = 32;                       ///< random restarts after the given start
  int iterations = 200;                 ///< per seed
  double position_tolerance = 1e-4;     ///< [m]
  double orientation_tolerance = 1e-3;  ///< [rad]; for kPositionAndAxis of the z axis
  std::uint64_t random_seed = 1;
  /// A further condition on solutions, such as no collision; empty: none.
  std::function<bool(const JointVector&)> accept;
};

/// Joint positions within the limits that bring the tool frame T to X_WT. The search begins at `start`, then at random
/// configurations; revolute joints are unwound towards `start`. Empty when no seed converges. Deterministic for a
/// random_seed.
[[nodiscard]] std::optional<JointVector> inverse_kinematics(const Arm& arm, const Pose& X_WT, const JointVector& start,
                                                            const IkOptions& options = {});

/// A random configuration within the limits; joints without limits are within ±π. The same on every platform.
[[nodiscard]] JointVector random_configuration(const JointLimits& limits, std::mt19937_64& random);

}  // namespace hecaton::planner
