#pragma once
/// When keys expire, for people. Standard library only.

#include <array>
#include <chrono>
#include <cstdio>
#include <string>

namespace hecaton::services {

/// A cell reports keys as a fault for this long before they expire.
inline constexpr std::chrono::days kExpiryLead{30};

/// "2027-01-31", in UTC
[[nodiscard]] inline std::string date_text(std::chrono::system_clock::time_point time) {
  const std::chrono::year_month_day date{std::chrono::floor<std::chrono::days>(time)};
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%04d-%02u-%02u", static_cast<int>(date.year()),
                static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()));
  return text.data();
}

}  // namespace hecaton::services
