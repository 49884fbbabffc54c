#pragma once
/// The frame of every service's main().

#include <functional>
#include <string>

#include "services/config/cell_file.hpp"
#include "services/runtime/options.hpp"
#include "services/runtime/shutdown.hpp"
#include "services/runtime/urgency.hpp"

namespace hecaton::services {

/// Parses the command line (see parse_options), takes over the signals, calls `body` and turns what it throws into one
/// sentence on stderr and kBadInput. Returns main's result.
[[nodiscard]] int run_service(int argc, const char* const* argv, const std::string& description, Subject subject,
                              const std::function<void(const ServiceOptions&, ShutdownSignal&)>& body);

/// What a service does when its loop is about to begin: goes first (urgency.hpp), where the cell file wants that. Logs
/// why it may not.
void hurry(const config::CellFile& file, Urgency urgency);

}  // namespace hecaton::services
