#pragma once
/// RRT-Connect [Kuffner00]: two trees, from start and goal; each tree tries to connect to the other's new node.

#include "planner/global/global_planner.hpp"

namespace hecaton::planner::global {

struct RrtConnectParameters {
  float range = 1.0F;  ///< longest new edge, in joint space [rad | m]
  /// Dynamic domain, after [Yershova05]; 1: off. A node whose extension failed gets shorter edges by this factor, down
  /// to min_domain, and longer ones again after a success. The paper rejects samples beyond a node's domain instead; in
  /// seven dimensions hardly any sample lies within. On MotionBenchMaker, 0.5 doubles the median
  /// (docs/explanation/global-planning.md).
  float domain_factor = 1.0F;
  float min_domain = 0.1F;  ///< [rad | m]
};

class RrtConnect final : public GlobalPlanner {
 public:
  explicit RrtConnect(const RrtConnectParameters& parameters = {});
  [[nodiscard]] SearchResult search(const SearchProblem& problem) const override;

 private:
  RrtConnectParameters parameters_;
};

}  // namespace hecaton::planner::global
