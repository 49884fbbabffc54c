#pragma once
/// How an obstacle moves.

#include "services/config/yaml_view.hpp"
#include "world/model/scene.hpp"

namespace hecaton::config {

[[nodiscard]] world::Motion read_motion(const YamlView& view);

}  // namespace hecaton::config
