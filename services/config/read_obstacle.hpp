#pragma once
/// The cell file's sections `world` and `obstacles`.

#include <span>

#include "planner/cell.hpp"
#include "services/config/yaml_view.hpp"

namespace hecaton::config {

/// Floor, gravity and obstacles. Attachments must name one of `arms`.
[[nodiscard]] world::Scene read_scene(const MapView& root, std::span<const planner::PlannedArm> arms);

}  // namespace hecaton::config
