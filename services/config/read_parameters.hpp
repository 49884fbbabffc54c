#pragma once
/// What a cell file says about an arm's reactive planner.

#include "planner/methods/motion_method.hpp"
#include "planner/methods/strategy/coefficient_limit.hpp"
#include "services/config/arm_view.hpp"
#include "services/config/bounds.hpp"
#include "services/config/yaml_view.hpp"

namespace hecaton::config {

/// α, β, … of a strategy, wherever they are read.
inline constexpr Bounds kCoefficient{-planner::kMostCoefficient, planner::kMostCoefficient, ""};

/// Overwrites what `map` (an arm or `defaults`) mentions. Checks each number alone; LocalParameters::validate checks
/// them together.
void read_parameters(const MapView& map, planner::LocalParameters& parameters);

/// Every method of the registry with the parameters that the arm's map, and `defaults` behind it, give it; a section
/// may name a file that has them for each arm. Checks each method's parameters together, too.
[[nodiscard]] planner::MethodSet read_methods(const ArmView& view, const ArmSections& sections);

/// The name of the arm's method: one of the registry's.
[[nodiscard]] std::string_view read_method_name(const ArmView& view, const ArmSections& sections);

}  // namespace hecaton::config
