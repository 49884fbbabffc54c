#pragma once
/// Checks of received numbers. Private to services/messages.

#include <cmath>
#include <optional>
#include <string>

namespace hecaton::messages {

[[nodiscard]] inline std::string not_finite(const std::string& what, double value) {
  return what + " = " + std::to_string(value) + " must be finite";
}

/// Returns a sentence unless the value is finite and above `bound` (or equal to it, with `or_equal`).
[[nodiscard]] inline std::optional<std::string> check_above(const std::string& what, double value, double bound,
                                                            bool or_equal = false) {
  if (std::isfinite(value) && (value > bound || (or_equal && value >= bound))) return std::nullopt;
  return what + " = " + std::to_string(value) + " must be a finite number " + (or_equal ? "not below " : "above ") +
         std::to_string(bound);
}

}  // namespace hecaton::messages
