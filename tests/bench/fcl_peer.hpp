#pragma once
/// FCL's distances in a Hecaton cell: the peer of distance passes and ticks.

#include <memory>
#include <vector>

#include "planner/collision/cell_geometry.hpp"
#include "tests/bench/pairs_cell.hpp"

namespace hecaton::bench {

/// Both functions first place all bodies, as a planner must, too.
class FclPeer {
 public:
  explicit FclPeer(const planner::CellGeometry& geometry);
  ~FclPeer();

  /// The distances of all pairs of the arm's bodies with other bodies, in the order of ExactDistance::clearances,
  /// without broad phase. FCL returns −1 for overlapping pairs.
  void distances(int arm, const Instant& instant, std::vector<double>& out);
  /// The pairs nearer than `influence` [m], found by FCL's tree of bounding boxes.
  void distances_by_tree(int arm, const Instant& instant, double influence, std::vector<double>& out);

 private:
  struct Objects;
  void place(const Instant& instant);

  const planner::CellGeometry& geometry_;
  std::unique_ptr<Objects> objects_;
};

}  // namespace hecaton::bench
