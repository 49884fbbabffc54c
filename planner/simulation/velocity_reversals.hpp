#pragma once
/// VelocityReversals: how often joints turn back while constraints shape the motion.

#include <cstdint>

#include "planner/model/limits.hpp"

namespace hecaton::planner {

struct VelocityReversals {
  std::uint64_t turns = 0;  ///< a joint's commanded velocity changed its sign
  std::uint64_t quick = 0;  ///< of these: the same joint had turned less than kQuick before
  double joint_time = 0.0;  ///< near constraints, summed over the joints [s]

  /// Turns per second and joint; 0 when nothing was ever near.
  [[nodiscard]] double per_second() const { return rate(turns); }
  [[nodiscard]] double quick_per_second() const { return rate(quick); }

  VelocityReversals& operator+=(const VelocityReversals& other) {
    turns += other.turns;
    quick += other.quick;
    joint_time += other.joint_time;
    return *this;
  }

 private:
  [[nodiscard]] double rate(std::uint64_t n) const {
    return joint_time > 0.0 ? static_cast<double>(n) / joint_time : 0.0;
  }
};

/// Counts one arm's, period by period.
class ReversalCounter {
 public:
  /// Slower than this share of the joint's velocity limit has no sign: it neither is a turn nor forgets the last sign.
  static constexpr double kStillShare = 0.01;
  /// Two turns within this time are back and forth, not a manoeuvre [s].
  static constexpr double kQuick = 0.1;

  /// `qd`: the velocity commanded for the next period. `near`: some pair is within its influence distance; what was
  /// before an arm came near is forgotten.
  void add(const JointVector& qd, const JointLimits& limits, bool near, double dt);
  [[nodiscard]] const VelocityReversals& total() const { return total_; }

 private:
  struct Joint {
    int sign = 0;             ///< of the last velocity that had one, since the arm came near
    double since_turn = 1e9;  ///< [s]
  };
  VelocityReversals total_;
  Joint joints_[kMaxJoints];
};

}  // namespace hecaton::planner
