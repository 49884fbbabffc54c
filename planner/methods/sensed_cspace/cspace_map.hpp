#pragma once
/// A bit map of the planar arm's configurations, and how joint angles are divided into its cells.

#include <cstdint>
#include <numbers>
#include <vector>

namespace hecaton::planner::cspace {

inline constexpr double kPi = std::numbers::pi;

struct AngleGrid {
  int cells = 360;  ///< > 0

  [[nodiscard]] double pitch() const { return 2.0 * kPi / cells; }  ///< [rad]
  [[nodiscard]] double centre(int cell) const { return -kPi + cell * pitch(); }
  /// 0 ≤ result < cells, for any whole number.
  [[nodiscard]] int wrapped(int cell) const {
    const int rest = cell % cells;
    return rest < 0 ? rest + cells : rest;
  }
  /// The angle in cells, counted from the first cell's centre: centre(i) is i.
  [[nodiscard]] double place(double angle) const { return (angle + kPi) / pitch(); }
  /// The cell that holds the angle [rad].
  [[nodiscard]] int cell_at(double angle) const;
};

/// The cells of θ₂ that are blocked in one row: `count` from `first` on, beyond the last cell round to the first.
struct RowSpan {
  std::int16_t first = 0;
  std::int16_t count = 0;  ///< 0: none
};

/// The image of one obstacle: what it blocks in the rows `first_row`, `first_row` + 1, …, beyond the last round to the
/// first. The paper's Θ₂l(m) and Θ₂u(m), as whole cells.
struct ObstacleImage {
  int first_row = 0;
  std::vector<RowSpan> spans;

  void clear() { spans.clear(); }
};

class CspaceMap {
 public:
  /// Nothing is blocked.
  explicit CspaceMap(AngleGrid grid = {});

  [[nodiscard]] const AngleGrid& grid() const { return grid_; }
  [[nodiscard]] bool blocked(int row, int column) const {
    return (bits_[word(row, column)] >> (column & 63) & 1U) != 0;
  }
  [[nodiscard]] int blocked_cells() const;

  void clear();
  /// `first` is a cell; as many as the row has at most.
  void block(int row, RowSpan span);
  void block(const ObstacleImage& image);
  void block(const CspaceMap& other);

  friend bool operator==(const CspaceMap& a, const CspaceMap& b) { return a.bits_ == b.bits_; }

 private:
  [[nodiscard]] std::size_t word(int row, int column) const {
    return static_cast<std::size_t>(row) * words_ + (static_cast<unsigned>(column) >> 6);
  }
  void block_straight(int row, int first, int end);

  AngleGrid grid_;
  std::size_t words_;  ///< of a row
  std::vector<std::uint64_t> bits_;
};

}  // namespace hecaton::planner::cspace
