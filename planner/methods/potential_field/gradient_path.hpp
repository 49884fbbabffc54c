#pragma once
/// A path down the gradient of a potential field [Cardenas10, fig. 4], and its post-processing.

#include <vector>

#include "planner/methods/potential_field/free_motion.hpp"
#include "planner/methods/potential_field/potential_field.hpp"

namespace hecaton::planner::potential {

enum class DescentOutcome : std::uint8_t {
  kReached,       ///< the path ends at the goal
  kLocalMinimum,  ///< the path ends where the gradient vanishes, or where no downhill step is free
  kOscillating,   ///< the path ends where steps oscillate
  kOutOfSteps,    ///< DescentOptions::most_steps
  kStartBlocked,  ///< the start is in collision or within the margin: no path
  kGoalBlocked,   ///< the goal is in collision or within the margin: no path
};

struct DescentOptions {
  /// Fixed α of every step along −∇U, as published: "must be sufficiently small". 0: steps along steepest_descent()
  /// with a line search (Armijo).
  double alpha = 0.0;
  double longest_step = 0.05;   ///< largest motion of a point of the arm in a step [m], > 0
  double shortest_step = 1e-5;  ///< the descent ends below this [m], > 0: ε of the paper's listing
  int most_steps = 5000;
};

struct Descent {
  DescentOutcome outcome = DescentOutcome::kOutOfSteps;
  std::vector<JointVector> path;  ///< from the start; every segment is free [rad | m]
  int steps = 0;
  int evaluations = 0;  ///< number of field evaluations
};

/// Descends from q_start within `limits`. The path takes the straight line to the goal when it is short and free,
/// because repulsion shifts the minimum of the field away from the goal. It also does so when the descent ends
/// elsewhere.
[[nodiscard]] Descent descend(PotentialField& field, FreeMotion& motion, const JointLimits& limits,
                              const JointVector& q_start, const JointVector& q_goal,
                              const DescentOptions& options = {});

/// A phrase for messages, such as "a local minimum of the potential".
[[nodiscard]] const char* describe(DescentOutcome outcome);

/// The path without unnecessary vertices; the remaining segments are free.
[[nodiscard]] std::vector<JointVector> shortcut(const std::vector<JointVector>& path, FreeMotion& motion);

/// The path with corners cut `times` times, where the cut is free.
[[nodiscard]] std::vector<JointVector> round_corners(std::vector<JointVector> path, FreeMotion& motion, int times);

/// The path with vertices at most `longest` [m] apart, as measured by FreeMotion::sweep().
[[nodiscard]] std::vector<JointVector> resample(const std::vector<JointVector>& path, const FreeMotion& motion,
                                                double longest);

/// Post-processing [Cardenas10, "Examples"]: shortcuts between ever closer vertices, then rounded corners. The ends
/// stay. The result is never longer, and free if `path` is free.
[[nodiscard]] std::vector<JointVector> refine(const std::vector<JointVector>& path, FreeMotion& motion);

/// Length of the path: Σ ‖q(i+1) − q(i)‖ [rad | m].
[[nodiscard]] double length(const std::vector<JointVector>& path);

}  // namespace hecaton::planner::potential
