#pragma once
/// Words and numbers as they appear in messages.

#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace hecaton::config {

/// The candidate with the smallest edit distance to `word` (the first of several); empty without candidates.
[[nodiscard]] std::string_view nearest_word(std::string_view word, std::span<const std::string_view> candidates);

/// "a, b or c"
[[nodiscard]] std::string alternatives(std::span<const std::string_view> words);

/// The shortest decimal text that reads back as `value`, at most 6 significant digits.
[[nodiscard]] std::string number_text(double value);

/// `text` on one line: control characters escaped, long texts cut with "…".
[[nodiscard]] std::string printable(std::string_view text);

/// A whole decimal number ("1", "-0.5", "1e-3"), "inf" and "nan" in YAML's or C's spelling included; nothing for any
/// other text. Independent of the locale. Too large ones become ±infinity.
[[nodiscard]] std::optional<double> parse_number(std::string_view text);

}  // namespace hecaton::config
