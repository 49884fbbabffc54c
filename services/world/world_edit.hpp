#pragma once
/// Edits of the world as their messages ask for them.

#include <idl/world.h>

#include "world/sim/bullet_world.hpp"

namespace hecaton::services {

/// Done, or one sentence that says why not; then nothing has changed.
[[nodiscard]] world::EditResult apply_edit(world::BulletWorld& world, const msg::WorldEditRequest& request);

/// The obstacle that a request is about.
[[nodiscard]] const std::string& edited_name(const msg::WorldEditRequest& request);

}  // namespace hecaton::services
