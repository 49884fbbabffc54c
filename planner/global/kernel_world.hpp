#pragma once
/// What stands in the way, as the validity kernel reads it.

#include <span>

#include "planner/global/validity.hpp"

namespace hecaton::planner::global {

/// In frame O. Shapes are made larger by what rounding them to floats may cost.
[[nodiscard]] KernelWorld kernel_world(std::span<const WorldBody> bodies, const Pose& X_OW);

}  // namespace hecaton::planner::global
