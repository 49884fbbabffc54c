#pragma once

namespace hecaton::planner {

/// The largest |α|, |β|, … of a strategy: u₂ is within 1 mrad of that one's axis then, and greater ones choose hardly
/// another plane.
inline constexpr double kMostCoefficient = 1000.0;

}  // namespace hecaton::planner
