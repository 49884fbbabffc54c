#pragma once
/// Velocities for a forward command controller, from set-points and measured positions. No network.
///
///     velocity = feed-forward + gain × (set-point of tracking_delay before − measured position)
///
/// The feed-forward is q̇ of the set-point, and what brings the integral of the feed-forward to the set-point: a command
/// that comes late interrupts q̇, and the set-point then jumps by what was missed.
///
/// The correction compares the measured position with the set-point that the arm should have reached by then. An arm
/// with exactly this lag therefore needs none. The gain is a quarter of 1/lag, with which a servo of first order does
/// not overshoot.

#include <deque>
#include <optional>

#include "services/arm_driver/devices/arm_device.hpp"

namespace hecaton::device::ros2_control {

/// What the arm measures.
struct MeasuredPosition {
  JointVector q;
  Clock::time_point at;
};

/// A joint that is not where its set-points lead.
struct LostJoint {
  Eigen::Index joint = 0;
  double distance = 0.0;  ///< [rad | m]
  double limit = 0.0;     ///< the largest distance that is allowed [rad | m]
};

/// For one thread.
class VelocityCommands {
 public:
  /// `tracking_delay`: lag of the arm behind its set-points [s].
  VelocityCommands(JointLimits limits, double tracking_delay);

  /// The arm stands at q.
  void begin(const JointVector& q, Clock::time_point now);
  /// The velocity to send at `now` for the set-point that the arm shall reach at `due`. Each joint keeps its limits:
  /// the velocity, twice the acceleration, and a stop before the position limit. `speed_scaling`: of the hardware.
  [[nodiscard]] const JointVector& follow(const JointState& set_point, Clock::time_point due,
                                          const MeasuredPosition& measured, double speed_scaling,
                                          Clock::time_point now);
  /// The velocity to send at `now` on the stop profile.
  [[nodiscard]] const JointVector& brake(Clock::time_point now);

  /// The last velocity. Its size is zero before begin().
  [[nodiscard]] const JointVector& last() const { return velocity_; }
  /// A joint that the largest correction does not bring back to its set-points; empty: none since begin().
  [[nodiscard]] const std::optional<LostJoint>& lost() const { return lost_; }
  /// Lag of an arm whose hardware executes only this share of each velocity [s]: the correction makes up for the rest.
  [[nodiscard]] static double delay(double tracking_delay, double speed_scaling);

 private:
  struct Sample {
    Clock::time_point at;
    JointVector q;
  };

  struct Far {
    double error = 0.0;       ///< smallest since then, as a multiple of its limit
    Clock::time_point since;  ///< of that error
  };

  [[nodiscard]] JointVector set_point_at(Clock::time_point at) const;
  void integrate(Clock::time_point now);
  void note(const JointVector& error, double share, Clock::time_point now);

  JointLimits limits_;
  Clock::duration delay_;
  double gain_;  ///< [1/s]
  JointVector velocity_;
  JointVector forward_velocity_;  ///< the feed-forward
  JointVector forward_;           ///< its integral: where an arm without a lag would be
  Clock::time_point sent_at_;
  std::deque<Sample> set_points_;  ///< oldest first; the first one may be older than needed
  std::optional<Far> far_;         ///< a joint is too far from its set-points
  std::optional<LostJoint> lost_;
};

}  // namespace hecaton::device::ros2_control
