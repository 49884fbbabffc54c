#include <algorithm>
#include <array>
#include <bit>
#include <cstdio>
#include <cstring>
#include <utility>

#include "services/bus/wire_rules.hpp"

namespace hecaton::bus {
namespace {

constexpr std::size_t kEncapsulation = 4;
/// Middlewares pad a payload to their own alignment.
constexpr std::size_t kPadding = 8;

std::string number_text(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.6g", value);
  return text.data();
}

/// Length of the UTF-8 sequence at the beginning of `text`, whose character is printable; 0: it is none.
std::size_t printable_sequence(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<std::uint8_t>(text[i]); };
  const std::size_t length = byte(0) >= 0xF0 ? 4 : byte(0) >= 0xE0 ? 3 : 2;
  if (byte(0) < 0xC2 || byte(0) > 0xF4 || text.size() < length) return 0;
  std::uint32_t code = byte(0) & (0xFFU >> (length + 1));
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xC0U) != 0x80U) return 0;
    code = code << 6U | (byte(i) & 0x3FU);
  }
  const bool overlong = (length == 3 && code < 0x800) || (length == 4 && code < 0x10000);
  const bool surrogate = code >= 0xD800 && code <= 0xDFFF;
  const bool control = code < 0xA0 || code == 0x2028 || code == 0x2029;
  const bool direction = (code >= 0x202A && code <= 0x202E) || (code >= 0x2066 && code <= 0x2069);
  return overlong || surrogate || control || direction || code > 0x10FFFF ? 0 : length;
}

/// Reads plain CDR. Each function returns false at the first value that breaks its rule and leaves a sentence.
class Walker {
 public:
  Walker(std::span<const std::uint8_t> bytes, bool swapped) : bytes_(bytes), swapped_(swapped) {}

  bool walk(const StructRule& rule) {
    for (const FieldRule& field : rule.fields) {
      if (!walk(field)) return false;
    }
    return true;
  }

  /// The schema version of the sample; it is its first field.
  [[nodiscard]] std::optional<std::uint32_t> schema() {
    std::uint32_t version = 0;
    const bool has_one = read(version);
    at_ = 0;
    return has_one ? std::optional(version) : std::nullopt;
  }

  bool ends(std::string_view type) {
    if (bytes_.size() - at_ <= kPadding) return true;
    return refuse(std::string(type) + " has " + std::to_string(bytes_.size() - at_) + " bytes too many");
  }

  [[nodiscard]] std::optional<std::string> take_refusal() { return std::move(refusal_); }
  [[nodiscard]] std::uint64_t largest_term() const { return largest_term_; }

 private:
  bool walk(const FieldRule& field) {
    switch (field.kind) {
      case FieldKind::kBool:
        return number<std::uint8_t>(field);
      case FieldKind::kInt32:
        return number<std::int32_t>(field);
      case FieldKind::kUint32:
      case FieldKind::kEnum:
        return number<std::uint32_t>(field);
      case FieldKind::kInt64:
        return number<std::int64_t>(field);
      case FieldKind::kUint64:
        return number<std::uint64_t>(field);
      case FieldKind::kTerm:
        return term(field);
      case FieldKind::kFloat:
        return number<float>(field);
      case FieldKind::kDouble:
        return number<double>(field);
      case FieldKind::kName:
      case FieldKind::kText:
        return text(field);
      case FieldKind::kStruct:
        return walk(*field.of) || within(field);
      case FieldKind::kDoubles:
        return numbers<double>(field);
      case FieldKind::kUint32s:
        return numbers<std::uint32_t>(field);
      case FieldKind::kNames:
        return names(field);
      case FieldKind::kStructs:
        return structs(field);
    }
    return false;
  }

  template <class T>
  bool read(T& value) {
    const std::size_t begin = (at_ + sizeof(T) - 1) & ~(sizeof(T) - 1);
    if (begin + sizeof(T) > bytes_.size()) return false;
    std::array<std::uint8_t, sizeof(T)> raw{};
    std::memcpy(raw.data(), bytes_.data() + begin, sizeof(T));
    if (swapped_) {
      for (std::size_t i = 0; i < sizeof(T) / 2; ++i) std::swap(raw[i], raw[sizeof(T) - 1 - i]);
    }
    value = std::bit_cast<T>(raw);
    at_ = begin + sizeof(T);
    return true;
  }

  bool refuse(std::string sentence) {
    refusal_ = std::move(sentence);
    return false;
  }
  bool truncated(const FieldRule& field) { return refuse(std::string(field.name) + " is cut off"); }
  /// The refused value is in this field.
  bool within(const FieldRule& field, std::optional<std::uint32_t> index = {}) {
    std::string name(field.name);
    if (index) name += "[" + std::to_string(*index) + "]";
    refusal_ = name + "." + *refusal_;
    return false;
  }

  template <class T>
  bool number(const FieldRule& field) {
    T value{};
    if (!read(value)) return truncated(field);
    return in_range(field, value) || out_of_range(field, static_cast<double>(value), {});
  }
  template <class T>
  static bool in_range(const FieldRule& field, T value) {
    const auto as_double = static_cast<double>(value);
    return as_double >= field.low && as_double <= field.high;
  }
  bool out_of_range(const FieldRule& field, double value, std::optional<std::uint32_t> index) {
    std::string sentence(field.name);
    if (index) sentence += "[" + std::to_string(*index) + "]";
    return refuse(sentence + " = " + number_text(value) + " must be from " + number_text(field.low) + " to " +
                  number_text(field.high));
  }

