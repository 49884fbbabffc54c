#pragma once
/// Durations as people write them: a number and its unit ("20ms", "1.5 s").

#include <optional>
#include <string_view>

namespace hecaton::config {

inline constexpr std::string_view kDurationUnits = "ns, us, ms, s or min";

/// Seconds, possibly negative or not finite as its number is; nothing when the number or its unit is missing or
/// unknown.
[[nodiscard]] std::optional<double> parse_duration(std::string_view text);

}  // namespace hecaton::config
