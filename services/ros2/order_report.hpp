#pragma once
/// What became of orders from topics, which have no answer, for people.

#include <cstdint>
#include <optional>
#include <string>

namespace hecaton::ros2 {

struct OrderReport {
  std::string name;                         ///< of the orders
  std::uint64_t applied = 0;                ///< since the start
  std::uint64_t refused = 0;                ///< since the start
  std::optional<std::string> refusal = {};  ///< the newest one; nothing when what came after it was applied
  std::uint64_t unreadable = 0;             ///< messages of another layout than their type, since the start
};

}  // namespace hecaton::ros2
