#pragma once
/// The shortest way through the cells of a map that are not known to be blocked (A*), a share of the work at a time.

#include <cstdint>
#include <vector>

#include "planner/cspace/sensed_map.hpp"

namespace hecaton::planner::cspace {

class CspaceSearch {
 public:
  enum class State : std::uint8_t { kIdle, kRunning, kFound, kNone };

  /// For maps of this size.
  explicit CspaceSearch(const SensedMap& map);

  /// Steps go to any cell that shares a side, an edge or a corner. A start that is blocked may be left, through as few
  /// blocked cells as possible; other blocked cells are never entered.
  void begin(const SensedMap& map, const Cell3& from, const Cell3& to);
  /// Looks at up to `cells` more cells. `map`: as when it began.
  State advance(const SensedMap& map, int cells);
  [[nodiscard]] State state() const { return state_; }
  /// Once kFound: from the start to the goal, both included.
  [[nodiscard]] std::vector<Cell3> way(const SensedMap& map) const;

 private:
  struct Open {
    float estimate;  ///< of the way through the cell
    int cell;
  };
  [[nodiscard]] float left(const Cell3& cell) const;

  std::vector<float> cost_;           ///< of the way to each cell, in cells
  std::vector<int> from_;             ///< the cell before
  std::vector<std::uint32_t> round_;  ///< of the search that touched the cell last
  std::vector<std::uint8_t> closed_;
  std::vector<Open> heap_;
  std::uint32_t this_round_ = 0;
  State state_ = State::kIdle;
  Cell3 to_{};
  int goal_ = -1;
  int start_ = -1;
};

}  // namespace hecaton::planner::cspace
