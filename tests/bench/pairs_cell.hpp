#pragma once
/// The cell that the targets are stated for: a PUMA-sized arm of 6 capsules against two more such arms and 20 boxes,
/// 192 pairs.

#include <random>
#include <string>
#include <vector>

#include "planner/collision/cell_geometry.hpp"

namespace hecaton::bench {

inline constexpr int kPairs = 192;

[[nodiscard]] double uniform(std::mt19937_64& random, double low, double high);

/// Six revolute joints with the PUMA 560's link lengths; along every link a capsule, or the cylinder in it.
[[nodiscard]] planner::Arm puma_like(const std::string& name, const Eigen::Vector3d& base,
                                     planner::LinkShapes shapes = planner::LinkShapes::kFast);

/// One configuration of the whole cell.
struct Instant {
  std::vector<planner::JointVector> q;          ///< of each arm
  std::vector<planner::Kinematics> kinematics;  ///< of each arm
  std::vector<world::ObstacleState> obstacles;
};

class PairsCell {
 public:
  /// With capsules, which `geometry: fast` would make of the links, or cylinders measured as such.
  explicit PairsCell(std::uint64_t seed, planner::LinkShapes shapes = planner::LinkShapes::kFast);

  /// Arms and boxes anywhere, through each other too.
  [[nodiscard]] Instant draw();
  [[nodiscard]] std::mt19937_64& random() { return random_; }
  [[nodiscard]] const planner::CellGeometry& geometry() const { return geometry_; }
  [[nodiscard]] const std::vector<world::Obstacle>& obstacles() const { return obstacles_; }

 private:
  std::mt19937_64 random_;
  std::vector<world::Obstacle> obstacles_;
  planner::CellGeometry geometry_;
};

}  // namespace hecaton::bench
