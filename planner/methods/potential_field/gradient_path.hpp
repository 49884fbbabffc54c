#pragma once
/// A path down the gradient of a potential field [Cardenas10, fig. 4], and its post-processing.

#include <vector>

#include "planner/methods/potential_field/free_motion.hpp"
#include "planner/methods/potential_field/potential_field.hpp"

namespace hecaton::planner::potential {

enum class DescentOutcome : std::uint8_t {
  kReached,       ///< the path ends at the goal
  kLocalMinimum,  ///< it ends where the gradient vanishes, or nothing but walls lies downhill
  kOscillating,   ///< it ends where steps go back and forth
  kOutOfSteps,
  kStartBlocked,  ///< the start is in collision, or nearer to one than the margin: no path
  kGoalBlocked,   ///< so is the goal: no path
};

struct DescentOptions {
  /// α of every step along −∇U, as published: "must be sufficiently small". 0: along steepest_descent(), as far as the
  /// potential allows it (Armijo).
  double alpha = 0.0;
  double longest_step = 0.05;   ///< no point of the arm moves farther in a step [m], > 0
  double shortest_step = 1e-5;  ///< shorter ones get nowhere [m], > 0: ε of the paper's listing
  int most_steps = 5000;
};

struct Descent {
  DescentOutcome outcome = DescentOutcome::kOutOfSteps;
  std::vector<JointVector> path;  ///< from the start on; every piece is a free motion [rad | m]
  int steps = 0;
  int evaluations = 0;  ///< of the field
};

/// From q_start, within `limits`. Where the straight way to the goal is short and free it is taken: the minimum of the
/// field is not at a goal that something repels from. So it is when the descent ends somewhere else.
[[nodiscard]] Descent descend(PotentialField& field, FreeMotion& motion, const JointLimits& limits,
                              const JointVector& q_start, const JointVector& q_goal,
                              const DescentOptions& options = {});

/// "a local minimum", …: what a message says.
[[nodiscard]] const char* describe(DescentOutcome outcome);

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
