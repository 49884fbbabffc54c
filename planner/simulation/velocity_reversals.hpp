#pragma once
/// Velocity reversals of joints near other bodies: a measure of oscillation.

#include <cmath>
#include <cstdint>

#include "planner/model/limits.hpp"

namespace hecaton::planner {

struct VelocityReversals {
  std::uint64_t count = 0;  ///< sign changes of a joint's commanded velocity
  std::uint64_t quick = 0;  ///< of these, less than ReversalCounter::kQuick after the previous one of the joint
  double joint_time = 0.0;  ///< time near other bodies, summed over the joints [s]

  /// Reversals per second and joint; 0 if joint_time is 0.
  [[nodiscard]] double per_second() const { return rate(count); }
  [[nodiscard]] double quick_per_second() const { return rate(quick); }

  VelocityReversals& operator+=(const VelocityReversals& other) {
    count += other.count;
    quick += other.quick;
    joint_time += other.joint_time;
    return *this;
  }

 private:
  [[nodiscard]] double rate(std::uint64_t n) const {
    return joint_time > 0.0 ? static_cast<double>(n) / joint_time : 0.0;
  }
};

/// Counts the reversals of one arm.
class ReversalCounter {
 public:
  /// A velocity below this share of the joint's limit has no sign.
  static constexpr double kStillShare = 0.01;
  /// Two reversals within this time are an oscillation, not a manoeuvre [s].
  static constexpr double kQuick = 0.1;

  /// `qd`: velocity commanded for the next period of `dt` [s]. `near`: a pair of the arm is within its influence
  /// distance. Signs are forgotten while it is not.
  void add(const JointVector& qd, const JointLimits& limits, bool near, double dt) {
    for (int j = 0; j < static_cast<int>(qd.size()); ++j) {
      Joint& joint = joints_[j];
      if (!near) {
        joint = {};
        continue;
      }
      total_.joint_time += dt;
      joint.since_reversal += dt;
      if (std::abs(qd[j]) <= kStillShare * limits.velocity[j]) continue;
      const int sign = qd[j] > 0.0 ? 1 : -1;
      if (joint.sign == -sign) {
        ++total_.count;
        if (joint.since_reversal < kQuick) ++total_.quick;
        joint.since_reversal = 0.0;
      }
      joint.sign = sign;
    }
  }
  [[nodiscard]] const VelocityReversals& total() const { return total_; }

 private:
  struct Joint {
    int sign = 0;                 ///< of the last velocity that had one
    double since_reversal = 1e9;  ///< [s]
  };
  VelocityReversals total_;
  Joint joints_[kMaxJoints];
};

}  // namespace hecaton::planner
