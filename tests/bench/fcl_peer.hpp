#pragma once
/// FCL's public distances in a cell of ours: the peer that passes and ticks are timed beside.

#include <memory>
#include <vector>

#include "planner/collision/cell_geometry.hpp"
#include "tests/bench/pairs_cell.hpp"

namespace hecaton::bench {

/// Either call first puts all bodies where they are at the instant: a planner that has heard of it must do so, too.
class FclPeer {
 public:
  explicit FclPeer(const planner::CellGeometry& geometry);
  ~FclPeer();

  /// Of all pairs of the arm's bodies with others', in the order of ExactDistance::clearances, and without broad phase;
  /// FCL answers −1 for overlapping pairs.
  void distances(int arm, const Instant& instant, std::vector<double>& out);
  /// Those nearer than `influence` [m], which its tree of bounding boxes finds.
  void distances_by_tree(int arm, const Instant& instant, double influence, std::vector<double>& out);

 private:
  struct Objects;
  void place(const Instant& instant);

  const planner::CellGeometry& geometry_;
  std::unique_ptr<Objects> objects_;
};

}  // namespace hecaton::bench
