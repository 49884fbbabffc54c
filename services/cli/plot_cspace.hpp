#pragma once
/// Pictures like [Li96] figure 4: an arm in its workspace and, beside it, what it knows of its C-space.

#include <string>
#include <vector>

#include "planner/methods/sensed_cspace/sensed_planner.hpp"
#include "planner/simulation/batch.hpp"

namespace hecaton::services::cli {

/// What an arm that plans in C-space knows of it; null for others.
[[nodiscard]] const planner::cspace::SensedPlanner* cspace_of(const planner::ArmController& controller);

/// One instant of an arm that plans through C-space, as an SVG. `trace`: where it has been, oldest first. Left: the
/// obstacles as they are (grey; an arm that senses does not know them), the arm, the points it has seen and the goal
/// (pale green), in the plane of the arm's last two joints. Right: θ₁ across, θ₂ upwards; for three joints in the
/// present θ₀'s plane.
[[nodiscard]] std::string plot_cspace(const planner::EpisodeMoment& moment, int arm,
                                      const std::vector<planner::JointVector>& trace);

}  // namespace hecaton::services::cli
