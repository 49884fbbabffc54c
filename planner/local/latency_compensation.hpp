#pragma once
/// Present states from delayed ones: where arms and obstacles are expected now, and bounds of how far they may be from
/// there (docs/explanation/0006-latency-compensation.md). Pure functions; no allocation unless stated.

#include <array>
#include <cstdint>
#include <optional>

#include "planner/local/observation.hpp"
#include "planner/model/arm.hpp"
#include "planner/model/memory_archive.hpp"
#include "world/model/snapshot.hpp"

namespace hecaton::planner {

/// A state report of the own arm's driver.
struct OwnArmFeedback {
  MeasuredState state;
  double age = 0.0;             ///< time since the measurement [s], ≥ 0
  bool follows = false;         ///< the drive followed set-points
  std::uint64_t setpoint = 0;   ///< number of the drive's last set-point; 0: none of this planner
  double setpoint_age = 0.0;    ///< age of that set-point at the time of the measurement [s]; < 0: it arrived later
  double tracking_delay = 0.0;  ///< lag of the measured state behind the set-points [s], ≥ 0
  double speed_scaling = 1.0;   ///< share of the velocity limits that the device executes, 0 to 1
};

/// The present state of the own arm by dead reckoning. The drive moves to its last set-point, `period` [s] after that
/// arrived, and then follows its stop profile. The result never lies ahead of the arm on its path.
[[nodiscard]] MeasuredState dead_reckoned(const JointLimits& limits, const OwnArmFeedback& feedback, double period);

/// Extrapolates the arm to now: at constant velocity if it plans or others move it, on its stop profile otherwise.
/// Positions are clamped to the limits. The age stays.
void extrapolate(const JointLimits& limits, ArmObservation& arm);

/// The obstacle at its expected present pose, for a constant twist. The age stays.
[[nodiscard]] world::ObstacleState extrapolated(const world::ObstacleState& then);

/// A pair of bodies. The state of the other body is old.
struct AgedPair {
  double distance = 0.0;            ///< expected now, from the extrapolated state [m]
  double age = 0.0;                 ///< of the other body's state [s], ≥ 0
  double own_speed = 0.0;           ///< approach speed of the own point [m/s]
  double own_fastest = 0.0;         ///< bound of that speed since the other body's state [m/s], ≥ own_speed
  double other_speed = 0.0;         ///< approach speed of the other point in the old state [m/s]
  double other_acceleration = 0.0;  ///< bound of the other point's acceleration [m/s²]
};

/// Lower bound of the present distance for any motion within the acceleration bound [m].
[[nodiscard]] double least_distance(const AgedPair& pair);

/// The same for another body that keeps its damper: it approaches at most at `slope` · (d − `security_distance`).
[[nodiscard]] double least_distance(const AgedPair& pair, double security_distance, double slope);

/// The last 64 set-points that were sent to the own drive. The tracking error of a delayed state must refer to the
/// set-point that the drive had then. Not thread-safe.
class SetpointLog {
 public:
  /// `period`: time from the arrival of a set-point until the arm is due there [s].
  SetpointLog(JointLimits limits, double period);

  /// Records a set-point. Numbers grow, with gaps allowed; 0 is no number.
  void sent(std::uint64_t number, const MeasuredState& setpoint);
  /// The drive's reference `age` [s] after the set-point arrived: on the way to it, or on the stop profile from it. A
  /// negative age leads back to the set-points before. Nothing for a number that the log does not hold.
  [[nodiscard]] std::optional<MeasuredState> reference(std::uint64_t number, double age) const;

  void describe(MemoryArchive& archive) {
    for (Entry& entry : ring_) archive(entry.number, entry.setpoint);
  }

 private:
  struct Entry {
    std::uint64_t number = 0;
    MeasuredState setpoint;
  };
  JointLimits limits_;
  double period_;
  std::array<Entry, 64> ring_;  ///< by number
};

/// A box in joint space: every joint is at rest within `position_uncertainty` of `q` [rad | m].
struct ReachableStopSet {
  JointVector q;
  JointVector position_uncertainty;
};

/// All rest positions of an arm that was at (q, q̇), moved arbitrarily within its limits for at most `moved_for` [s],
/// and then followed its stop profile (docs/explanation/0009-lost-arms.md).
[[nodiscard]] ReachableStopSet reachable_stop_set(const JointLimits& limits, const JointVector& q,
                                                  const JointVector& qd, double moved_for);

/// Bound of the speed per unit joint rate, [m/rad] for revolute joints and 1 for prismatic ones. It holds for points
/// fixed to `link` within `extent` [m] of the link's origin. Valid in every configuration within limits. Allocates.
[[nodiscard]] JointVector longest_levers(const Arm& arm, int link, double extent);

}  // namespace hecaton::planner
