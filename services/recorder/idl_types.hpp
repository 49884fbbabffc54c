#pragma once
/// The types of an IDL text: what idl/ uses of the language, and no more. A recording brings such a text, which may be
/// damaged or made by anyone: everything that is read from it is bounded.

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace hecaton::services::recorder {

/// An IDL text that cannot be read. what() is a phrase: "line 7: ';' is expected, and '}' stands there".
class IdlError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

enum class IdlKind : std::uint8_t {
  kBool,
  kChar,
  kInt8,
  kUint8,
  kInt16,
  kUint16,
  kInt32,
  kUint32,
  kInt64,
  kUint64,
  kFloat,
  kDouble,
  kString,
  kEnum,
  kSequence,
  kArray,
  kStruct
};

/// A number, a truth value, a text, or the label of an enumeration; monostate: none is given.
struct IdlLabel {
  std::string name;
  bool operator==(const IdlLabel&) const = default;
};
using IdlValue = std::variant<std::monostate, std::int64_t, double, bool, std::string, IdlLabel>;

struct IdlType;

struct IdlField {
  std::string name;
  const IdlType* type = nullptr;  ///< never null
  IdlValue otherwise;             ///< of @default
};

struct IdlType {
  IdlKind kind{};
  std::string name{};                                           ///< of a structure or an enumeration
  std::vector<IdlField> fields{};                               ///< of a structure: at least one
  std::vector<std::pair<std::string, std::uint32_t>> labels{};  ///< of an enumeration: at least one
  const IdlType* element = nullptr;                             ///< of a sequence or an array
  std::uint32_t length = 0;                                     ///< of an array: at least 1
  int depth = 0;                                                ///< types within types, at most kDeepest

  /// As in a sentence: "sequence of double", "enumeration Mode".
  [[nodiscard]] std::string text() const;
  /// Null: the structure has none.
  [[nodiscard]] const IdlField* field(std::string_view wanted) const;
};

/// A name may be given to one type or constant only, whatever its module.
class IdlTypes {
 public:
  static constexpr std::size_t kLongest = std::size_t{1} << 18U;  ///< text [byte]
  static constexpr int kDeepest = 16;

  /// Throws IdlError.
  explicit IdlTypes(std::string_view text);
  IdlTypes(const IdlTypes&) = delete;
  IdlTypes& operator=(const IdlTypes&) = delete;

  /// Null: there is none. The name has no module.
  [[nodiscard]] const IdlType* structure(std::string_view name) const;
  /// A whole number; empty: there is no such constant.
  [[nodiscard]] std::optional<std::int64_t> constant(std::string_view name) const;

 private:
  friend class IdlParser;

  std::deque<IdlType> types_;  ///< they point to each other
  std::map<std::string, const IdlType*, std::less<>> names_;
  std::map<std::string, IdlValue, std::less<>> constants_;
};

}  // namespace hecaton::services::recorder
