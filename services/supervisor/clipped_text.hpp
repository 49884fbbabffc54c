#pragma once
/// Texts of other processes inside the supervisor's own messages, which must stay below the limits of their readers
/// (services/bus/wire_rules.cpp).

#include <cstddef>
#include <string>

namespace hecaton::services {

inline constexpr std::size_t kLongestReason = 1000;  ///< [byte]

/// The text, or its begin and "…". UTF-8 stays valid.
[[nodiscard]] inline std::string clipped(std::string text, std::size_t most = kLongestReason) {
  constexpr std::size_t kEllipsis = 3;  // bytes
  if (text.size() <= most) return text;
  std::size_t end = most - kEllipsis;
  const auto continues = [&] { return (static_cast<unsigned char>(text[end]) & 0xC0U) == 0x80U; };
  while (end > 0 && continues()) --end;
  return text.substr(0, end) + "…";
}

}  // namespace hecaton::services
