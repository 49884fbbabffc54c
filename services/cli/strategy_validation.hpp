#pragma once
/// hecaton strategies validate.

#include "services/cli/settings.hpp"

namespace hecaton::services::cli {

void add_strategy_validation(CLI::App& parent, Session& session);

}  // namespace hecaton::services::cli
