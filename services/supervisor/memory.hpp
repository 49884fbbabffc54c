#pragma once
/// What a supervisor that was killed must still know when it starts again: its term, people's orders and the faults. A
/// text file, replaced as a whole, so that a crash leaves either the old or the new one; of two, whose room is taken
/// beforehand, so that a disk that is full by then loses no order.

#include <cstdint>
#include <optional>
#include <string>

#include "services/supervisor/cell_mode.hpp"
#include "services/supervisor/fault_list.hpp"

namespace hecaton::services {

struct Memory {
  std::uint64_t term = 0;
  Orders orders;
  CausesByArm causes;
  FaultHistory faults;
  Orders unheard;  ///< of the orders: those that the other supervisor is not known to have heard, see OrderLegacy
  bool operator==(const Memory&) const = default;
};

/// Lines "term N", "cell MODE", "arm NAME MODE", "because NAME KIND SUBJECT TEXT…" ("/": of the cell's), "unheard NAME
/// MODE" (likewise), and for each fault "fault LIFE NUMBER KIND SEVERITY SINCE WITHIN CLEARED|open CAUSE|- SUBJECT
/// SEEN…" (times in nanoseconds, of the steady clock; WITHIN −1: unknown).
[[nodiscard]] std::string memory_text(const Memory& memory);
/// Empty when it is no such text.
[[nodiscard]] std::optional<Memory> parse_memory(const std::string& text);

/// Empty when there is no such file. Throws std::runtime_error with a sentence when it is there and cannot be used: an
/// order to stop must not be forgotten silently.
[[nodiscard]] std::optional<Memory> read_memory(const std::string& path);
/// Empty lines fill up the room. Empty, or the sentence that says why it cannot be written: what was remembered before
/// still is.
[[nodiscard]] std::string write_memory(const std::string& path, const Memory& memory);
/// Where the other of its two files is.
[[nodiscard]] std::string next_memory(const std::string& path);

}  // namespace hecaton::services
