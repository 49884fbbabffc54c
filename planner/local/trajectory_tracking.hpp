#pragma once
/// How an arm follows a timed trajectory (docs/explanation/0022-timed-trajectories.md). The trajectory is what the arm
/// wants; dampers, limits and the right of way act on it as on every other wish. Its time runs as fast as the arm can
/// follow, and stops while the arm waits.

#include <cstdint>
#include <memory>

#include "planner/model/limits.hpp"
#include "planner/model/memory_archive.hpp"
#include "planner/trajectory/timed_trajectory.hpp"

namespace hecaton::planner {

enum class TrackingPhase : std::uint8_t {
  kNone,     ///< the goal has no trajectory
  kFollows,  ///< the arm follows the trajectory
  kAside,    ///< the arm goes around something, to a later point of the trajectory
  kDone,     ///< the time of the trajectory is over; the arm goes to its end
  kAround,   ///< the arm goes around something within the path tolerance, to a later point of the trajectory
};

/// A value: rollouts copy it. Pure and without allocation, except in describe().
struct TrajectoryTracking {
  std::shared_ptr<const TimedTrajectory> trajectory;  ///< null: kNone
  TrackingPhase phase = TrackingPhase::kNone;
  double time = 0.0;   ///< of the trajectory; never falls [s]
  double rate = 0.0;   ///< of that time, 0 to 1
  bool begun = false;  ///< `start` is set
  TimedPoint start;    ///< the arm's state when it began, from which it goes to a first point of a later time

  [[nodiscard]] bool follows() const { return phase == TrackingPhase::kFollows; }
  /// The arm must stay near the trajectory.
  [[nodiscard]] bool is_bound() const { return phase != TrackingPhase::kNone && trajectory->has_path_tolerance(); }
  /// The trajectory's state at a time. Precondition: there is a trajectory.
  [[nodiscard]] JointState at(double when) const;

  void describe(MemoryArchive& archive);
};

/// Advances the time of the trajectory by up to `dt` [s]. Returns the velocity with which an arm at (q, q̇) follows it,
/// at the end of the period [rad/s | m/s]. `speed`: share of the arm's velocity limits that it may use, of which
/// `limits` has at most that. `waits`: the arm does something else now. Precondition: follows().
[[nodiscard]] JointVector track(const JointLimits& limits, const JointVector& q, const JointVector& qd, double dt,
                                double speed, bool waits, TrajectoryTracking& tracking);

/// Continues from an arm at (q, q̇) that has not followed in the last period. It has just got the trajectory, it was
/// held, or another planner has commanded it. The time advances to where the arm is. Precondition: follows().
void resume_tracking(const JointLimits& limits, const JointVector& q, const JointVector& qd,
                     TrajectoryTracking& tracking);

/// The space around the trajectory's present position that the path tolerance leaves to the set-points.
struct PathBox {
  JointVector lower;  ///< [rad | m]; −infinity: this joint has no tolerance
  JointVector upper;  ///< [rad | m]; infinity: the same
};

/// The box at the present time for an arm at `q`. Precondition: is_bound().
[[nodiscard]] PathBox path_box(const JointLimits& limits, const JointVector& q, const TrajectoryTracking& tracking);

/// Velocity limits near what may block the arm: each joint can stop within its tolerance. Precondition: is_bound().
[[nodiscard]] JointVector velocity_on_path(const JointLimits& limits, double dt, const TrajectoryTracking& tracking);

/// Ends the period of a bound arm, whose next set-point is (q, q̇). An arm that follows has advanced its time from
/// `before`; the time falls back to the latest at which the arm is in the box. The time of an arm that goes around
/// advances to where the arm is. `stop_time`: the arm must also be able to stop in the box, with joint velocities
/// below the distance to its sides divided by this [s]; 0: it need not. Precondition: is_bound().
void keep_box(const JointLimits& limits, const JointVector& q, const JointVector& qd, double dt, double stop_time,
              double before, TrajectoryTracking& tracking);

/// The joint of an arm at `q` that is farther from the path near the present time than its tolerance; −1: none.
[[nodiscard]] int outside_path_tolerance(const JointLimits& limits, const JointVector& q,
                                         const TrajectoryTracking& tracking);

}  // namespace hecaton::planner
