#pragma once
/// Probabilistic roadmaps [Kavraki96]: random free configurations, joined with their neighbours, and the shortest way
/// over them. A roadmap lasts for one query.

#include "planner/global/global_planner.hpp"

namespace hecaton::planner::global {

enum class RoadmapSearch { kAStar, kDijkstra };

struct PrmParameters {
  int neighbours = 10;  ///< that a new node is joined with
  int batch = 32;       ///< nodes added between searches
  RoadmapSearch search = RoadmapSearch::kAStar;
};

class Prm final : public GlobalPlanner {
 public:
  explicit Prm(const PrmParameters& parameters = {});
  [[nodiscard]] SearchResult search(const SearchProblem& problem) const override;

 private:
  PrmParameters parameters_;
};

}  // namespace hecaton::planner::global
