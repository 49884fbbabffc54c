#pragma once
/// Expansive space trees [Hsu00]: two trees that grow where they are sparse, joined as soon as their ends see each
/// other.

#include "planner/global/global_planner.hpp"

namespace hecaton::planner::global {

struct EstParameters {
  float range = 1.0F;         ///< new nodes lie within this of their parent, per joint [rad | m]
  float crowd_radius = 1.0F;  ///< nodes within this of each other share their chance to grow [rad | m]
  float join_range = 4.0F;    ///< trees are joined over at most this [rad | m]
};

class Est final : public GlobalPlanner {
 public:
  explicit Est(const EstParameters& parameters = {});
  [[nodiscard]] SearchResult search(const SearchProblem& problem) const override;

 private:
  EstParameters parameters_;
};

}  // namespace hecaton::planner::global
