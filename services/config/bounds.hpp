#pragma once
/// What a number of the cell file may be.

#include <limits>
#include <string>
#include <string_view>

namespace hecaton::config {

struct Bounds {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  std::string_view unit = "";  ///< of number, low and high, for the message
  bool low_open = false;       ///< low itself is not allowed

  /// Finite and within; the comparison is false for NaN.
  [[nodiscard]] bool allow(double value) const { return (low_open ? value > low : value >= low) && value <= high; }
  /// "above 0 and at most 10 m"
  [[nodiscard]] std::string text() const;
};

inline constexpr double kFarthest = 100.0;  ///< of anything in a cell from its origin [m]

inline constexpr Bounds kCoordinate{-kFarthest, kFarthest, "m"};
inline constexpr Bounds kLength{0.0, kFarthest, "m", true};
inline constexpr Bounds kAngle{-100.0, 100.0, "rad"};

}  // namespace hecaton::config
