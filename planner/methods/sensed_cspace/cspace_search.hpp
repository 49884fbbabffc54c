#pragma once
/// A* search for the shortest path through the free cells of a map, in shares of work.

#include <cstdint>
#include <vector>

#include "planner/methods/sensed_cspace/sensed_map.hpp"

namespace hecaton::planner::cspace {

/// Each call of advance() does a bounded share of the work. Not thread-safe.
class CspaceSearch {
 public:
  enum class State : std::uint8_t { kIdle, kRunning, kFound, kNone };

  /// For maps of the same size as `map`.
  explicit CspaceSearch(const SensedMap& map);

  /// Drops the search; the state becomes kIdle.
  void stop() { state_ = State::kIdle; }
  /// Starts a search. A step leads to a free cell that shares a side, an edge or a corner, if all cells at that edge or
  /// corner are free. So every straight line between the two cells is free.
  void begin(const SensedMap& map, const Cell3& from, const Cell3& to);
  /// Expands up to `cells` more cells. If cells were blocked since begin(), the found path may lead through them, and
  /// kNone stays valid. If cells were freed, kNone is not valid.
  State advance(const SensedMap& map, int cells);
  [[nodiscard]] State state() const { return state_; }
  /// The cells from start to goal, both included. Precondition: state() is kFound.
  [[nodiscard]] std::vector<Cell3> path(const SensedMap& map) const;

 private:
  struct Step {
    Cell3 by;
    int index;  ///< change of the cell's index
    int cost;
    std::uint32_t box;  ///< bit set of the neighbours that must be free
  };
  struct Open {
    int estimate;  ///< of the cost of a path through the cell
    int cost;      ///< from the start to the cell
    int cell;
  };
  [[nodiscard]] int left(const Cell3& cell) const;
  void open(int cell, int cost, int estimate, std::uint8_t step);
  void expand(const SensedMap& map, int here);

  std::vector<Step> steps_;
  std::vector<int> cost_;             ///< from the start to each cell
  std::vector<std::uint8_t> step_;    ///< last step to each cell
  std::vector<std::uint32_t> round_;  ///< twice the number of the last search that reached the cell; odd: expanded
  std::vector<Open> heap_;
  std::uint32_t this_round_ = 0;
  State state_ = State::kIdle;
  Cell3 to_{};
  int goal_ = -1;
  int start_ = -1;
};

}  // namespace hecaton::planner::cspace