  bool term(const FieldRule& field) {
    std::uint64_t value = 0;
    if (!read(value)) return truncated(field);
    if (value > kLargestTerm) {
      return refuse(std::string(field.name) + " = " + std::to_string(value) + " must be at most 2^62");
    }
    largest_term_ = std::max(largest_term_, value);
    return true;
  }

  /// The number of elements of a sequence, bounded by its rule and by the bytes that are left.
  bool length(const FieldRule& field, std::uint32_t& count) {
    if (!read(count)) return truncated(field);
    if (count > field.most) {
      return refuse(std::string(field.name) + " has " + std::to_string(count) + " elements, at most " +
                    std::to_string(field.most) + " are allowed");
    }
    return count <= bytes_.size() - at_ || truncated(field);
  }

  template <class T>
  bool numbers(const FieldRule& field) {
    std::uint32_t count = 0;
    if (!length(field, count)) return false;
    for (std::uint32_t i = 0; i < count; ++i) {
      T value{};
      if (!read(value)) return truncated(field);
      if (!in_range(field, value)) return out_of_range(field, static_cast<double>(value), i);
    }
    return true;
  }

  bool text(const FieldRule& field) {
    std::uint32_t size = 0;  // with the zero at its end
    if (!read(size)) return truncated(field);
    if (size == 0) return true;
    if (size - 1 > field.most) {
      return refuse(std::string(field.name) + " has " + std::to_string(size - 1) + " bytes, at most " +
                    std::to_string(field.most) + " are allowed");
    }
    if (size > bytes_.size() - at_) return truncated(field);
    const std::string_view value(reinterpret_cast<const char*>(bytes_.data()) + at_, size - 1);
    if (bytes_[at_ + size - 1] != 0) return refuse(std::string(field.name) + " does not end with 0");
    at_ += size;
    const auto why = unprintable(value, field.kind == FieldKind::kText);
    return !why || refuse(std::string(field.name).append(" has ").append(*why));
  }

  bool names(const FieldRule& field) {
    std::uint32_t count = 0;
    if (!length(field, count)) return false;
    const FieldRule name{.name = field.name, .kind = FieldKind::kName, .most = kLongestName};
    for (std::uint32_t i = 0; i < count; ++i) {
      if (!text(name)) return false;
    }
    return true;
  }

  bool structs(const FieldRule& field) {
    std::uint32_t count = 0;
    if (!length(field, count)) return false;
    for (std::uint32_t i = 0; i < count; ++i) {
      if (!walk(*field.of)) return within(field, i);
    }
    return true;
  }

  std::span<const std::uint8_t> bytes_;  ///< behind the encapsulation
  bool swapped_;
  std::size_t at_ = 0;
  std::uint64_t largest_term_ = 0;
  std::optional<std::string> refusal_;
};

}  // namespace

std::optional<std::string_view> unprintable(std::string_view text, bool lines) {
  for (std::size_t i = 0; i < text.size();) {
    const auto byte = static_cast<std::uint8_t>(text[i]);
    const bool control = byte < 0x20 || byte == 0x7F;
    if (control && !(lines && (byte == '\n' || byte == '\t'))) return "a control character";
    const std::size_t length = byte < 0x80 ? 1 : printable_sequence(text.substr(i));
    if (length == 0) return "a character that is not printable UTF-8";
    i += length;
  }
  return std::nullopt;
}

std::string printable(std::string_view text, std::size_t most) {
  std::string result;
  for (std::size_t i = 0; i < text.size();) {
    const auto byte = static_cast<std::uint8_t>(text[i]);
    const bool plain = byte >= 0x20 && byte < 0x7F;
    const std::size_t length = byte < 0x80 ? 0 : printable_sequence(text.substr(i));
    const std::size_t taken = std::max<std::size_t>(length, 1);
    if (result.size() + taken > most) break;
    result += plain || length > 0 ? text.substr(i, taken) : "?";
    i += taken;
  }
  return result;
}

CheckedSample check_sample(const TopicRule& rule, std::span<const std::uint8_t> bytes) {
  const std::string type(bytes.size() > rule.most_bytes || bytes.size() < kEncapsulation ? rule.sample.name : "");
  if (bytes.size() > rule.most_bytes) {
    return {.refusal = type + " has " + std::to_string(bytes.size()) + " bytes, at most " +
                       std::to_string(rule.most_bytes) + " are allowed"};
  }
  if (bytes.size() < kEncapsulation) return {.refusal = type + " is cut off"};
  const bool plain = bytes[0] == 0 && bytes[1] <= 1;  // CDR_BE, CDR_LE
  if (!plain) return {.refusal = "its encoding is not plain CDR"};
  const bool little = bytes[1] == 1;
  Walker walker(bytes.subspan(kEncapsulation), little != (std::endian::native == std::endian::little));
  const auto& version = rule.sample.fields.front();
  const auto schema = walker.schema();
  if (schema && static_cast<double>(*schema) != version.low) return {.other_schema = true};
  if (walker.walk(rule.sample) && walker.ends(rule.sample.name)) return {.largest_term = walker.largest_term()};
  return {.refusal = walker.take_refusal()};
}

}  // namespace hecaton::bus
