#pragma once
/// Removing from Fast DDS without waiting for good. Private to services/bus.
///
/// Fast DDS 2.9.1 can lock itself up in it: who removes an endpoint holds the lock of discovery and waits for the
/// thread of timers, which may wait for that lock to judge the lease of a peer that has just died (receivers.hpp). That
/// is when programs end that were told of the death.

#include <functional>

#include "services/bus/mailbox.hpp"

namespace hecaton::bus {

/// So long no removal takes on any machine.
constexpr std::chrono::seconds kRemoval{10};

/// Does `work` on a thread of its own and waits for its end, no longer than `patience`. False: it is left behind, and
/// so must be all that it uses. The process then ends, when it wants to, with the exit code that it wants to, but
/// without destroying what is global.
[[nodiscard]] bool done_within(Clock::duration patience, std::function<void()> work);

}  // namespace hecaton::bus
