#pragma once
/// What the page needs again and again: states at the rate of its pictures, and the status a few times a second. All
/// functions are pure, but for the time that a feed reads.

#include "services/bus/mailbox.hpp"
#include "services/view/cell_feed.hpp"
#include "services/view/json.hpp"

namespace hecaton::services::view {

/// Joint positions of all arms with their ages, and poses of all obstacles. `t`: when the server sends it, on a clock
/// that runs evenly, also while a recording is paused.
[[nodiscard]] Json frame_json(const CellFeed& feed, bus::Clock::duration t);

/// Mode, arms with goals and reasons, nodes, faults, contacts. `t`: as above.
[[nodiscard]] Json status_json(const CellFeed& feed, bus::Clock::duration t);

/// The shapes of all obstacles. An obstacle with an unusable message is left out.
[[nodiscard]] Json obstacles_json(const CellState& cell);

}  // namespace hecaton::services::view
