#pragma once
/// An arm as the world needs it: shapes fixed to links whose poses arrive from outside.

#include <string>
#include <utility>
#include <vector>

#include "world/model/shape.hpp"

namespace hecaton::world {

struct ArmBodies {
  struct Part {
    int link = 0;  ///< index into the link poses of a measurement
    std::string link_name;
    PlacedShape shape;  ///< in the link's frame
    bool moves = true;  ///< false: fixed to the base; never judged against what cannot move either
  };
  std::string name;
  std::vector<Part> parts;
  std::vector<std::pair<int, int>> self_pairs;  ///< parts that are judged against each other
  std::vector<int> grasp_links;                 ///< links that an attached object may touch
};

}  // namespace hecaton::world
