#pragma once
/// What a process knows of itself.

#include <cstdint>
#include <string>

namespace hecaton::services {

/// Resident memory of this process [byte]; 0 when the kernel does not tell.
[[nodiscard]] std::uint64_t resident_bytes();
/// The machine's own name.
[[nodiscard]] std::string machine_name();
/// Nanoseconds on this host's steady clock: the stamp of every message.
[[nodiscard]] std::int64_t stamp_now();

}  // namespace hecaton::services
