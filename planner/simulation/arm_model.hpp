#pragma once
/// A position-controlled arm with its drive: follows set-points within its limits, stops on its own stop profile when
/// they cease: begins to at once when a set-point has no successor, and for good after the time-out. The simulated arm
/// driver and the virtual cell move this.

#include <cstdint>

#include "planner/model/limits.hpp"

namespace hecaton::planner {

enum class DriveMode : std::uint8_t {
  kIdle,      ///< at rest, no set-points yet or any more
  kTracking,  ///< follows set-points
  kStopping,  ///< on its stop profile
};

class ArmModel {
 public:
  /// At rest at `q`. `command_timeout` [s]: silence after which the arm stops by itself.
  ArmModel(JointLimits limits, JointVector q, double command_timeout);

  /// A set-point: be at q with velocity qd `period` [s] from now. Positions outside the limits are clamped to them.
  /// False: the arm is too far from it to get there if it is late by no more than the time-out; so it was meant for an
  /// arm that is somewhere else, and on the straight line to it nobody has looked for obstacles. The arm stops.
  bool command(const JointVector& q, const JointVector& qd, double period);
  /// Stops on the stop profile and drops the set-point.
  void stop();
  /// Advances by dt [s]. Velocity, acceleration and position limits hold whatever was commanded.
  void step(double dt);

  [[nodiscard]] const JointVector& q() const { return q_; }
  [[nodiscard]] const JointVector& qd() const { return qd_; }
  [[nodiscard]] DriveMode mode() const { return mode_; }
  /// Set-points that the limits changed, since construction.
  [[nodiscard]] std::uint64_t clamped() const { return clamped_; }

 private:
  void track(double dt);
  /// The velocity that takes a position error away [rad/s | m/s].
  [[nodiscard]] JointVector correction(const JointVector& error) const;
  void move(const JointVector& qd_next, double dt);

  JointLimits limits_;
  JointVector q_;
  JointVector qd_;
  DriveMode mode_ = DriveMode::kIdle;
  double command_timeout_;
  JointVector from_q_, from_qd_;      ///< reference when the last set-point came
  JointVector target_q_, target_qd_;  ///< the last set-point
  double period_ = 0.0;               ///< until the set-point is due, when it came [s]
  double since_command_ = 0.0;        ///< [s]
  std::uint64_t clamped_ = 0;
};

}  // namespace hecaton::planner
