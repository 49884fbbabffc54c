#pragma once
/// Finds out that an arm does not move although its set-points do. Controllers of ros2_control that are inactive
/// receive commands and ignore them in silence.

#include <deque>
#include <optional>

#include "services/arm_driver/devices/arm_device.hpp"

namespace hecaton::device::ros2_control {

/// For one thread.
class MotionWatch {
 public:
  /// The set-point and the measured position at `now`. `delay`: lag of the arm behind set-points [s].
  void add(Clock::time_point now, const JointVector& set_point, const JointVector& measured, double delay);
  void forget() { samples_.clear(); }

  /// A joint, from 0, that has stood still although its set-point moved; empty: none.
  [[nodiscard]] std::optional<Eigen::Index> idle_joint() const;

 private:
  struct Sample {
    Clock::time_point at;
    JointVector set_point, measured;
  };
  std::deque<Sample> samples_;
  Clock::duration answer_{0};  ///< in which the arm must have begun to move
};

}  // namespace hecaton::device::ros2_control
