#pragma once
/// A joint controller as imperfect as real ones: dead time, lag, jitter, a period of its own, noise of the measurement.

#include <cstdint>
#include <deque>
#include <string_view>
#include <vector>

#include "planner/local/random.hpp"
#include "planner/trajectory/set_point_interpolator.hpp"

namespace hecaton::planner {

/// How joints follow set-points, and how they are measured. The default is perfect.
struct ServoParameters {
  double period = 0.0;      ///< in which the controller takes a set-point [s]; 0: each one as it comes
  double dead_time = 0.0;   ///< from a set-point to its effect [s]
  double jitter = 0.0;      ///< the dead time is uniform within ± this [s], ≤ dead_time
  double lag = 0.0;         ///< of the joints behind a ramp, beside the dead time [s]
  double damping = 0.0;     ///< of a second order, below 1: the joints overshoot; 0: first order
  double noise = 0.0;       ///< standard deviation of measured positions [rad | m]
  double resolution = 0.0;  ///< step of measured positions [rad | m]

  /// Mean time by which the joints are behind their set-points [s].
  [[nodiscard]] double delay() const { return dead_time + lag; }
  [[nodiscard]] bool perfect() const { return period <= 0.0 && delay() <= 0.0 && noise <= 0.0 && resolution <= 0.0; }
};

/// Parameters near those of a kind of controller.
struct ServoPreset {
  std::string_view name;
  ServoParameters servo;
};
[[nodiscard]] const std::vector<ServoPreset>& servo_presets();

/// Moves `state` for dt [s] towards `set_point`, which is due at the end. Corrects a position error no faster than a
/// joint can brake again. Keeps the limits of velocity and acceleration for any set-point.
void follow_within_limits(const JointLimits& limits, const JointState& set_point, double dt, JointState& state);

/// Joints behind such a controller. Keeps the limits of velocity and acceleration that set-points keep, up to the
/// overshoot of a second order. No clock.
class Servo {
 public:
  /// At rest at `q`. `seed`: of jitter and noise.
  Servo(JointLimits limits, const ServoParameters& parameters, const JointVector& q, std::uint64_t seed);

  /// Moves for dt [s]. `set_point` is due at the end for a perfect controller.
  void follow(const JointState& set_point, double dt);
  /// Moves for dt [s] on the stop profile, at once, and drops all set-points.
  void brake(double dt);

  /// Where the joints are.
  [[nodiscard]] const JointState& state() const { return state_; }
  /// The same as measured after the last call.
  [[nodiscard]] const JointState& measured() const { return measured_; }

 private:
  struct SetPoint {
    double due = 0.0;  ///< when it takes effect [s]
    double at = 0.0;   ///< its own time plus the mean dead time [s]
    JointState target;
  };
  void take();
  void approach(const JointState& target, double dt);
  void measure();

  JointLimits limits_;
  ServoParameters parameters_;
  JointState state_;
  JointState measured_;
  std::deque<SetPoint> pending_;  ///< in the order of `due`
  SetPoint active_;
  double now_ = 0.0;         ///< [s]
  double next_cycle_ = 0.0;  ///< [s]
  Random random_;
};

}  // namespace hecaton::planner
