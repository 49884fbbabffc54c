#pragma once
/// What a process stamps its messages with.

#include <chrono>
#include <climits>
#include <cstdint>
#include <string>

#include <unistd.h>

namespace hecaton::services {

/// The machine's own name; "localhost" when the kernel has none.
[[nodiscard]] inline std::string machine_name() {
  char name[HOST_NAME_MAX + 1] = {};
  return gethostname(name, sizeof name - 1) == 0 ? name : "localhost";
}

/// Nanoseconds on this machine's steady clock: the stamp of every message. Stamps of two machines cannot be compared.
[[nodiscard]] inline std::int64_t stamp_now() {
  return std::chrono::nanoseconds(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace hecaton::services
