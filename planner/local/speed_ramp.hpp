#pragma once
/// The way from one speed override to the next.

#include <algorithm>

#include "planner/model/limits.hpp"
#include "planner/model/memory_archive.hpp"

namespace hecaton::planner {

/// The share of the velocity limits that an arm may use, while the ordered share changes. Over any time t the velocity
/// limit of joint j changes by at most ½ aⱼ t. So a motion along the limit needs at most half of the acceleration
/// limit. The other half remains for turns and for the dampers. From 100 % to 1 % the ramp takes at most twice the
/// longest stop time of the arm. A value; no allocation.
class SpeedRamp {
 public:
  explicit SpeedRamp(const JointLimits& limits)
      : velocity_(limits.velocity), rate_(0.5 * (limits.acceleration.array() / limits.velocity.array()).minCoeff()) {}

  /// One period of dt [s]. `qd`: the last set-point's velocity. A lower share begins at the arm's own speed. So a
  /// planner that takes over never first moves faster than the order or the present motion.
  void advance(double ordered, const JointVector& qd, double dt) {
    if (ordered < share_) {
      const double used = (qd.array().abs() / velocity_.array()).maxCoeff();
      share_ = std::max(ordered, std::min(share_, used) - rate_ * dt);
    } else {
      share_ = std::min(ordered, share_ + rate_ * dt);
    }
  }
  [[nodiscard]] double share() const { return share_; }  ///< above 0 to 1
  [[nodiscard]] double rate() const { return rate_; }    ///< largest change [1/s]

  void describe(MemoryArchive& archive) { archive(share_); }

 private:
  JointVector velocity_;
  double rate_;
  double share_ = 1.0;
};

}  // namespace hecaton::planner
