#pragma once
/// Ray casts against the obstacles of a cell, for distance sensors.

#include <memory>
#include <optional>
#include <span>

#include "world/model/scene.hpp"
#include "world/model/snapshot.hpp"

namespace hecaton::world {

/// Not thread-safe.
class RayCaster {
 public:
  RayCaster();
  ~RayCaster();
  RayCaster(RayCaster&&) noexcept;
  RayCaster& operator=(RayCaster&&) noexcept;

  /// Replaces the obstacles. Rays pass through carried obstacles, as through the arm that carries them.
  void set_obstacles(std::span<const Obstacle> obstacles);

  /// Distance [m] from p_W along the unit vector d_W to the nearest obstacle; 0 inside one; empty when there is none
  /// within `range` [m]. `states`: one per obstacle.
  [[nodiscard]] std::optional<double> cast(const Eigen::Vector3d& p_W, const Eigen::Vector3d& d_W, double range,
                                           std::span<const ObstacleState> states) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace hecaton::world
