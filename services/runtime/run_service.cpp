#include "services/runtime/run_service.hpp"

#include <exception>
#include <iostream>

#include "services/runtime/log.hpp"

namespace hecaton::services {

int run_service(int argc, const char* const* argv, const std::string& description, Subject subject,
                const std::function<void(const ServiceOptions&, ShutdownSignal&)>& body) {
  ShutdownSignal shutdown;
  ServiceOptions options;
  if (const auto leave = parse_options(argc, argv, description, subject, options)) return static_cast<int>(*leave);
  try {
    body(options, shutdown);
    return static_cast<int>(ExitCode::kDone);
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return static_cast<int>(ExitCode::kBadInput);
  }
}

void hurry(const config::CellFile& file, Urgency urgency) {
  if (!file.real_time) return;
  const std::string reason = go_first(urgency);
  if (!reason.empty()) log_warning("no real-time priority", {{"reason", reason}});
}

}  // namespace hecaton::services
