#pragma once
/// The referee's account as a message; term, sequence number and stamp are left to the caller.

#include <idl/world.h>

#include "world/sim/contact_referee.hpp"

namespace hecaton::services {

[[nodiscard]] msg::RefereeReport referee_message(const world::RefereeReport& report, double time, bool running);

}  // namespace hecaton::services
