#pragma once
/// One arm of a run of the fast simulation: its task, where it is, and what it has looked at.

#include "planner/strategy_search/rough_distance.hpp"
#include "planner/strategy_search/task_plane.hpp"

namespace hecaton::planner::HECATON_ISA {

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
  std::int64_t way = -1;            ///< its next step among the known ways; −1: it is not on one
  Looked ahead;                     ///< on the straight way
  bool keeps_way = true;            ///< the last steps led towards the goal: several of them are looked at together
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
