#pragma once
/// What a world writes down of itself, so that its successor goes on where it died.

#include <cstdint>

#include <idl/world.h>

#include "services/messages/convert.hpp"
#include "world/sim/bullet_world.hpp"

namespace hecaton::services {

/// Cell and stamp are left to the caller.
[[nodiscard]] msg::WorldMemory memory_of(const world::BulletWorld& world);

/// Where a world goes on.
struct Continuation {
  world::Scene scene;
  double time = 0.0;          ///< of the world [s]
  std::int64_t stamp_ns = 0;  ///< when that was, on this host's steady clock
  std::uint64_t edition = 0;
  world::RefereeMemory account;
};
/// `scene`: of the cell file, for all but the obstacles.
messages::Converted<Continuation> continuation(const msg::WorldMemory& memory, const world::Scene& scene);

}  // namespace hecaton::services
