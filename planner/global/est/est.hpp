#pragma once
/// Expansive space trees [Hsu00]: two trees, which grow where they are sparse, until an edge joins them.

#include "planner/global/global_planner.hpp"

namespace hecaton::planner::global {

struct EstParameters {
  float range = 1.0F;           ///< a new node lies within this of its parent, per joint [rad | m]
  float density_radius = 1.0F;  ///< nodes within this count as neighbours [rad | m]
  float join_range = 4.0F;      ///< longest edge that joins the trees [rad | m]
};

class Est final : public GlobalPlanner {
 public:
  explicit Est(const EstParameters& parameters = {});
  [[nodiscard]] SearchResult search(const SearchProblem& problem) const override;

 private:
  EstParameters parameters_;
};

}  // namespace hecaton::planner::global
