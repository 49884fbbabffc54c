#pragma once
/// Why an arm stands still, in one sentence for people: the first of the reasons, from the strictest down.

#include <string>

#include "services/supervisor/detection/fault_detector.hpp"
#include "services/supervisor/picture.hpp"

namespace hecaton::services {

/// Empty while it moves.
[[nodiscard]] std::string waiting_for(const std::string& arm, const FaultDetector& watch, const Picture& picture);

/// "blocked: no way for now (arm2/link4 – pallet, 18 mm)"
[[nodiscard]] std::string goal_text(const msg::GoalStatus& goal);

}  // namespace hecaton::services
