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

/// "a, b, c"
[[nodiscard]] std::string listed(std::span<const std::string_view> words);

/// "did you mean 'status'?" when `word` looks like one of the candidates mistyped, otherwise "allowed are a, b, c".
[[nodiscard]] std::string suggestion(std::string_view word, std::span<const std::string_view> candidates);

/// What the names of cells, hosts, arms, poses and obstacles are made of: they go into topics and messages.
inline constexpr std::string_view kNameRule = "a name of 1 to 64 letters, digits, '_', '-' or '.'";
[[nodiscard]] bool is_name(std::string_view text);

/// The shortest decimal text that reads back as `value`, at most 6 significant digits.
[[nodiscard]] std::string number_text(double value);

/// `text` on one line: control characters escaped, long texts cut with "…".
[[nodiscard]] std::string printable(std::string_view text);

/// A whole decimal number ("1", "-0.5", "1e-3"), "inf" and "nan" in YAML's or C's spelling included; nothing for any
/// other text. Independent of the locale. Too large ones become ±infinity.
[[nodiscard]] std::optional<double> parse_number(std::string_view text);

}  // namespace hecaton::config
