#pragma once
/// A simulated position-controlled arm, alone (for the device of the live driver) and behind the driver's interpolation
/// (for the virtual cell). Users of this header link hecaton_arm_model, which knows no planner.

#include <cstdint>

#include "planner/trajectory/set_point_interpolator.hpp"

namespace hecaton::planner {

/// The joints and their position controller. Pure: no clock, no allocation.
class ServoedJoints {
 public:
  /// At rest at `q`.
  ServoedJoints(JointLimits limits, const JointVector& q);

  /// Moves by dt [s] towards `set_point`, which is due then. A position error is corrected, but no faster than it can
  /// be braked away again. Limits hold whatever is commanded.
  void follow(const JointState& set_point, double dt);
  /// Moves by dt [s] on the stop profile.
  void brake(double dt);

  [[nodiscard]] const JointState& state() const { return state_; }

 private:
  /// The velocity that takes a position error away [rad/s | m/s].
  [[nodiscard]] JointVector correction(const JointVector& error) const;

  JointLimits limits_;
  JointState state_;
};

/// Follows a planner's set-points within its limits, and stops on the stop profile when they cease: begins to when a
/// set-point has no successor, and for good after the time-out.
class ArmModel {
 public:
  /// At rest at `q`. `command_timeout` [s]: silence after which the arm stops for good.
  ArmModel(const JointLimits& limits, const JointVector& q, double command_timeout);

  /// See SetPointInterpolator::command().
  bool command(const JointVector& q, const JointVector& qd, double period);
  /// Stops on the stop profile and drops the set-point.
  void stop() { interpolator_.stop(joints_.state()); }
  /// Advances by dt [s].
  void step(double dt);

  [[nodiscard]] const JointVector& q() const { return joints_.state().q; }
  [[nodiscard]] const JointVector& qd() const { return joints_.state().qd; }
  [[nodiscard]] DriveMode mode() const { return interpolator_.mode(); }
  /// Set-points that the limits changed, since construction.
  [[nodiscard]] std::uint64_t clamped() const { return interpolator_.clamped(); }

 private:
  SetPointInterpolator interpolator_;
  ServoedJoints joints_;
};

}  // namespace hecaton::planner
