#pragma once
/// Where planners want to move their arms, as lines of the tools for the page.

#include "services/view/cell_feed.hpp"
#include "services/view/json.hpp"

namespace hecaton::services::view {

/// For each arm the way of its tool in W [m], from the measured position on: along the points that its planner goes
/// through next, each joint at an even speed, and along what is left of its newest rollout. A list is empty without
/// such points, when the planner is silent, and when the arm has not been measured. Pure, but for the time of the feed.
[[nodiscard]] Json motions_json(const CellFeed& feed);

}  // namespace hecaton::services::view
