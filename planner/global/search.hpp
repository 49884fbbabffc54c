#pragma once
/// What every sampling planner gets and gives. Each is one file: rrt_connect, rrt, est, prm.

#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "planner/global/space.hpp"
#include "planner/global/validity.hpp"

namespace hecaton::planner::global {

/// When a search gives up.
struct Budget {
  std::uint64_t iterations = 1'000'000;  ///< samples drawn
  std::function<bool()> ended;  ///< asked every now and then; empty: never. Has the clock that planners have not
};

/// How straight ways are looked at.
struct EdgeCheck {
  int finer = 1;           ///< at so many times as many configurations as the validity says
  bool proven = false;     ///< and then everywhere in between (Validity::proven_free)
  double clearance = 0.0;  ///< proven only: kept from the world beyond the validity's padding [m]

  [[nodiscard]] bool free(const Validity& validity, const float* a, const float* b) const {
    return validity.edge_free(a, b, finer) && (!proven || validity.proven_free(a, b, clearance));
  }
};

/// What a search has built, for pictures.
struct SearchRecord {
  Points nodes;
  std::vector<std::pair<int, int>> edges;  ///< of nodes
};

struct SearchProblem {
  const Validity& validity;
  const Space& space;
  const float* start;  ///< free
  const float* goal;   ///< free
  std::uint64_t seed = 1;
  Budget budget = {};
  EdgeCheck check = {};
  SearchRecord* record = nullptr;  ///< filled at the end of a search; null: not

  [[nodiscard]] bool edge_free(const float* a, const float* b) const { return check.free(validity, a, b); }

  /// Whether a search has to give up after so many samples. The budget is asked by how much has been looked at, too:
  /// with fine steps one sample may take longer than a thousand otherwise.
  [[nodiscard]] bool over(std::uint64_t iteration) const {
    if (ended || iteration >= budget.iterations) return true;
    if (!budget.ended || (iteration % 64 != 63 && validity.checks() - asked_at < kChecksUnasked)) return false;
    asked_at = validity.checks();
    ended = budget.ended();
    return ended;
  }

  static constexpr std::uint64_t kChecksUnasked = 8192;  ///< some ms at most
  mutable std::uint64_t asked_at = 0;                    ///< checks when the budget was asked
  mutable bool ended = false;
};

struct SearchResult {
  bool solved = false;
  Points path;                   ///< start … goal; every straight way between two is free
  std::uint64_t iterations = 0;  ///< samples drawn
  int nodes = 0;                 ///< of all trees, or of the roadmap
};

/// [LaValle01]'s EXTEND, in its words ([Cardenas10] fig. 9).
enum class Extend { kTrapped, kAdvanced, kReached };

struct RrtOptions {
  float range = 2.0F;       ///< the longest new edge, in joint space [rad | m]
  float rrt_range = 1.0F;   ///< RRT: the same
  float goal_bias = 0.05F;  ///< RRT: share of samples that are the goal
  /// Dynamic domain, after [Yershova05]: below 1, a node that failed to grow grows by edges shorter by this factor from
  /// then on, down to least_domain, and by longer ones again when it succeeds. Differs from the paper, which refuses
  /// samples beyond a node's domain: in seven dimensions hardly one lies within. Off (1): on MotionBenchMaker's
  /// problems 0.5 doubles the median (docs/global-planning.md).
  float domain_shrinks = 1.0F;
  float least_domain = 0.1F;  ///< [rad | m]
};

struct EstOptions {
  float range = 1.0F;         ///< new nodes lie within this of their parent, per joint [rad | m]
  float crowd_radius = 1.0F;  ///< nodes within this of each other share their chance to grow [rad | m]
  float join_range = 4.0F;    ///< trees are joined over at most this [rad | m]
};

enum class RoadmapSearch { kAStar, kDijkstra };

struct PrmOptions {
  int neighbours = 10;  ///< that a new node is joined with
  int batch = 32;       ///< nodes added between searches
  RoadmapSearch search = RoadmapSearch::kAStar;
};

[[nodiscard]] SearchResult rrt_connect(const SearchProblem& problem, const RrtOptions& options = {});
[[nodiscard]] SearchResult rrt(const SearchProblem& problem, const RrtOptions& options = {});
[[nodiscard]] SearchResult est(const SearchProblem& problem, const EstOptions& options = {});
/// With a roadmap of its own; Roadmap (prm.hpp) keeps one.
[[nodiscard]] SearchResult prm(const SearchProblem& problem, const PrmOptions& options = {});

}  // namespace hecaton::planner::global
