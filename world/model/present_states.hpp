#pragma once
/// The obstacles as they are now, for readers that look only at what has changed.

#include <cstdint>
#include <span>
#include <vector>

#include "world/model/snapshot.hpp"

namespace hecaton::world {

/// States of all obstacles, for readers that look only at what has changed. Views: their owner must outlive them.
struct PresentStates {
  PresentStates() = default;
  /// All states may have changed.
  PresentStates(const std::vector<ObstacleState>& all) : states(all) {}
  PresentStates(std::span<const ObstacleState> all, std::span<const std::uint64_t> changed = {})
      : states(all), changes(changed) {}

  std::span<const ObstacleState> states;
  /// Of each obstacle: number of the last change of its pose, > 0. Later changes have greater numbers. Empty: all poses
  /// may have changed.
  std::span<const std::uint64_t> changes;
};

}  // namespace hecaton::world
