#pragma once
/// The whole command line of `hecaton`.

#include <memory>

#include "services/cli/settings.hpp"

namespace hecaton::services::cli {

/// `session` must outlive the result.
[[nodiscard]] std::unique_ptr<CLI::App> make_application(Session& session);

/// Parses, runs and explains on stderr what went wrong.
[[nodiscard]] ExitCode run_application(int argc, const char* const* argv);

}  // namespace hecaton::services::cli
