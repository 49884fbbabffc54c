#pragma once
/// How the angles of a joint are divided: `cells` equal cells round the full turn, the first centred on −π. [Li96] uses
/// 360 of them.

#include <numbers>

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

}  // namespace hecaton::planner::cspace
