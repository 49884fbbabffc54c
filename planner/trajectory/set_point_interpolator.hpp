#pragma once
/// What stands between a planner's set-points (one each control period) and an arm (one each period of its driver):
/// interpolation, and the stop when set-points cease. The live driver and the virtual cell use the same code.

#include <cstdint>

#include "planner/model/limits.hpp"

namespace hecaton::planner {

/// Positions and velocities of all joints: a measured state, or a set-point.
struct JointState {
  JointVector q;   ///< [rad | m]
  JointVector qd;  ///< [rad/s | m/s]
};

/// A planner's set-point: be at q with velocity qd `period` [s] after it arrived.
struct TimedSetPoint {
  JointState target;
  double period = 0.0;  ///< [s], > 0
};

/// Moves `state` by dt [s] towards the velocity `qd_next`, as far as the limits of acceleration, velocity and position
/// allow it. A joint at its end stop has velocity 0.
void advance_within_limits(const JointLimits& limits, const JointVector& qd_next, double dt, JointState& state);

enum class DriveMode : std::uint8_t {
  kIdle,      ///< at rest, no set-points yet or any more
  kTracking,  ///< follows set-points
  kStopping,  ///< on its stop profile
};

/// Pure: no clock, no allocation. Not thread-safe.
class SetPointInterpolator {
 public:
  /// At rest at `q`. `command_timeout` [s]: after this silence it stops for good.
  SetPointInterpolator(JointLimits limits, const JointVector& q, double command_timeout);

  /// Takes a set-point; `arm` is the state from which the arm continues. Positions and velocities outside the limits
  /// are clamped to them. False: the arm is farther away than it can move until the set-point is due, even if that is
  /// late by the time-out. The planner then meant another state, and nothing is known to be free on the straight line
  /// to it: the interpolator stops.
  bool command(const TimedSetPoint& set_point, const JointState& arm);
  /// Drops the set-point and stops on the stop profile, from `arm`.
  void stop(const JointState& arm);
  /// At rest at `q`, with no set-point.
  void reset(const JointVector& q);

  /// Where the arm has to be dt [s] from now. When the time-out passes in this step, the stop begins from `arm`.
  ///
  /// Between set-points the acceleration is constant, as the planner integrates it. A set-point that is due and has no
  /// successor is followed by the stop from it: the one continuation that the planner has found free.
  const JointState& step(double dt, const JointState& arm);

  /// What step() returned last.
  [[nodiscard]] const JointState& reference() const { return reference_; }
  [[nodiscard]] DriveMode mode() const { return mode_; }
  [[nodiscard]] const JointLimits& limits() const { return limits_; }
  /// Set-points that the limits changed, since construction.
  [[nodiscard]] std::uint64_t clamped() const { return clamped_; }

 private:
  void track();
  void brake(double dt);

  JointLimits limits_;
  double command_timeout_;
  DriveMode mode_ = DriveMode::kIdle;
  JointState reference_;
  JointVector from_qd_;         ///< velocity when the last set-point came
  JointState target_;           ///< the last set-point
  double period_ = 0.0;         ///< until it was due when it came [s]
  double since_command_ = 0.0;  ///< [s]
  std::uint64_t clamped_ = 0;
};

}  // namespace hecaton::planner
