#include "planner/methods/sensed_cspace/cspace_map.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace hecaton::planner::cspace {

int AngleGrid::cell_at(double angle) const {
  return wrapped(static_cast<int>(std::floor(place(std::remainder(angle, 2.0 * kPi)) + 0.5)));
}

CspaceMap::CspaceMap(AngleGrid grid)
    : grid_(grid), words_((static_cast<std::size_t>(grid.cells) + 63) / 64), bits_(words_ * grid.cells, 0) {}

int CspaceMap::blocked_cells() const {
  int count = 0;
  for (const std::uint64_t word : bits_) count += std::popcount(word);
  return count;
}

void CspaceMap::clear() {
  std::fill(bits_.begin(), bits_.end(), 0);
}

void CspaceMap::block_straight(int row, int first, int end) {
  constexpr std::uint64_t kAll = ~std::uint64_t{0};
  const std::size_t last = word(row, end - 1);
  std::uint64_t mask = kAll << (first & 63);
  for (std::size_t at = word(row, first); at < last; ++at, mask = kAll) bits_[at] |= mask;
  bits_[last] |= mask & kAll >> (63 - ((end - 1) & 63));
}

void CspaceMap::block(int row, RowSpan span) {
  if (span.count <= 0) return;
  const int end = span.first + span.count;
  block_straight(row, span.first, std::min(end, grid_.cells));
  if (end > grid_.cells) block_straight(row, 0, end - grid_.cells);
}

void CspaceMap::block(const ObstacleImage& image) {
  int row = image.first_row;
  for (const RowSpan span : image.spans) {
    block(row, span);
    if (++row == grid_.cells) row = 0;
  }
}

void CspaceMap::block(const CspaceMap& other) {
  for (std::size_t i = 0; i < bits_.size(); ++i) bits_[i] |= other.bits_[i];
}

}  // namespace hecaton::planner::cspace
