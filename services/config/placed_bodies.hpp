#pragma once
/// The bodies of a cell in given configurations, and the nearest pairs among them.

#include <span>
#include <string>
#include <vector>

#include "planner/cell.hpp"
#include "planner/collision/cell_geometry.hpp"

namespace hecaton::config {

/// A body where it stands.
struct PlacedBody {
  planner::Body body;
  world::Pose X_WS = world::Pose::Identity();
  std::string name;  ///< "left/forearm", "pillar"
};

struct NearestPair {
  bool found = false;
  std::string a;
  std::string b;
  double distance = 0.0;  ///< [m]; negative: depth of penetration
};

/// Bodies of the arm with its joints at q, then what it carries. `obstacles`: those of the geometry.
[[nodiscard]] std::vector<PlacedBody> place_arm(std::span<const world::Obstacle> obstacles,
                                                const planner::CellGeometry& geometry, int arm,
                                                const planner::JointVector& q);

/// Bodies of the geometry's obstacle `index`, which is not attached.
[[nodiscard]] std::vector<PlacedBody> place_obstacle(const planner::CellGeometry& geometry, const std::string& name,
                                                     const world::Pose& X_WO, int index);
/// The same at t = 0.
[[nodiscard]] std::vector<PlacedBody> place_obstacle(const planner::CellGeometry& geometry,
                                                     const world::Obstacle& obstacle, int index);

/// The nearest pair among those that are nearer than `within` [m]. `moving_a_only` leaves out bodies of a that
/// no joint moves.
[[nodiscard]] NearestPair nearest_pair(const std::vector<PlacedBody>& a, const std::vector<PlacedBody>& b,
                                       double within, bool moving_a_only);

/// The deepest overlap of an obstacle with those of an arm's bodies that a joint moves: nothing may begin so. Parts
/// that no joint moves may stand in an obstacle, as a base stands on a table.
[[nodiscard]] NearestPair overlap_of_moving(const std::vector<PlacedBody>& arm,
                                            const std::vector<PlacedBody>& obstacle);

/// The nearest of the listed pairs of one arm's bodies.
[[nodiscard]] NearestPair nearest_self_pair(const std::vector<PlacedBody>& bodies,
                                            const std::vector<std::pair<int, int>>& pairs, double within);

/// "left/forearm and pillar overlap by 12.3 mm"
[[nodiscard]] std::string overlap_text(const NearestPair& pair);

}  // namespace hecaton::config
