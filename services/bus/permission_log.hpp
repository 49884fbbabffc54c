#pragma once
/// Names participants whose permissions Fast DDS refuses: it writes this to its log only. Private to services/bus.

#include <memory>
#include <optional>
#include <string_view>

#include "services/bus/refusals.hpp"

namespace hecaton::bus {

/// What an entry of the log of Fast DDS says of permissions; nothing: the entry is about something else.
[[nodiscard]] std::optional<Refused> refused_permissions(std::string_view message);

/// Refusals of permissions are noted in `log` from now on, as long as it exists. Fast DDS has one log for all
/// participants of a process: each of their logs gets the refusals of all. Thread-safe.
void note_refused_permissions(const std::shared_ptr<RefusalLog>& log);

}  // namespace hecaton::bus
