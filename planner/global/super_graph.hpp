#pragma once
/// One plan for several arms, by a search in the product of their roadmaps (as in the discrete RRT of [Solovey16], but
/// with A*). It solves problems in which arms must give way in turn, where sampling all joints together fails.

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "planner/global/plan.hpp"

namespace hecaton::planner::global {

struct SuperGraphOptions {
  int nodes = 32;       ///< of each arm's first roadmap
  int doublings = 2;    ///< of the number of nodes, as long as there is no path
  int neighbours = 6;   ///< edges tried for a new node of a roadmap
  double weight = 2.0;  ///< of the heuristic; 1: shortest plans; more: faster search
  // Limits of the search, about a second each:
  std::uint64_t samples = 20'000;     ///< of each arm's roadmap, per doubling
  std::uint64_t expansions = 60'000;  ///< expanded vertices in total
  std::uint64_t checks = 2'000'000;   ///< configurations checked in total
};

/// A vertex of the product has one node per arm; an edge moves one arm along an edge of its roadmap. The product is
/// implicit, and each check of arm i on an edge against arm j at a node is cached. Complete for the given roadmaps
/// within the budget. The same seed gives the same result. Not thread-safe.
class SuperGraph {
 public:
  SuperGraph(const std::vector<CellGeometry>& planned, const ValidityOptions& options);

  /// Replaces all bodies that are not of the planned arms.
  void set_world(std::span<const WorldBody> world);

  /// Start and goal must be free for all arms together. The path is not shortened. Plan::iterations: expanded vertices.
  [[nodiscard]] Plan plan(std::span<const double> start, std::span<const double> goal, std::uint64_t seed,
                          const SuperGraphOptions& options = {});

  /// Number of configurations checked since construction.
  [[nodiscard]] std::uint64_t checks() const;

 private:
  class Search;

  [[nodiscard]] int arms() const { return static_cast<int>(alone_.size()); }
  /// The validity of arms i < k.
  [[nodiscard]] const Validity& pair(int i, int k) const { return *pairs_[i * arms() + k]; }

  std::vector<std::unique_ptr<Validity>> alone_;  ///< of each arm in the world
  std::vector<std::unique_ptr<Validity>> pairs_;  ///< of each two arms without the world
};

}  // namespace hecaton::planner::global
