#pragma once
/// What a simulation changes in the cell of its cell file. A recording of it holds the changes, so that its ticks can
/// be recomputed.

#include <optional>
#include <string>
#include <string_view>

#include "planner/cell.hpp"

namespace hecaton::services {

struct CellChanges {
  std::string method = {};  ///< of all arms; empty: as the cell file says
  int rollouts = -1;        ///< candidates; −1: as the cell file says
  bool no_routes = false;   ///< no routes and no coupled plans
  double speed = 0.0;       ///< velocity limit of all revolute joints [rad/s]; 0: as the cell file says

  /// Changes the cell. Returns why the method does not suit an arm, the end of a sentence; empty: it does.
  [[nodiscard]] std::optional<std::string> apply(planner::Cell& cell) const;

  [[nodiscard]] std::string json() const;
  /// The inverse of json(); empty: the text is no such JSON.
  [[nodiscard]] static std::optional<CellChanges> from_json(std::string_view text);
};

}  // namespace hecaton::services
