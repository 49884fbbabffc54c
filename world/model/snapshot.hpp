#pragma once
/// The state of the world at one instant: where obstacles are, and how far bodies are apart.

#include <cstdint>
#include <string>
#include <vector>

#include "world/model/pose.hpp"

namespace hecaton::world {

/// Pose and velocity of one obstacle.
struct ObstacleState {
  Pose X_WO = Pose::Identity();
  Twist velocity;    ///< of the origin of O, in W
  double age = 0.0;  ///< time since the state was current, on the reader's clock [s], ≥ 0
};

/// All obstacles at one instant, in the order of the scene edition `edition`.
struct ObstacleSnapshot {
  std::uint64_t edition = 0;   ///< grows with every add, remove, attach or detach
  std::uint64_t sequence = 0;  ///< grows with every step
  double time = 0.0;           ///< the world's own time [s]
  std::vector<ObstacleState> states;
};

enum class ContactKind : std::uint8_t { kArmArm, kArmObstacle, kArmSelf };

/// One pair's separation at one instant.
struct Separation {
  double distance = 0.0;  ///< [m]; ≤ 0: contact, the depth negative
  ContactKind kind = ContactKind::kArmArm;
  std::string a;      ///< "arm1/forearm"
  std::string b;      ///< "arm2/wrist", "arm2/box" for what arm2 carries, or "pallet"
  double time = 0.0;  ///< world time [s]
};

}  // namespace hecaton::world
