#pragma once
/// What news of a while ago says about now: where things should be, and how much nearer they may be.

#include <cstdint>

#include "planner/local/observation.hpp"
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

}  // namespace hecaton::planner
