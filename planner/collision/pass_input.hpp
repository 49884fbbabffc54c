#pragma once
/// The input of a distance pass: poses, and influence distances.

#include <algorithm>
#include <limits>
#include <optional>
#include <span>

#include "planner/collision/pass_kernels.hpp"
#include "planner/model/kinematics.hpp"
#include "world/model/snapshot.hpp"

namespace hecaton::planner {

/// Poses of all bodies during one pass. Refers to the caller's storage.
struct CellPoses {
  const Kinematics* own = nullptr;
  std::span<const Kinematics> arms;                 ///< one per arm of the cell; the pass ignores the own entry
  std::span<const world::ObstacleState> obstacles;  ///< one per obstacle of the CellGeometry
};

/// The influence distances of a pass. Without own speeds `others` and `self` apply, else the other members.
struct InfluenceDistances {
  double others = 0.0;                   ///< against obstacles and other arms [m]
  double self = 0.0;                     ///< between bodies of the own arm [m]
  std::span<const double> own_speed{};   ///< upper bound for all points of own body i [m/s]; empty, or one per own body
  std::span<const Reach> of_arm{};       ///< one per arm of the cell
  std::span<const Reach> of_obstacle{};  ///< one per obstacle, or one for all of them
  Reach of_self{};                       ///< of the sum of both bodies' speeds
  std::optional<std::span<const int>> near_arms{};  ///< the other arms to test, ascending; empty: all
  /// The influence distance of a self pair is at most this share, above 0, of CellGeometry::widest(): every posture has
  /// the pair nearer than its widest distance.
  double self_share = std::numeric_limits<double>::infinity();

  [[nodiscard]] Reach against_arm(int arm) const {
    return own_speed.empty() ? Reach{others, others, 0.0} : of_arm[arm];
  }
  [[nodiscard]] Reach against_obstacle(int obstacle) const {
    return own_speed.empty() ? Reach{others, others, 0.0} : of_obstacle[of_obstacle.size() == 1 ? 0 : obstacle];
  }
  [[nodiscard]] double against_self(int first, int second) const {
    return own_speed.empty() ? self : distance(of_self, own_speed[first] + own_speed[second]);
  }
  /// The influence distance [m] of a pair whose own body moves no faster than `speed` [m/s].
  [[nodiscard]] static double distance(const Reach& reach, double speed) {
    return std::max(reach.at_rest, reach.moving + reach.per_speed * speed);
  }
};

}  // namespace hecaton::planner
