#pragma once
/// One arm in a run of the fast simulation: its task, its place, and cached checks.

#include "planner/methods/strategy/plane.hpp"
#include "planner/strategy_search/rough_distance.hpp"

namespace hecaton::planner::HECATON_ISA {

/// The plane of a task in joint space [Mediavilla02]: start + x u₁ + y u₂.
struct Plane {
  double start[kFlatJoints];
  double u1[kFlatJoints];
  double u2[kFlatJoints] = {};
  double distance = 0.0;
  double speed1 = 0.0;  ///< upper bound of the speed of segments per unit along u₁ [m/rad]
  double speed2 = 0.0;  ///< the same along u₂

  /// Sets start, distance and u₁ of a task from `q` to `goal` [rad].
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

  /// The next four places on the straight path, or fewer up to the goal; returns their number. Unused entries repeat
  /// the last place.
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

/// Places whose neighbours are cached.
inline constexpr int kCachedPlaces = 8;

/// Four places in the plane, checked together.
struct CheckedPlaces {
  PlanePoint at[kLanes];
  RoughPlace places[kLanes];
  unsigned self_free = 0;  ///< bit k: place k is within limits, clear of itself and of boxes
  int count = 0;           ///< valid entries
  int next = 0;            ///< the next entry to move to
  /// By place: the arm that was too close; it still is while its `travelled` is below blocked_until [m].
  int blocker[kLanes];
  double blocked_until[kLanes];
};

/// Key of cached neighbours: the place, and the number of the first neighbour.
struct CacheKey {
  PlanePoint at;
  double side = 0.0;  ///< 0: empty
  int first = 0;

  [[nodiscard]] bool is(const PlaneState& state, int from) const {
    return at.x == state.at.x && at.y == state.at.y && side == state.side && first == from;
  }
};

/// The state of one arm.
struct Runner {
  const FlatArm* arm = nullptr;
  RoughArm rough;
  double q[kFlatJoints];  ///< at the last rest [rad]
  Plane plane;
  PlaneState state;
  RoughPlace own;
  const float* here = own.numbers;     ///< present place
  std::int64_t known_step = -1;        ///< next step on a prechecked path; −1: none
  CheckedPlaces ahead;                 ///< on the straight path
  bool heads_for_goal = true;          ///< the last steps led towards the goal; the next four are checked together
  CheckedPlaces cache[kCachedPlaces];  ///< neighbours of the last places, to which a blocked arm returns
  CacheKey cache_key[kCachedPlaces];   ///< apart from the entries, because only the keys are searched
  int replaced_next = 0;               ///< index of the cache
  int steps_in_row = 0;                ///< towards the goal since the last step aside
  double travelled = 0.0;              ///< upper bound of the motion of its segments since the last reset [m]
  int nearest[kFlatArms];              ///< by other arm: body of the last distance
  bool moving = false;
  int area = 0;            ///< of the last goal
  int task = 0;            ///< number of the present or next task
  std::int64_t until = 0;  ///< start of the next task [steps]
  std::int64_t began = 0;
  std::int64_t limit = 0;  ///< time-out of the task [steps]

  void clear_cache() {
    for (CacheKey& key : cache_key) key.side = 0.0;
  }
  [[nodiscard]] int next_area(int areas) const { return area + 1 == areas ? 0 : area + 1; }
};

}  // namespace hecaton::planner::HECATON_ISA
