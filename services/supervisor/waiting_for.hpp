#pragma once
/// Why an arm stands still, in one sentence for people: the first of the reasons, from the strictest down.

#include <string>

#include "services/supervisor/cell_watch.hpp"
#include "services/supervisor/picture.hpp"

namespace hecaton::services {

/// CAUSE_NONE while it moves.
[[nodiscard]] msg::Cause waiting_for(const std::string& arm, const CellWatch& watch, const Picture& picture);

/// "blocked: no way for now (arm2/link4 – pallet, 18 mm)"
[[nodiscard]] std::string goal_text(const msg::GoalStatus& goal);

}  // namespace hecaton::services
