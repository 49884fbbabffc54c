#pragma once
/// The exact mapping of obstacles into the C-space of a planar arm.

#include <memory>
#include <vector>

#include "planner/methods/sensed_cspace/cspace_map.hpp"
#include "planner/methods/sensed_cspace/planar_geometry.hpp"

namespace hecaton::planner::cspace {

/// The links that can touch an obstacle.
enum class Links { kBoth, kFirst, kSecond };

/// Blocks exactly the cells in whose centre the arm touches the obstacle (docs/explanation/0011-sensed-cspace.md has
/// the proof). Not thread-safe.
///
/// differs from paper: [Li96] stores the images of forty points and represents an obstacle by its critical points,
/// which misses up to a third of the cells. This class computes the images of corners and sides row by row, in similar
/// time.
class ObstacleMapper {
 public:
  /// `grid`: of both joints. Precondition: its number of cells is a multiple of 4 and at most 16384.
  ObstacleMapper(const PlanarArm& arm, AngleGrid grid);

  [[nodiscard]] const PlanarArm& arm() const { return arm_; }
  [[nodiscard]] const AngleGrid& grid() const { return grid_; }

  /// Fills `image` with the cells in whose centre the arm is nearer to the obstacle than its links' widths. `links`:
  /// other links pass above or below the obstacle. No allocation if `image` has held as many rows before.
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
  std::vector<double> cosine_, sine_;      ///< of the rows' centres over two turns, padded
  std::vector<double> elbow_x_, elbow_y_;  ///< [m]
  std::vector<double> right_, left_;       ///< scratch
};

}  // namespace hecaton::planner::cspace
