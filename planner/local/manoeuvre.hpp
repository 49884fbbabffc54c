#pragma once
/// What an arm that is held back may try next. One manoeuvre changes what the local planner remembers, and nothing
/// else; so a rollout can try it on a copy, and the arm can then do exactly what was tried.

#include <cstdint>

#include "planner/model/limits.hpp"

namespace hecaton::planner {

enum class ManoeuvreKind : std::uint8_t {
  kContinue,  ///< whatever is being done: follow the boundary, or go straight as long as there is a way
  kAbandon,   ///< stop following, go straight to the goal
  kSubspace,  ///< follow in a fresh subspace, drawn with `seed`
  kDetour,    ///< visit `q` first, straight; then the goal
  kEvade,     ///< go to `q`, straight, and be there until `patience` is over, also without a goal; then go on
};

struct Manoeuvre {
  ManoeuvreKind kind = ManoeuvreKind::kContinue;
  std::uint64_t seed = 0;  ///< of all random choices from now on; not for kContinue
  JointVector q;           ///< of kDetour and kEvade [rad | m]
  double patience = 0.0;   ///< these end after so long at the latest [s]
};

/// The way-point of a detour, while there is one.
struct Detour {
  bool active = false;
  JointVector q;           ///< [rad | m]
  double time_left = 0.0;  ///< [s]
  bool stays = false;      ///< it ends with its time, not at its way-point
  bool of_route = false;  ///< a point of a route (planner/route.hpp), which says when it ends; the arm still makes room
};

}  // namespace hecaton::planner
