#pragma once
/// One arm of a run of the fast simulation: its task, where it is, and what it has looked at.

#include "planner/methods/strategy/plane.hpp"
#include "planner/strategy_search/rough_distance.hpp"

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

inline constexpr int kKnownPlaces = 8;

/// Four configurations looked at together, and where in the plane they are.
struct Looked {
  PlanePoint at[kLanes];
  RoughPlace places[kLanes];
  unsigned alone = 0;  ///< bit k: configuration k is within limits, clear of itself and of boxes
  int count = 0;       ///< that are valid
  int next = 0;        ///< the first that was not gone to yet
  /// Which arm was found too near each, and how far it may have travelled at most while it certainly still is [m].
  int blocker[kLanes];
  double blocked_until[kLanes];
};

/// Neighbours of which place, and from which on: what a Looked is known by.
struct LookedAt {
  PlanePoint at;
  double side = 0.0;  ///< 0: nothing is known
  int first = 0;

  [[nodiscard]] bool is(const PlaneState& state, int from) const {
    return at.x == state.at.x && at.y == state.at.y && side == state.side && first == from;
  }
};

/// One arm of a run.
struct Runner {
  const FlatArm* arm = nullptr;
  RoughArm rough;
  double q[kFlatJoints];  ///< where it last stood
  Plane plane;
  PlaneState state;
  RoughPlace own;
  const float* here = own.numbers;  ///< where it is
  std::int64_t known_step = -1;     ///< its next step on a prechecked path; −1: on none
  Looked ahead;                     ///< on the straight way
  bool heads_for_goal = true;            ///< the last steps led towards the goal: several of them are looked at together
  Looked known[kKnownPlaces];  ///< neighbours of the last places: who is held up comes to the same ones again and again
  LookedAt known_by[kKnownPlaces];  ///< apart from them: it is what is searched
  int forgotten = 0;                ///< the next of these to be replaced
  int steps_in_row = 0;             ///< towards the goal, since one aside
  double travelled = 0.0;           ///< no segment has moved farther since the run began [m]
  int nearest[kFlatArms];           ///< its body when its distance to another arm was measured last
  bool moving = false;
  int area = 0;            ///< where it is, or where it comes from
  int task = 0;            ///< the number of the present or next
  std::int64_t until = 0;  ///< waits
  std::int64_t began = 0;
  std::int64_t limit = 0;  ///< the task's time is over

  void forget_places() {
    for (LookedAt& place : known_by) place.side = 0.0;
  }
  [[nodiscard]] int next_area(int areas) const { return area + 1 == areas ? 0 : area + 1; }
};

}  // namespace hecaton::planner::HECATON_ISA
