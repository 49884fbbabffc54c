#pragma once
/// The cell file's sections `timing` and `tasks`.

#include "planner/cell.hpp"
#include "services/config/yaml_view.hpp"

namespace hecaton::config {

[[nodiscard]] planner::Timing read_timing(const MapView& root);

/// timing.real_time.
[[nodiscard]] bool read_real_time(const MapView& root);

/// Without the section: radius 0, a cell in which no random goals can be drawn.
[[nodiscard]] planner::TaskArea read_tasks(const MapView& root);

}  // namespace hecaton::config
