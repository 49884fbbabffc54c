#pragma once
/// What news of a while ago says about now: where things should be, and how much nearer they may be.

#include "planner/local/observation.hpp"
#include "world/model/snapshot.hpp"

namespace hecaton::planner {

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
/// docs/design/0006-old-news.md
[[nodiscard]] double least_distance(const AgedPair& pair, double security_distance, double slope);

}  // namespace hecaton::planner
