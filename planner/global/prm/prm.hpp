#pragma once
/// Probabilistic roadmaps [Kavraki96]: random free configurations, joined with their neighbours, and the shortest path
/// between them. A roadmap serves one query.

#include "planner/global/global_planner.hpp"

namespace hecaton::planner::global {

enum class RoadmapSearch { kAStar, kDijkstra };

struct PrmParameters {
  int neighbours = 10;  ///< edges tried for a new node
  int batch = 32;       ///< nodes added between two searches
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
