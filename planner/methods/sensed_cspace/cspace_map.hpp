#pragma once
/// A bit map of the planar arm's configurations, and how joint angles are divided into its cells.

#include <cstdint>
#include <numbers>
#include <vector>

namespace hecaton::planner::cspace {

inline constexpr double kPi = std::numbers::pi;

/// `cells` equal cells of a full turn; the first one is centred on −π. [Li96] uses 360.
struct AngleGrid {
  int cells = 360;  ///< > 0

  [[nodiscard]] double pitch() const { return 2.0 * kPi / cells; }  ///< [rad]
  [[nodiscard]] double centre(int cell) const { return -kPi + cell * pitch(); }
  /// The cell in [0, cells) that any integer stands for.
  [[nodiscard]] int wrapped(int cell) const {
    const int rest = cell % cells;
    return rest < 0 ? rest + cells : rest;
  }
  /// The angle in units of cells: the inverse of centre(), without wrapping.
  [[nodiscard]] double place(double angle) const { return (angle + kPi) / pitch(); }
  /// The cell that holds the angle [rad].
  [[nodiscard]] int cell_at(double angle) const;
};

/// The blocked cells of θ₂ in one row: `count` cells from `first`, wrapping around.
struct RowSpan {
  std::int16_t first = 0;
  std::int16_t count = 0;  ///< 0: none
};

/// The image of one obstacle: a span for each row from `first_row`, wrapping around. These are the paper's Θ₂l(m) and
/// Θ₂u(m) as whole cells.
struct ObstacleImage {
  int first_row = 0;
  std::vector<RowSpan> spans;

  void clear() { spans.clear(); }
};

/// One bit for each cell of θ₁ × θ₂; rows are cells of θ₁.
class CspaceMap {
 public:
  /// An empty map.
  explicit CspaceMap(AngleGrid grid = {});

  [[nodiscard]] const AngleGrid& grid() const { return grid_; }
  [[nodiscard]] bool blocked(int row, int column) const {
    return (bits_[word(row, column)] >> (column & 63) & 1U) != 0;
  }
  [[nodiscard]] int blocked_cells() const;

  void clear();
  /// Precondition: 0 ≤ span.first < cells and span.count ≤ cells.
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
