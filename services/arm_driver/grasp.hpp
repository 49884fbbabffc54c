#pragma once
/// What a gripper would hold when its fingers close. Pure.

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "planner/model/arm.hpp"
#include "world/model/scene.hpp"

namespace hecaton::services {

struct Grasp {
  std::string obstacle;           ///< that the fingers touch first
  std::vector<double> positions;  ///< of the joints outside the chain just before they touch it [rad | m]
};

/// The joints outside the chain move from `from` to `to`, all in the same time, while the arm stands at `q`. Two links
/// of them must touch an obstacle (the only one, if one link moves): else it is not between fingers. `obstacles`: free
/// ones, X_WO where they are now. Empty: the fingers reach `to` without such an obstacle. Allocates.
[[nodiscard]] std::optional<Grasp> find_grasp(const planner::Arm& arm, const planner::JointVector& q,
                                              const std::vector<double>& from, const std::vector<double>& to,
                                              std::span<const world::Obstacle> obstacles);

}  // namespace hecaton::services
