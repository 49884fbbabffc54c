#pragma once
/// The cell three_puma, for tests of parts of hecaton-ros2 without a running cell.

#include <string>

#include "services/config/cell_file.hpp"

namespace hecaton::test {

inline const config::CellFile& three_puma() {
  static const config::CellFile kFile = config::load_cell_file(std::string(HECATON_LIVE_CELLS) + "/three_puma.yaml");
  return kFile;
}
inline const planner::Arm& northern_arm() {
  return three_puma().cell.arms[0].arm;
}

}  // namespace hecaton::test
