#pragma once
/// The contact monitor's broad phase: pairs between the same two sides, each an arm's links or an obstacle, are one block with
/// one bound.

#include <array>
#include <span>
#include <vector>

#include "world/sim/monitored_pair.hpp"

namespace hecaton::world {

/// Pairs [first, end) of MonitoredPairs::pairs(), all of one block.
struct PairRun {
  int first = 0;
  int end = 0;
};

/// A block keeps the least of its pairs' lower bounds. While what its two sides have moved since cannot have used that
/// up, none of its pairs needs to be looked at: their own bounds, which count their own parts' motion only, would spare
/// each of them as well.
class PairBlocks {
 public:
  /// Of these pairs, in their order. `side_of_part`: of the parts that pairs name. No bound is known afterwards.
  void rebuild(std::span<const MonitoredPair> pairs, std::span<const int> side_of_part);
  /// After pairs' states changed otherwise than by judging.
  void forget_bounds();

  /// The pairs that must be looked at, ascending. Valid until the next call. `travel`: of each side, no point of it has
  /// moved further since the beginning [m]. `smallest`: of each kind, below which a distance matters [m].
  [[nodiscard]] std::span<const PairRun> open(std::span<const double> travel,
                                              const std::array<double, kContactKinds>& smallest);
  /// After all of those were looked at. `part_travel`: of each part [m].
  void close(std::span<const MonitoredPair> pairs, std::span<const double> part_travel, std::span<const double> travel);

 private:
  struct Block {
    int a = 0;  ///< sides
    int b = 0;
    ContactKind kind = ContactKind::kArmArm;
    double lower_ref = 0.0;  ///< no pair is nearer than this − travel of both sides [m]
  };

  std::vector<Block> blocks_;
  std::vector<std::vector<PairRun>> runs_;  ///< of each block
  std::vector<int> open_;                   ///< blocks
  std::vector<PairRun> open_runs_;
};

}  // namespace hecaton::world
