#pragma once
/// hecaton strategies simplex.

#include "services/cli/settings.hpp"

namespace hecaton::services::cli {

void add_strategy_simplex(CLI::App& parent, Session& session);

}  // namespace hecaton::services::cli
