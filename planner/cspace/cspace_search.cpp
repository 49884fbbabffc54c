#include "planner/cspace/cspace_search.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hecaton::planner::cspace {
namespace {

/// A blocked cell on the way out of a blocked start costs as much as so many free ones.
constexpr float kBlockedCost = 100.0F;

/// Ties go to the lower index, so that the result does not depend on the heap.
constexpr auto kLater = [](const auto& a, const auto& b) {
  return a.estimate > b.estimate || (a.estimate == b.estimate && a.cell > b.cell);
};

}  // namespace

CspaceSearch::CspaceSearch(const SensedMap& map) {
  const auto cells = static_cast<std::size_t>(map.size()[0]) * map.size()[1] * map.size()[2];
  cost_.resize(cells);
  from_.resize(cells);
  round_.assign(cells, 0);
  closed_.resize(cells);
}

/// Never more than the way really is: as long as a straight line.
float CspaceSearch::left(const Cell3& cell) const {
  float sum = 0.0F;
  for (int i = 0; i < 3; ++i) {
    const auto way = static_cast<float>(to_[i] - cell[i]);
    sum += way * way;
  }
  return std::sqrt(sum);
}

void CspaceSearch::begin(const SensedMap& map, const Cell3& from, const Cell3& to) {
  ++this_round_;
  heap_.clear();
  to_ = to;
  goal_ = map.index(to);
  start_ = map.index(from);
  if (map.blocked(to)) {
    state_ = State::kNone;
    return;
  }
  state_ = State::kRunning;
  round_[start_] = this_round_;
  closed_[start_] = 0;
  cost_[start_] = 0.0F;
  from_[start_] = -1;
  heap_.push_back({left(from), start_});
}

CspaceSearch::State CspaceSearch::advance(const SensedMap& map, int cells) {
  for (int looked = 0; looked < cells && state_ == State::kRunning; ++looked) {
    if (heap_.empty()) {
      state_ = State::kNone;
      break;
    }
    std::pop_heap(heap_.begin(), heap_.end(), kLater);
    const int here = heap_.back().cell;
    heap_.pop_back();
    if (closed_[here] != 0) continue;
    closed_[here] = 1;
    if (here == goal_) {
      state_ = State::kFound;
      break;
    }
    const Cell3 at = map.cell(here);
    const bool leaving = map.blocked(at);
    for (int neighbour = 0; neighbour < 27; ++neighbour) {
      const Cell3 step{neighbour / 9 - 1, neighbour / 3 % 3 - 1, neighbour % 3 - 1};
      Cell3 next{};
      int moved = 0;
      bool inside = true;
      for (int i = 0; i < 3; ++i) {
        next[i] = at[i] + step[i];
        inside = inside && next[i] >= 0 && next[i] < map.size()[i];
        moved += step[i] * step[i];
      }
      if (!inside || moved == 0) continue;
      const bool blocked = map.blocked(next);
      if (blocked && !leaving) continue;
      const int there = map.index(next);
      const float cost = cost_[here] + std::sqrt(static_cast<float>(moved)) + (blocked ? kBlockedCost : 0.0F);
      if (round_[there] == this_round_ && cost_[there] <= cost) continue;
      round_[there] = this_round_;
      closed_[there] = 0;
      cost_[there] = cost;
      from_[there] = here;
      heap_.push_back({cost + left(next), there});
      std::push_heap(heap_.begin(), heap_.end(), kLater);
    }
  }
  return state_;
}

std::vector<Cell3> CspaceSearch::way(const SensedMap& map) const {
  std::vector<Cell3> way;
  for (int cell = goal_; cell >= 0; cell = from_[cell]) way.push_back(map.cell(cell));
  std::reverse(way.begin(), way.end());
  return way;
}

}  // namespace hecaton::planner::cspace
