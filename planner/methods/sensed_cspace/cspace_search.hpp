#pragma once
/// The shortest way through the cells of a map that are not known to be blocked (A*), a share of the work at a time.

#include <cstdint>
#include <vector>

#include "planner/methods/sensed_cspace/sensed_map.hpp"

namespace hecaton::planner::cspace {

class CspaceSearch {
 public:
  enum class State : std::uint8_t { kIdle, kRunning, kFound, kNone };

  /// For maps of this size.
  explicit CspaceSearch(const SensedMap& map);

  /// Forgets the search: kIdle.
  void stop() { state_ = State::kIdle; }
  /// Steps go to any free cell that shares a side, an edge or a corner, if all cells about that edge or corner are
  /// free: a straight line from anywhere in the one to anywhere in the other meets nothing else.
  void begin(const SensedMap& map, const Cell3& from, const Cell3& to);
  /// Looks at up to `cells` more cells. More of the map may be blocked than when it began: then the way that is found
  /// may lead through that, but that there is none is true. Not so when the map has forgotten something.
  State advance(const SensedMap& map, int cells);
  [[nodiscard]] State state() const { return state_; }
  /// Once kFound: from the start to the goal, both included.
  [[nodiscard]] std::vector<Cell3> path(const SensedMap& map) const;

 private:
  struct Step {
    Cell3 by;
    int index;  ///< by as much the cell's index changes
    int cost;
    std::uint32_t box;  ///< neighbours about the edge or corner that it crosses and where it leads, a bit each
  };
  struct Open {
    int estimate;  ///< of the cost of the way through the cell
    int cost;      ///< up to it
    int cell;
  };
  [[nodiscard]] int left(const Cell3& cell) const;
  void open(int cell, int cost, int estimate, std::uint8_t step);
  void look_around(const SensedMap& map, int here);

  std::vector<Step> steps_;
  std::vector<int> cost_;             ///< of the way to each cell
  std::vector<std::uint8_t> step_;    ///< that led there
  std::vector<std::uint32_t> round_;  ///< of the search that touched the cell last, twice; odd: the cell is done
  std::vector<Open> heap_;
  std::uint32_t this_round_ = 0;
  State state_ = State::kIdle;
  Cell3 to_{};
  int goal_ = -1;
  int start_ = -1;
};

}  // namespace hecaton::planner::cspace
