#pragma once
/// Edits of the world as their messages ask for them.

#include <idl/world.h>

#include "planner/cell.hpp"
#include "services/config/obstacle_place.hpp"
#include "world/sim/bullet_world.hpp"

namespace hecaton::services {

/// Among whom an edit is made.
struct EditedCell {
  std::span<const planner::PlannedArm> arms;
  config::MeasuredJoints q;  ///< of each arm
};

/// Done, or one sentence that says why not; then nothing has changed. The rules are those of the cell file: what an
/// obstacle may be, that it must be clear of the arms, and that what an arm takes must be near its tool.
[[nodiscard]] world::EditResult apply_edit(world::BulletWorld& world, const EditedCell& cell,
                                           const msg::WorldEditRequest& request);

/// As in the reply: CAUSE_NONE when it was done.
[[nodiscard]] msg::Cause cause_of(const world::EditResult& result);

/// The obstacle that a request is about.
[[nodiscard]] const std::string& edited_name(const msg::WorldEditRequest& request);

}  // namespace hecaton::services
