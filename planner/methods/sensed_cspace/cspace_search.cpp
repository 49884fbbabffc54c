#include "planner/methods/sensed_cspace/cspace_search.hpp"

#include <algorithm>
#include <array>

namespace hecaton::planner::cspace {
namespace {

/// Cost of a step in one, two or three angles: 1 : √2 : √3 within 0.3 %. Integers, so that sums are equal on every
/// machine.
constexpr std::array<int, 4> kStepCost{0, 70, 99, 121};

/// Order of the heap: least estimate, then largest cost (nearer to the goal), then lowest index. So the result does not
/// depend on the heap.
constexpr auto kLater = [](const auto& a, const auto& b) {
  if (a.estimate != b.estimate) return a.estimate > b.estimate;
  return a.cost != b.cost ? a.cost < b.cost : a.cell > b.cell;
};

Cell3 beside(const Cell3& cell, const Cell3& by) {
  return {cell[0] + by[0], cell[1] + by[1], cell[2] + by[2]};
}

/// True if `step` moves only along components of `whole`.
bool is_part(const Cell3& step, const Cell3& whole) {
  for (int i = 0; i < 3; ++i) {
    if (step[i] != 0 && step[i] != whole[i]) return false;
  }
  return true;
}

}  // namespace

CspaceSearch::CspaceSearch(const SensedMap& map) {
  const auto cells = static_cast<std::size_t>(map.size()[0]) * map.size()[1] * map.size()[2];
  cost_.resize(cells);
  step_.resize(cells);
  round_.assign(cells, 0);
  const int most = map.size()[0] > 1 ? 1 : 0;
  for (int a = -most; a <= most; ++a) {
    for (int b = -1; b <= 1; ++b) {
      for (int c = -1; c <= 1; ++c) {
        const Cell3 by{a, b, c};
        const int moved = std::abs(a) + std::abs(b) + std::abs(c);
        if (moved > 0) steps_.push_back({by, map.index(by), kStepCost[moved], 0});
      }
    }
  }
  for (Step& step : steps_) {
    for (std::size_t k = 0; k < steps_.size(); ++k) {
      if (is_part(steps_[k].by, step.by)) step.box |= 1U << k;
    }
  }
}

/// Lower bound of the cost to the goal: the cost in an empty map, with steps in three angles first, then in two, then
/// in one. The bound is consistent.
int CspaceSearch::left(const Cell3& cell) const {
  const int a = std::abs(to_[0] - cell[0]);
  const int b = std::abs(to_[1] - cell[1]);
  const int c = std::abs(to_[2] - cell[2]);
  const int most = std::max({a, b, c});
  const int least = std::min({a, b, c});
  const int middle = a + b + c - most - least;
  return least * kStepCost[3] + (middle - least) * kStepCost[2] + (most - middle) * kStepCost[1];
}

void CspaceSearch::open(int cell, int cost, int estimate, std::uint8_t step) {
  round_[cell] = this_round_;
  cost_[cell] = cost;
  step_[cell] = step;
  heap_.push_back({estimate, cost, cell});
  std::push_heap(heap_.begin(), heap_.end(), kLater);
}

void CspaceSearch::begin(const SensedMap& map, const Cell3& from, const Cell3& to) {
  this_round_ += 2;
  heap_.clear();
  to_ = to;
  goal_ = map.index(to);
  start_ = map.index(from);
  state_ = map.blocked(from) || map.blocked(to) ? State::kNone : State::kRunning;
  open(start_, 0, left(from), 0);
}

CspaceSearch::State CspaceSearch::advance(const SensedMap& map, int cells) {
  for (int looked = 0; looked < cells && state_ == State::kRunning;) {
    if (heap_.empty()) {
      state_ = State::kNone;
      break;
    }
    std::pop_heap(heap_.begin(), heap_.end(), kLater);
    const int here = heap_.back().cell;
    heap_.pop_back();
    if (round_[here] != this_round_) continue;  // already expanded
    round_[here] = this_round_ + 1;
    ++looked;
    if (here == goal_) {
      state_ = State::kFound;
      break;
    }
    expand(map, here);
  }
  return state_;
}

void CspaceSearch::expand(const SensedMap& map, int here) {
  const Cell3 at = map.cell(here);
  if (map.blocked(at)) return;  // blocked since it was reached
  std::uint32_t free = 0;
  for (std::size_t k = 0; k < steps_.size(); ++k) {
    const Cell3 next = beside(at, steps_[k].by);
    bool within = true;
    for (int i = 0; i < 3; ++i) within = within && next[i] >= 0 && next[i] < map.size()[i];
    if (within && !map.blocked(next)) free |= 1U << k;
  }
  for (std::size_t k = 0; k < steps_.size(); ++k) {
    const Step& step = steps_[k];
    if ((step.box & ~free) != 0) continue;
    const int there = here + step.index;
    const int cost = cost_[here] + step.cost;
    if (round_[there] > this_round_ || (round_[there] == this_round_ && cost_[there] <= cost)) continue;
    open(there, cost, cost + left(beside(at, step.by)), static_cast<std::uint8_t>(k));
  }
}

std::vector<Cell3> CspaceSearch::path(const SensedMap& map) const {
  std::vector<Cell3> path;
  for (int cell = goal_; cell != start_; cell -= steps_[step_[cell]].index) path.push_back(map.cell(cell));
  path.push_back(map.cell(start_));
  std::reverse(path.begin(), path.end());
  return path;
}

}  // namespace hecaton::planner::cspace
