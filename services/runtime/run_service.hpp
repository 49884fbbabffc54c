#pragma once
/// The frame of every service's main().

#include <functional>
#include <string>

#include "services/runtime/options.hpp"
#include "services/runtime/shutdown.hpp"

namespace hecaton::services {

/// Parses the command line (see parse_options), takes over the signals, calls `body` and turns what it throws into one
/// sentence on stderr and kBadInput. Returns main's result.
[[nodiscard]] int run_service(int argc, const char* const* argv, const std::string& description, Subject subject,
                              const std::function<void(const ServiceOptions&, ShutdownSignal&)>& body);

}  // namespace hecaton::services
