#pragma once
/// What a cell file says about an arm's reactive planner.

#include "planner/local/parameters.hpp"
#include "planner/strategy/coefficient_limit.hpp"
#include "services/config/bounds.hpp"
#include "services/config/yaml_view.hpp"

namespace hecaton::config {

/// α, β, … of a strategy, wherever they are read.
inline constexpr Bounds kCoefficient{-planner::kMostCoefficient, planner::kMostCoefficient, ""};

/// Overwrites what `map` (an arm or `defaults`) mentions. Checks each number alone; LocalParameters::validate checks
/// them together.
void read_parameters(const MapView& map, planner::LocalParameters& parameters);

/// The arm's strategy in a file as `hecaton-strategies search` writes it, which the key `file` names.
void read_strategy_file(const YamlView& file, const std::string& arm, planner::StrategyParameters& parameters);

}  // namespace hecaton::config
