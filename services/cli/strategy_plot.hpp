#pragma once
/// hecaton strategies plot.

#include "services/cli/settings.hpp"

namespace hecaton::services::cli {

void add_strategy_plot(CLI::App& parent, Session& session);

}  // namespace hecaton::services::cli
