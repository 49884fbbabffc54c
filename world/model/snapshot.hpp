#pragma once
/// The state of things at one instant, as a planner or the referee sees it.

#include <cstdint>
#include <string>
#include <vector>

#include "world/model/pose.hpp"

namespace hecaton::world {

/// Where one obstacle is and how it moves.
struct ObstacleState {
  Pose X_WO = Pose::Identity();
  Twist velocity;    ///< of the origin of O, in W
  double age = 0.0;  ///< since it was true, on the reader's own clock [s], ≥ 0
};

/// All obstacles at one instant; same order as the scene edition `edition`.
struct ObstacleSnapshot {
  std::uint64_t edition = 0;   ///< grows with every add, remove, attach or detach
  std::uint64_t sequence = 0;  ///< grows with every step
  double time = 0.0;           ///< the world's own time [s]
  std::vector<ObstacleState> states;
};

}  // namespace hecaton::world
