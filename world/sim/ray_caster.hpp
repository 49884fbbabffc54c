#pragma once
/// What a beam hits: Bullet's ray casts against the obstacles of a cell.

#include <memory>
#include <optional>
#include <span>

#include "world/model/scene.hpp"
#include "world/model/snapshot.hpp"

namespace hecaton::world {

class RayCaster {
 public:
  RayCaster();
  ~RayCaster();
  RayCaster(RayCaster&&) noexcept;
  RayCaster& operator=(RayCaster&&) noexcept;

  /// Replaces the obstacles. What an arm carries is never hit: it is part of the arm.
  void set_obstacles(std::span<const Obstacle> obstacles);

  /// Distance [m] from p_W along the unit vector d_W to the nearest obstacle within `range` [m]; 0 inside of one.
  /// `states`: one per obstacle.
  [[nodiscard]] std::optional<double> cast(const Eigen::Vector3d& p_W, const Eigen::Vector3d& d_W, double range,
                                           std::span<const ObstacleState> states) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace hecaton::world
