#pragma once
/// Words, numbers, durations and bounds as they appear in cell files, options and messages.

#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace hecaton::config {

/// The candidate with the smallest edit distance to `word`, the first among equals; empty without candidates.
[[nodiscard]] std::string_view nearest_word(std::string_view word, std::span<const std::string_view> candidates);

/// "a, b or c"
[[nodiscard]] std::string alternatives(std::span<const std::string_view> words);

/// "a, b, c"
[[nodiscard]] std::string listed(std::span<const std::string_view> words);

/// "did you mean 'status'?" when `word` looks like one of the candidates mistyped, otherwise "allowed are a, b, c".
[[nodiscard]] std::string suggestion(std::string_view word, std::span<const std::string_view> candidates);

/// The rule for names of cells, hosts, arms, poses and obstacles, which become parts of topics and messages.
inline constexpr std::string_view kNameRule = "a name of 1 to 64 characters: a to z, A to Z, 0 to 9, '_', '-' or '.'";
[[nodiscard]] bool is_name(std::string_view text);

/// The shortest decimal text that reads back as `value`, at most 6 significant digits.
[[nodiscard]] std::string number_text(double value);

/// "12.5ms" for a time in seconds.
[[nodiscard]] std::string milliseconds_text(double seconds);

/// `text` on one line: control characters and bytes that are no UTF-8 escaped, long texts cut with "…".
[[nodiscard]] std::string printable(std::string_view text);

/// As printable(), for the path of a file: whole up to 400 bytes.
[[nodiscard]] std::string printable_path(std::string_view path);

/// `text` as valid UTF-8: bytes that are not are escaped ("\xff").
[[nodiscard]] std::string valid_utf8(std::string_view text);

/// A sentence for people that may quote input, which cannot fill their screen. Control characters other than line ends,
/// and bytes that are no UTF-8, are escaped. Very long words and texts are shortened with "…".
[[nodiscard]] std::string sentence_text(std::string_view text);

/// The value of a text that is one decimal number ("1", "-0.5", "1e-3"), or "inf" or "nan" in the spelling of YAML or
/// C; empty for any other text. Too large numbers become ±infinity. Independent of the locale.
[[nodiscard]] std::optional<double> parse_number(std::string_view text);

/// The allowed range of a number.
struct Bounds {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  std::string_view unit = "";  ///< for messages
  bool low_open = false;       ///< low itself is not allowed

  /// False for NaN.
  [[nodiscard]] bool allow(double value) const { return (low_open ? value > low : value >= low) && value <= high; }
  /// "above 0 and at most 10 m"
  [[nodiscard]] std::string text() const;
};

inline constexpr double kFarthest = 100.0;  ///< of anything in a cell from its origin [m]

inline constexpr Bounds kCoordinate{-kFarthest, kFarthest, "m"};
inline constexpr Bounds kLength{0.0, kFarthest, "m", true};
inline constexpr Bounds kAngle{-100.0, 100.0, "rad"};

/// The units of durations.
inline constexpr std::string_view kDurationUnits = "ns, us, ms, s or min";

/// The value [s] of a duration such as "20ms" or "1.5 s"; negative or not finite when its number is. Empty when number
/// or unit is missing or unknown.
[[nodiscard]] std::optional<double> parse_duration(std::string_view text);

/// The units of sizes.
inline constexpr std::string_view kSizeUnits = "kB, MB or GB";

/// The bytes of a size such as "500MB" or "2 GB"; negative or not finite when its number is. Empty when number or unit
/// is missing or unknown.
[[nodiscard]] std::optional<double> parse_size(std::string_view text);

}  // namespace hecaton::config
