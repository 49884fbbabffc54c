#pragma once
/// Present states from delayed ones: where arms and obstacles are expected now, and how far they may be from there
/// (docs/design/0006-latency-compensation.md).

#include <array>
#include <cstdint>
#include <optional>

#include "planner/local/observation.hpp"
#include "planner/model/arm.hpp"
#include "world/model/snapshot.hpp"

namespace hecaton::planner {

/// What the own arm's driver told a while ago.
struct OwnArmFeedback {
  MeasuredState state;
  double age = 0.0;            ///< of the state [s], ≥ 0
  bool follows = false;        ///< its drive followed set-points
  std::uint64_t setpoint = 0;  ///< number of the last one that it had; 0: none of this planner's
  double setpoint_age = 0.0;   ///< since that came, when the state was true [s]
};

/// Where the own arm is at least, on its way: its drive goes to the set-point that it had, `period` [s] after that
/// came, and stops when there is no other. Who begins to command from there takes the arm for no farther on than it is.
[[nodiscard]] MeasuredState dead_reckoned(const JointLimits& limits, const OwnArmFeedback& news, double period);

/// Brings the arm to where it should be now: an arm that plans has kept its velocity, as far as its joints go; another
/// one has been on its stop profile. The age stays.
void extrapolate(const JointLimits& limits, ArmObservation& arm);

/// The obstacle as it should be now at constant velocity. The age stays.
[[nodiscard]] world::ObstacleState extrapolated(const world::ObstacleState& then);

/// A pair of bodies of which the other one's state is old.
struct AgedPair {
  double distance = 0.0;            ///< expected now, from the extrapolated state [m]
  double age = 0.0;                 ///< [s], ≥ 0
  double own_speed = 0.0;           ///< of the own point towards the other [m/s]
  double other_speed = 0.0;         ///< of the other point towards the own, by the old state [m/s]
  double other_acceleration = 0.0;  ///< the most that it may have gained per second [m/s²]
};

/// The least distance [m] that the pair may really have, whatever the other did within its acceleration.
[[nodiscard]] double least_distance(const AgedPair& pair);

/// The same when the other has kept its damper, too: approached by at most `slope` · (d − `security_distance`).
/// docs/design/0006-latency-compensation.md
[[nodiscard]] double least_distance(const AgedPair& pair, double security_distance, double slope);

class SetpointLog {
 public:
  /// `period` [s]: from a set-point's arrival until the arm is to be there.
  SetpointLog(JointLimits limits, double period);

  /// Numbers grow, but not always by one. 0 is none.
  void sent(std::uint64_t number, const MeasuredState& setpoint);
  /// Where the drive's reference is when it has had this set-point for `age` [s]: on the way to it, or on the stop from
  /// it. Empty: not ours, or sent too long ago.
  [[nodiscard]] std::optional<MeasuredState> reference(std::uint64_t number, double age) const;

 private:
  struct Entry {
    std::uint64_t number = 0;
    MeasuredState setpoint;
  };
  JointLimits limits_;
  double period_;
  std::array<Entry, 64> ring_;  ///< by number
};

/// Every joint is at rest within `position_uncertainty` of `q`, either way [rad | m].
struct ReachableStopSet {
  JointVector q;
  JointVector position_uncertainty;
};

/// Of an arm that was in (q, q̇), moved on within its limits in whatever way, and began its stop profile no later than
/// `moved_for` [s] afterwards.
[[nodiscard]] ReachableStopSet reachable_stop_set(const JointLimits& limits, const JointVector& q,
                                                  const JointVector& qd, double moved_for);

/// How far the points of something that is fixed to link `link`, all of them within `extent` [m] of the link's origin,
/// move at most per joint rate: [m/rad] for turning joints, 1 for shifting ones, whatever the configuration (within
/// limits, where a joint shifts).
[[nodiscard]] JointVector longest_levers(const Arm& arm, int link, double extent);

}  // namespace hecaton::planner
