#pragma once
/// Pictures like [Cardenas10] figures 7, 10 and 11: what a search has built in a configuration space of two dimensions.

#include <string>
#include <vector>

#include "planner/global/global_planner.hpp"

namespace hecaton::services::cli {

struct GraphPicture {
  const planner::global::Validity& validity;  ///< of two dimensions
  const planner::global::Space& space;
  const planner::global::SearchRecord& record;
  std::vector<std::vector<double>> found;  ///< the path as the search found it; empty: none [rad | m]
  std::vector<std::vector<double>> path;   ///< as it was shortened
  std::vector<double> start;
  std::vector<double> goal;
  std::string across;  ///< names of the coordinates
  std::string up;
};

/// What goes into an SVG of `side` by `side` pixels: blocked configurations in grey, the tree or roadmap in blue, the
/// path as it was found in orange, as it was shortened in black; the start orange, the goal green.
[[nodiscard]] std::string graph_panel(const GraphPicture& picture, double side);

}  // namespace hecaton::services::cli
