#pragma once
/// The safe mapping of obstacles into the C-space of a planar arm: no cell is missed in whose centre the arm touches
/// the obstacle, and none is blocked in whose centre it does not.

#include <memory>
#include <vector>

#include "planner/methods/sensed_cspace/cspace_map.hpp"
#include "planner/methods/sensed_cspace/planar_geometry.hpp"

namespace hecaton::planner::cspace {

/// differs from paper: [Li96] stores the images of forty points and takes an obstacle for the fundamental obstacles
/// next to its critical points, which misses up to a third of its cells. Here the images of corners and sides are
/// computed, row by row, without trigonometry; that takes no longer. docs/design/0011-sensed-cspace.md has the proof.
enum class Links { kBoth, kFirst, kSecond };

class ObstacleMapper {
 public:
  /// The grid divides both joints; its number of cells is a multiple of 4 and at most 16384.
  ObstacleMapper(const PlanarArm& arm, AngleGrid grid);

  [[nodiscard]] const PlanarArm& arm() const { return arm_; }
  [[nodiscard]] const AngleGrid& grid() const { return grid_; }

  /// Fills `image` with the cells in whose centre the arm is nearer to the obstacle than its links' widths. No
  /// allocation once `image` has had as many rows before. Not for several threads at once: scratch is kept.
  /// `links`: what may touch it; the others pass it above or below.
  void map(const ConvexPiece& obstacle, ObstacleImage& image, Links links = Links::kBoth);

 private:
  struct Rows {
    int first = 0;
    int count = 0;
  };
  [[nodiscard]] Rows rows_in_reach(const ConvexPiece& obstacle) const;
  [[nodiscard]] RowSpan cells_between(double right, double left) const;
  void block_second_link(const ConvexPiece& obstacle, ObstacleImage& image);
  void block_first_link(const ConvexPiece& obstacle, ObstacleImage& image);

  PlanarArm arm_;
  AngleGrid grid_;
  std::vector<double> cosine_, sine_;      ///< of the rows' centres, twice round and a little more
  std::vector<double> elbow_x_, elbow_y_;  ///< [m]
  std::vector<double> right_, left_;       ///< scratch
};

}  // namespace hecaton::planner::cspace
