#pragma once
/// What kinematics do at a link's joint.

#include <cstdint>

namespace hecaton::planner {

/// All but the last are short cuts of the last: with them the same comes out, to the last bit.
enum class JointMotion : std::uint8_t {
  kTurnsAboutX,
  kTurnsAboutY,
  kTurnsAboutZ,
  kFixed,
  kMoves,  ///< turns about, then shifts along, any axis
};

}  // namespace hecaton::planner
