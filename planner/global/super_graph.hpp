#pragma once
/// One plan for several arms, over the product of their roadmaps (the idea of [Solovey16]'s discrete RRT, searched by
/// its costs): where arms must make room for each other in turn, samples of all joints together hit nothing.

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "planner/global/arm_roadmap.hpp"
#include "planner/global/plan.hpp"

namespace hecaton::planner::global {

struct SuperGraphOptions {
  int nodes = 32;       ///< of each arm's roadmap at first
  int doublings = 2;    ///< of that, where there is no way
  int neighbours = 6;   ///< that a node of a roadmap is joined with
  double weight = 2.0;  ///< of the way to come; 1: shortest plans, more: sooner ones
  // When the search gives up, about a second each:
  std::uint64_t samples = 20'000;     ///< for each arm's roadmap, each time
  std::uint64_t expansions = 60'000;  ///< vertices that were gone on from, in all
  std::uint64_t checks = 2'000'000;   ///< configurations looked at, in all
};

/// The product is never built: a vertex is a node for each arm, and from there one arm at a time goes along an edge of
/// its roadmap. Whether arm i on an edge has room from arm j at a node is looked at once and remembered. Complete for
/// the roadmaps as they are, as far as the budget goes; the same for the same seed.
class SuperGraph {
 public:
  SuperGraph(const std::vector<CellGeometry>& planned, const ValidityOptions& options);

  /// What stands, but for the planned arms.
  void set_world(std::span<const WorldBody> world);

  /// Start and goal are free for all arms together. The path is not simplified. iterations: vertices that were gone on
  /// from.
  [[nodiscard]] Plan plan(std::span<const double> start, std::span<const double> goal, std::uint64_t seed,
                          const SuperGraphOptions& options = {});

  /// Configurations looked at since construction.
  [[nodiscard]] std::uint64_t checks() const;

 private:
  class Search;

  [[nodiscard]] int arms() const { return static_cast<int>(alone_.size()); }
  /// Of arms i < k.
  [[nodiscard]] const Validity& pair(int i, int k) const { return *pairs_[i * arms() + k]; }

  std::vector<std::unique_ptr<Validity>> alone_;  ///< of each arm, in the world
  std::vector<std::unique_ptr<Validity>> pairs_;  ///< of each two arms, without the world
};

}  // namespace hecaton::planner::global
