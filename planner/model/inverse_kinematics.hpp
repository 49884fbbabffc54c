#pragma once
/// Numerical inverse kinematics: damped least squares from several seeds.

#include <cstdint>
#include <functional>
#include <optional>

#include "planner/model/arm.hpp"

namespace hecaton::planner {

/// What of X_WT a solution must meet.
enum class IkTask {
  kPose,             ///< position and orientation; arms of fewer than 6 joints reach it only by luck
  kPosition,         ///< position alone
  kPositionAndAxis,  ///< position and the direction of the tool's z axis; its roll is free (5 joints suffice)
};

struct IkOptions {
  IkTask task = IkTask::kPose;
  int seeds = 32;                       ///< random restarts after the given start
  int iterations = 200;                 ///< per seed
  double position_tolerance = 1e-4;     ///< [m]
  double orientation_tolerance = 1e-3;  ///< [rad]; of the z axis's direction for kPositionAndAxis
  std::uint64_t random_seed = 1;
  /// A solution must also satisfy this (collision-free, conflicting, …); empty: any will do.
  std::function<bool(const JointVector&)> accept;
};

/// Joint positions within the limits that bring the tool frame T to X_WT, nearest to `start` first tried; nothing when
/// no seed converges. Deterministic for a random_seed.
[[nodiscard]] std::optional<JointVector> inverse_kinematics(const Arm& arm, const Pose& X_WT, const JointVector& start,
                                                            const IkOptions& options = {});

}  // namespace hecaton::planner
