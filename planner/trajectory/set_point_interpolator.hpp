#pragma once
/// Interpolation between a planner's set-points (one per control period) and a drive (one per driver period), and the
/// stop when set-points cease. The live driver and the simulation use the same code.

#include <cstdint>

#include "planner/model/limits.hpp"

namespace hecaton::planner {

/// Positions and velocities of all joints: a measured state, or a set-point.
struct JointState {
  JointVector q;   ///< [rad | m]
  JointVector qd;  ///< [rad/s | m/s]
};

/// A set-point of a planner: reach q with velocity qd, `period` [s] after its arrival.
struct TimedSetPoint {
  JointState target;    ///< at the end of `period`
  double period = 0.0;  ///< [s], > 0
};

/// Integrates `state` over dt [s] towards the velocity `qd_next`, within the acceleration, velocity and position
/// limits. A joint at a position limit gets velocity 0.
void advance_within_limits(const JointLimits& limits, const JointVector& qd_next, double dt, JointState& state);

/// What the interpolator does.
enum class DriveMode : std::uint8_t {
  kIdle,      ///< at rest, without set-points
  kTracking,  ///< follows set-points
  kStopping,  ///< on its stop profile
};

/// Pure: no clock, no allocation. Not thread-safe.
class SetPointInterpolator {
 public:
  /// Starts at rest at `q`. Without a new set-point for `command_timeout` [s], the interpolator stops the arm.
  SetPointInterpolator(JointLimits limits, const JointVector& q, double command_timeout);

  /// Takes a set-point; `arm` is the state from which the arm continues. Values outside the limits are clamped. Returns
  /// false and stops if the arm cannot reach the position in time, even with a delay of the time-out. Such a set-point
  /// belongs to another state, and the line to it may not be free.
  bool command(const TimedSetPoint& set_point, const JointState& arm);
  /// Drops the set-point and stops on the stop profile, from `arm`.
  void stop(const JointState& arm);
  /// At rest at `q`, with no set-point.
  void reset(const JointVector& q);

  /// The reference dt [s] from now. If the time-out expires in this step, the stop begins from `arm`.
  ///
  /// The acceleration between set-points is constant, as the planner integrates it. Without a successor, the stop
  /// profile follows the last set-point. The planner has checked this continuation to be free.
  const JointState& step(double dt, const JointState& arm);

  /// The last result of step().
  [[nodiscard]] const JointState& reference() const { return reference_; }
  [[nodiscard]] DriveMode mode() const { return mode_; }               ///< after the last call
  [[nodiscard]] const JointLimits& limits() const { return limits_; }  ///< as given
  /// Number of clamped set-points since construction.
  [[nodiscard]] std::uint64_t clamped() const { return clamped_; }

 private:
  void track();
  void brake(double dt);

  JointLimits limits_;
  double command_timeout_;
  DriveMode mode_ = DriveMode::kIdle;
  JointState reference_;
  JointVector from_qd_;         ///< velocity at the arrival of the last set-point
  JointState target_;           ///< the last set-point
  double period_ = 0.0;         ///< of the last set-point [s]
  double since_command_ = 0.0;  ///< [s]
  std::uint64_t clamped_ = 0;
};

}  // namespace hecaton::planner
