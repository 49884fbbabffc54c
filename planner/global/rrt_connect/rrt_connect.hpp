#pragma once
/// RRT-Connect [Kuffner00]: two trees, from start and goal; each new node of one is what the other tries to connect to.

#include "planner/global/global_planner.hpp"

namespace hecaton::planner::global {

struct RrtConnectParameters {
  float range = 2.0F;  ///< the longest new edge, in joint space [rad | m]
  /// Dynamic domain, after [Yershova05]: below 1, a node that failed to grow grows by edges shorter by this factor from
  /// then on, down to least_domain, and by longer ones again when it succeeds. Differs from the paper, which refuses
  /// samples beyond a node's domain: in seven dimensions hardly one lies within. Off (1): on MotionBenchMaker's
  /// problems 0.5 doubles the median (docs/global-planning.md).
  float domain_shrinks = 1.0F;
  float least_domain = 0.1F;  ///< [rad | m]
};

class RrtConnect final : public GlobalPlanner {
 public:
  explicit RrtConnect(const RrtConnectParameters& parameters = {});
  [[nodiscard]] SearchResult search(const SearchProblem& problem) const override;

 private:
  RrtConnectParameters parameters_;
};

}  // namespace hecaton::planner::global
