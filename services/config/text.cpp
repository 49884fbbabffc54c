#include "services/config/text.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdio>
#include <limits>
#include <vector>

#include "planner/model/source_file.hpp"

namespace hecaton::config {
namespace {

constexpr std::size_t kLongestText = 80;   // [bytes] of a value in a sentence
constexpr std::size_t kLongestPath = 400;  // [bytes]

// The Levenshtein distance, with two rows of its table.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> previous(b.size() + 1);
  std::vector<std::size_t> current(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) previous[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    current[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = previous[j - 1] + (a[i - 1] == b[j - 1] ? 0U : 1U);
      current[j] = std::min({previous[j] + 1, current[j - 1] + 1, replaced});
    }
    std::swap(previous, current);
  }
  return previous[b.size()];
}

std::optional<double> special_number(std::string_view text) {
  double sign = 1.0;
  if (!text.empty() && (text.front() == '-' || text.front() == '+')) {
    if (text.front() == '-') sign = -1.0;
    text.remove_prefix(1);
  }
  if (!text.empty() && text.front() == '.') text.remove_prefix(1);
  std::string lower(text);
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  if (lower == "inf" || lower == "infinity") return sign * std::numeric_limits<double>::infinity();
  if (lower == "nan") return std::numeric_limits<double>::quiet_NaN();
  return std::nullopt;
}

bool is_control(char c) {
  const auto byte = static_cast<unsigned char>(c);
  return byte < 0x20 || byte == 0x7F;
}

/// Appends the character that begins at `i`, escaped if `must_escape` or if it is no UTF-8. Returns its bytes.
std::size_t append_escaped(std::string_view text, std::size_t i, bool (*must_escape)(char), std::string& out) {
  const std::size_t length = planner::utf8_length(text, i);
  if (length > 0 && !(length == 1 && must_escape(text[i]))) {
    out += text.substr(i, length);
    return length;
  }
  char escape[8];
  std::snprintf(escape, sizeof escape, "\\x%02x", static_cast<unsigned char>(text[i]));
  out += escape;
  return 1;
}

/// Without the last character, of which bytes may be missing.
std::string whole_characters(std::string text) {
  while (!text.empty() && (static_cast<unsigned char>(text.back()) & 0xC0U) == 0x80U) text.pop_back();
  if (!text.empty() && static_cast<unsigned char>(text.back()) >= 0xC0U) text.pop_back();
  return text;
}

/// `text` on one line of at most about `longest` bytes; a longer one is cut with "…".
std::string one_line(std::string_view text, std::size_t longest) {
  std::string line;
  for (std::size_t i = 0; i < text.size();) {
    if (line.size() >= longest) return whole_characters(line) + "…";
    i += append_escaped(text, i, is_control, line);
  }
  return line;
}

}  // namespace

std::string_view nearest_word(std::string_view word, std::span<const std::string_view> candidates) {
  word = word.substr(0, kLongestText);
  std::string_view best;
  std::size_t best_distance = std::numeric_limits<std::size_t>::max();
  for (const std::string_view candidate : candidates) {
    const std::size_t distance = edit_distance(word, candidate);
    if (distance >= best_distance) continue;
    best = candidate;
    best_distance = distance;
  }
  return best;
}

std::string alternatives(std::span<const std::string_view> words) {
  std::string text;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (i > 0) text += i + 1 == words.size() ? " or " : ", ";
    text += words[i];
  }
  return text;
}

std::string listed(std::span<const std::string_view> words) {
  std::string text;
  for (const std::string_view word : words) text.append(text.empty() ? "" : ", ").append(word);
  return text;
}

std::string suggestion(std::string_view word, std::span<const std::string_view> candidates) {
  const std::string_view nearest = nearest_word(word, candidates);
  const bool mistyped =
      edit_distance(word.substr(0, kLongestText), nearest) <= std::max<std::size_t>(1, word.size() / 3);
  if (mistyped && !nearest.empty()) return "did you mean '" + std::string(nearest) + "'?";
  return "allowed are " + listed(candidates);
}

bool is_name(std::string_view text) {
  constexpr std::size_t kLongestName = 64;
  const auto allowed = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-' ||
           c == '.';
  };
  return !text.empty() && text.size() <= kLongestName && std::all_of(text.begin(), text.end(), allowed);
}

