#pragma once
/// What [Cardenas10, "Examples"] calls post-processing: a path without the vibrations and detours of its making.

#include <vector>

#include "planner/methods/potential_field/free_motion.hpp"

namespace hecaton::planner::potential {

/// The path with vertices left out, as long as what joins the others is free.
[[nodiscard]] std::vector<JointVector> shortcut(const std::vector<JointVector>& path, FreeMotion& motion);

/// Corners cut off, and what is left of them again, `times` times, where that is free: the rounder, the smoother.
[[nodiscard]] std::vector<JointVector> round_corners(std::vector<JointVector> path, FreeMotion& motion, int times);

/// Vertices at most `longest` apart as FreeMotion::sweep() measures it [m].
[[nodiscard]] std::vector<JointVector> resample(const std::vector<JointVector>& path, const FreeMotion& motion,
                                                double longest);

/// Shortcuts, from vertices ever closer to each other, then rounded corners. Same ends; every piece is free if every
/// piece of `path` is; never longer.
[[nodiscard]] std::vector<JointVector> refine(const std::vector<JointVector>& path, FreeMotion& motion);

/// Σ ‖q(i+1) − q(i)‖ [rad | m].
[[nodiscard]] double length(const std::vector<JointVector>& path);

}  // namespace hecaton::planner::potential
