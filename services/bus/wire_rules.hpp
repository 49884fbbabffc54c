#pragma once
/// What each field of each message may be, and the check of a serialised sample against it. The check reads the bytes
/// as they came from the network, before any memory is taken for the sample. It allocates nothing unless it refuses.
/// Standard library only; all functions are pure and thread-safe.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace hecaton::bus {

/// No node accepts a greater term. A cell takes a term for each change of a leader or an arm lease.
constexpr std::uint64_t kLargestTerm = std::uint64_t{1} << 62U;
/// No node accepts a term that is this much greater than the greatest one that it has accepted or remembers.
constexpr std::uint64_t kTermLeap = std::uint64_t{1} << 20U;
/// The greatest first term of a process that knows none. It accepts a first one above kTermLeap only if it has heard no
/// smaller one for a while (TermLimit): no cell takes so many terms unless an intruder has raised them.
constexpr std::uint64_t kLargestFirstTerm = std::uint64_t{1} << 40U;
/// A term that a process may remember: its cell must be able to take greater ones.
[[nodiscard]] constexpr bool is_usable_term(std::uint64_t term) {
  return term <= kLargestTerm - kTermLeap;
}

enum class FieldKind : std::uint8_t {
  kBool,
  kInt32,
  kUint32,
  kInt64,
  kUint64,
  kTerm,  ///< a 64-bit term, see kLargestTerm
  kEnum,  ///< from 0 to `high`
  kFloat,
  kDouble,
  kName,     ///< text for programs: printable UTF-8 of at most `most` bytes
  kText,     ///< text for people: the same, with line breaks and tabs
  kStruct,   ///< of type `of`
  kDoubles,  ///< a sequence
  kUint32s,  ///< a sequence
  kNames,    ///< a sequence of at most `most` names
  kStructs   ///< a sequence of `of`
};

struct StructRule;

/// One field. Numbers lie within [low, high], which excludes what is not finite; the other members mean nothing for
/// kinds that do not name them.
struct FieldRule {
  std::string_view name;
  FieldKind kind{};
  double low = 0.0;
  double high = 0.0;
  std::uint32_t most = 0;  ///< bytes of a text, elements of a sequence
  const StructRule* of = nullptr;
};

/// A structure: its fields in the order of the idl file.
struct StructRule {
  std::string_view name;
  std::span<const FieldRule> fields;
};

struct TopicRule {
  StructRule sample;
  std::uint32_t most_bytes = 0;     ///< of a serialised sample
  std::uint32_t most_a_second = 0;  ///< samples of one writer
};

/// The rule of a message type of idl/, by its name without namespace; null: a type of another folder.
[[nodiscard]] const TopicRule* topic_rule(std::string_view type);
/// All rules, for tests and documents.
[[nodiscard]] std::span<const TopicRule> topic_rules();

/// For types of other folders.
constexpr std::uint32_t kMostBytes = 1U << 20U;
/// The longest name that any field may hold [byte].
constexpr std::uint32_t kLongestName = 200;

struct CheckedSample {
  std::optional<std::string> refusal{};  ///< a sentence, with the field and its value; nothing: every rule is kept
  std::uint64_t largest_term = 0;        ///< of its fields of kind kTerm
  bool other_schema = false;             ///< nothing but its schema version was checked: it must not be decoded
};
/// Checks a serialised sample with its encapsulation.
[[nodiscard]] CheckedSample check_sample(const TopicRule& rule, std::span<const std::uint8_t> bytes);

/// Why `text` is no printable UTF-8: control characters, directional overrides and invalid sequences. Nothing: it is.
/// `lines`: line breaks and tabs are allowed.
[[nodiscard]] std::optional<std::string_view> unprintable(std::string_view text, bool lines = false);
/// `text` with "?" for each byte that is not part of printable UTF-8, at most `most` bytes long.
[[nodiscard]] std::string printable(std::string_view text, std::size_t most);

}  // namespace hecaton::bus
