#pragma once
/// What the page needs once: the arms with their links, shapes and limits. All functions are pure.

#include <vector>

#include "services/config/cell_file.hpp"
#include "services/view/arm_drawing.hpp"
#include "services/view/json.hpp"
#include "world/model/shape.hpp"

namespace hecaton::services::view {

/// `drawings`: one for each arm.
[[nodiscard]] Json cell_json(const config::CellFile& file, const std::vector<ArmDrawing>& drawings);

/// A shape with its pose in the frame of its body, and the capsule that encloses it.
[[nodiscard]] Json shape_json(const world::Shape& shape, const world::Pose& X_BS);

}  // namespace hecaton::services::view