std::string number_text(double value) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.6g", value);
  return buffer;
}

std::string milliseconds_text(double seconds) {
  return number_text(seconds * 1e3) + "ms";
}

std::string printable(std::string_view text) {
  return one_line(text, kLongestText);
}

std::string printable_path(std::string_view path) {
  return one_line(path, kLongestPath);
}

std::string valid_utf8(std::string_view text) {
  std::string valid;
  for (std::size_t i = 0; i < text.size();) {
    i += append_escaped(
        text, i, [](char) { return false; }, valid);
  }
  return valid;
}

std::string sentence_text(std::string_view text) {
  constexpr std::size_t kLongestWord = kLongestPath;
  constexpr std::size_t kWordBegin = 200;  // [bytes] kept of a longer one
  constexpr std::size_t kLongest = 3000;   // [bytes]
  std::string sentence;
  while (!text.empty() && sentence.size() < kLongest) {
    const std::size_t end = std::min(text.find_first_of(" \n"), text.size());
    std::string word;
    for (std::size_t i = 0; i < std::min(end, kLongestWord);) i += append_escaped(text, i, is_control, word);
    if (end > kLongestWord) word = whole_characters(word.substr(0, kWordBegin)) + "…";
    sentence += word;
    if (end < text.size()) sentence += text[end];
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return text.empty() ? sentence : sentence + "…";
}

std::optional<double> parse_number(std::string_view text) {
  if (const auto special = special_number(text)) return special;
  std::string_view digits = text;
  if (!digits.empty() && digits.front() == '+') digits.remove_prefix(1);
  // from_chars accepts "-1" and ".5". A sign after the removed "+" is an error.
  if (digits.empty() || (digits.size() < text.size() && digits.front() == '-')) return std::nullopt;
  double value = 0.0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (end != digits.data() + digits.size()) return std::nullopt;
  if (error == std::errc::result_out_of_range) {
    // The sign of the exponent distinguishes underflow (0) from overflow.
    const std::size_t exponent = digits.find_first_of("eE");
    const bool tiny = exponent != std::string_view::npos && digits.substr(exponent).find('-') != std::string_view::npos;
    return tiny ? 0.0 : std::numeric_limits<double>::infinity();
  }
  if (error != std::errc()) return std::nullopt;
  return value;
}

std::string Bounds::text() const {
  std::string suffix;
  if (!unit.empty()) suffix.append(" ").append(unit);
  if (low_open) return "above " + number_text(low) + " and at most " + number_text(high) + suffix;
  return "between " + number_text(low) + " and " + number_text(high) + suffix;
}

namespace {

struct Unit {
  std::string_view name;
  double per_second;  // units per second: a division gives 10ms = 0.01 exactly
};
// Longer names first: "ms" also ends in "s".
constexpr std::array<Unit, 6> kUnits = {
    {{"min", 1.0 / 60.0}, {"ns", 1e9}, {"us", 1e6}, {"µs", 1e6}, {"ms", 1e3}, {"s", 1.0}}};

}  // namespace

namespace {

/// The number before a unit; spaces may stand between.
std::optional<double> number_before(std::string_view text, std::string_view unit) {
  std::string_view number = text.substr(0, text.size() - unit.size());
  while (!number.empty() && number.back() == ' ') number.remove_suffix(1);
  return parse_number(number);
}

}  // namespace

std::optional<double> parse_duration(std::string_view text) {
  for (const Unit& unit : kUnits) {
    if (!text.ends_with(unit.name)) continue;
    const auto value = number_before(text, unit.name);
    return value ? std::optional(*value / unit.per_second) : std::nullopt;
  }
  return std::nullopt;
}

std::optional<double> parse_size(std::string_view text) {
  constexpr std::array<std::pair<std::string_view, double>, 3> kSizes{{{"kB", 1e3}, {"MB", 1e6}, {"GB", 1e9}}};
  for (const auto& [unit, bytes] : kSizes) {
    if (!text.ends_with(unit)) continue;
    const auto value = number_before(text, unit);
    return value ? std::optional(*value * bytes) : std::nullopt;
  }
  return std::nullopt;
}

}  // namespace hecaton::config
