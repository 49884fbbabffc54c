#pragma once
/// The distance between two bodies, as the contact referee judges it and as reports quote it.

#include <cstdint>
#include <string>

namespace hecaton::world {

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
