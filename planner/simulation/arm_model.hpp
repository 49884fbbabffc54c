#pragma once
/// A simulated position-controlled arm: the joints alone (for the simulated device of a live driver), and behind the
/// driver's interpolation (for the simulated cell). Users link hecaton_arm_model, which contains no planner.

#include <cstdint>
#include <optional>

#include "planner/simulation/servo.hpp"
#include "planner/trajectory/set_point_interpolator.hpp"

namespace hecaton::planner {

/// Joints with a position controller. No clock, no allocation.
class ServoedJoints {
 public:
  /// At rest at `q`.
  ServoedJoints(JointLimits limits, const JointVector& q);

  /// See follow_within_limits().
  void follow(const JointState& set_point, double dt);
  /// Moves for dt [s] on the stop profile.
  void brake(double dt);

  [[nodiscard]] const JointState& state() const { return state_; }

 private:
  JointLimits limits_;
  JointState state_;
};

/// Follows set-points within the limits. Begins to brake when a set-point has no successor; a late one resumes the
/// motion until the time-out has passed.
class ArmModel {
 public:
  /// At rest at `q`. `command_timeout` [s]: see SetPointInterpolator.
  ArmModel(const JointLimits& limits, const JointVector& q, double command_timeout);
  /// The same behind an imperfect controller. `seed`: of its jitter and noise.
  ArmModel(const JointLimits& limits, const JointVector& q, double command_timeout, const ServoParameters& servo,
           std::uint64_t seed);

  /// See SetPointInterpolator::command().
  bool command(const JointVector& q, const JointVector& qd, double period);
  /// Stops on the stop profile and drops the set-point.
  void stop() { interpolator_.stop(continues_from()); }
  /// Advances by dt [s].
  void step(double dt);

  [[nodiscard]] const JointVector& q() const { return servo_ ? servo_->state().q : joints_.state().q; }
  [[nodiscard]] const JointVector& qd() const { return servo_ ? servo_->state().qd : joints_.state().qd; }
  /// What the controller measures of it.
  [[nodiscard]] const JointState& measured() const { return servo_ ? servo_->measured() : joints_.state(); }
  [[nodiscard]] DriveMode mode() const { return interpolator_.mode(); }
  /// Number of set-points that the limits have changed.
  [[nodiscard]] std::uint64_t clamped() const { return interpolator_.clamped(); }

 private:
  /// As the live driver: with a lag the last set-point, because the next one would else jump back.
  [[nodiscard]] const JointState& continues_from() const {
    return servo_ ? interpolator_.reference() : joints_.state();
  }

  SetPointInterpolator interpolator_;
  ServoedJoints joints_;
  std::optional<Servo> servo_;  ///< nothing: a perfect controller, and `joints_` are the arm
};

}  // namespace hecaton::planner
