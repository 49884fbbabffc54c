#pragma once
/// Ray casts against the obstacles of a cell, for distance sensors.

#include <memory>
#include <optional>
#include <span>

#include "world/model/present_states.hpp"
#include "world/model/scene.hpp"
#include "world/model/snapshot.hpp"

namespace hecaton::world {

/// Several threads may cast rays at the same time, while none calls another function.
class RayCaster {
 public:
  RayCaster();
  ~RayCaster();
  RayCaster(RayCaster&&) noexcept;
  RayCaster& operator=(RayCaster&&) noexcept;

  /// Replaces the obstacles. Rays pass through carried obstacles, as through the arm that carries them. Until place()
  /// there are none.
  void set_obstacles(std::span<const Obstacle> obstacles);
  /// One state per obstacle. Reads those with a greater number than at the last call. Throws std::invalid_argument when
  /// one is missing.
  void place(const PresentStates& states);

  /// Distance [m] from p_W along the unit vector d_W to the nearest obstacle; 0 inside one; empty when there is none
  /// within `range` [m].
  [[nodiscard]] std::optional<double> cast(const Eigen::Vector3d& p_W, const Eigen::Vector3d& d_W, double range) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace hecaton::world
