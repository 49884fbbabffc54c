#pragma once
/// The cell that the targets are stated for: a PUMA-sized arm of 6 capsules against two more such arms and 20 boxes,
/// 192 pairs; and FCL's public pairwise distance on the same pairs.

#include <memory>
#include <random>
#include <string>
#include <vector>

#include "planner/collision/cell_geometry.hpp"

namespace hecaton::bench {

inline constexpr int kPairs = 192;

[[nodiscard]] double uniform(std::mt19937_64& random, double low, double high);

/// Six revolute joints with the PUMA 560's link lengths; a capsule along every link.
[[nodiscard]] planner::Arm puma_like(const std::string& name, const Eigen::Vector3d& base);

/// One configuration of the whole cell.
struct Instant {
  std::vector<planner::JointVector> q;          ///< of each arm
  std::vector<planner::Kinematics> kinematics;  ///< of each arm
  std::vector<world::ObstacleState> obstacles;
};

class PairsCell {
 public:
  explicit PairsCell(std::uint64_t seed);

  /// Arms and boxes anywhere, through each other too.
  [[nodiscard]] Instant draw();
  [[nodiscard]] std::mt19937_64& random() { return random_; }
  [[nodiscard]] const planner::CellGeometry& geometry() const { return geometry_; }

 private:
  std::mt19937_64 random_;
  planner::CellGeometry geometry_;
};

class FclPairs {
 public:
  explicit FclPairs(const planner::CellGeometry& geometry);
  ~FclPairs();

  /// Distances of all pairs in the order of ExactDistance::clearances; FCL answers −1 for overlapping pairs.
  void distances(const Instant& instant, std::vector<double>& out);

 private:
  struct Objects;
  const planner::CellGeometry& geometry_;
  std::unique_ptr<Objects> objects_;
};

}  // namespace hecaton::bench
