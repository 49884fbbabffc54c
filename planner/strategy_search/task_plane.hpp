#pragma once
/// The plane of one task, as the fast simulation goes in it.

#include "planner/methods/strategy/plane.hpp"
#include "planner/strategy_search/flat_kernels.hpp"

namespace hecaton::planner::HECATON_ISA {

struct Plane {
  double start[kFlatJoints];
  double u1[kFlatJoints];
  double u2[kFlatJoints] = {};
  double distance = 0.0;
  double speed1 = 0.0;  ///< no segment moves faster per unit along u₁ [m/rad]
  double speed2 = 0.0;  ///< … along u₂

  /// u₁ of a task from `q` to the goal.
  void begin(const double* q, const double* goal, int n) {
    for (int j = 0; j < n; ++j) {
      start[j] = q[j];
      u1[j] = goal[j] - q[j];
    }
    distance = sqrt(dot_of(u1, u1, n));
    for (int j = 0; j < n; ++j) u1[j] /= distance;
  }
  void q(const FlatArm& arm, const PlanePoint& at, double* out) const {
    for (int j = 0; j < arm.joints; ++j) out[j] = start[j] + at.x * u1[j] + at.y * u2[j];
  }
  void four_q(const FlatArm& arm, const PlanePoint* at, Lanes* out) const {
    const Lanes x{at[0].x, at[1].x, at[2].x, at[3].x};
    const Lanes y{at[0].y, at[1].y, at[2].y, at[3].y};
    for (int j = 0; j < arm.joints; ++j) out[j] = four(start[j]) + x * four(u1[j]) + y * four(u2[j]);
  }

  /// The next four places of the straight way from there, or fewer up to the goal: their number. What is left of the
  /// four is the last again.
  int next_places(PlaneState state, double step, PlanePoint* at) const {
    int count = 0;
    for (int k = 0; k < kLanes; ++k) {
      const PlaneFrame frame = plane_frame(state.at, distance);
      if (k == 0 || frame.left > 0.0) {
        state.at = neighbour(state, frame, distance, step, 0);
        ++count;
      }
      at[k] = state.at;
    }
    return count;
  }
};

}  // namespace hecaton::planner::HECATON_ISA
