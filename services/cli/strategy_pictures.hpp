#pragma once
/// Pictures of the off-line stage, as scripts of gnuplot.

#include <string>
#include <vector>

#include "services/cli/strategy_table.hpp"

namespace hecaton::services::cli {

/// One row of the sensitivity table (tests/bench/strategy_sensitivity.py writes it).
struct SensitivityRow {
  std::string group;    ///< what was changed: layout, basis, …
  std::string variant;  ///< to what
  double candidates = 0.0;
  double screened = 0.0;   ///< without fault at first
  double confirmed = 0.0;  ///< without fault after all sets
  double time = 0.0;       ///< T of the best [steps]
};

/// Whether the file's first line is that of a sensitivity table.
[[nodiscard]] bool is_sensitivity(const std::string& path);
/// Throws Failure (bad input) that names file and line.
[[nodiscard]] std::vector<SensitivityRow> read_sensitivity(const std::string& path);

/// T(L) against the share of faults, one point a strategy, and its standard error.
[[nodiscard]] std::string faults_script(const StrategyResults& results);
/// Strategies without fault, and the best T, of each variant.
[[nodiscard]] std::string sensitivity_script(const std::vector<SensitivityRow>& rows);

}  // namespace hecaton::services::cli
