#include "services/recorder/idl_types.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <limits>
#include <set>

namespace hecaton::services::recorder {
namespace {

struct IdlToken {
  enum class Kind : std::uint8_t { kName, kNumber, kText, kMark, kEnd };
  Kind kind = Kind::kEnd;
  std::string_view text;  ///< of a text: without its quotes
  int line = 1;
};

[[noreturn]] void refuse_idl(int line, const std::string& phrase) {
  throw IdlError("line " + std::to_string(line) + ": " + phrase);
}

bool is_name_character(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_';
}

/// Splits the text. Comments and lines of the preprocessor are left out.
class IdlTokens {
 public:
  explicit IdlTokens(std::string_view text) : text_(text) { advance(); }

  [[nodiscard]] const IdlToken& peek() const { return token_; }
  IdlToken take() {
    const IdlToken taken = token_;
    advance();
    return taken;
  }

 private:
  void advance() {
    skip_blanks();
    token_ = {IdlToken::Kind::kEnd, {}, line_};
    if (text_.empty()) return;
    const char first = text_.front();
    if (first == '"') return take_text();
    const bool digit = std::isdigit(static_cast<unsigned char>(first)) != 0;
    std::size_t size = 1;
    token_.kind = IdlToken::Kind::kMark;
    if (digit) {
      token_.kind = IdlToken::Kind::kNumber;
      const auto continues = [&] {
        const char c = text_[size];
        const bool exponent = text_[size - 1] == 'e' || text_[size - 1] == 'E';
        return is_name_character(c) || c == '.' || (exponent && (c == '+' || c == '-'));
      };
      while (size < text_.size() && continues()) ++size;
    } else if (is_name_character(first)) {
      token_.kind = IdlToken::Kind::kName;
      while (size < text_.size() && is_name_character(text_[size])) ++size;
    } else if (text_.starts_with("::")) {
      size = 2;
    }
    token_.text = text_.substr(0, size);
    text_.remove_prefix(size);
  }

  void take_text() {
    const std::size_t end = text_.find('"', 1);
    const std::string_view value = text_.substr(1, end == std::string_view::npos ? end : end - 1);
    const bool plain = end != std::string_view::npos && value.find_first_of("\\\n") == std::string_view::npos;
    if (!plain) refuse_idl(line_, "a text must end on its line and have no backslash");
    token_.kind = IdlToken::Kind::kText;
    token_.text = value;
    text_.remove_prefix(end + 1);
  }

  void skip_blanks() {
    while (!text_.empty()) {
      const char c = text_.front();
      if (c == '#' || text_.starts_with("//")) {
        text_.remove_prefix(std::min(text_.find('\n'), text_.size()));
      } else if (text_.starts_with("/*")) {
        const std::size_t end = text_.find("*/", 2);
        if (end == std::string_view::npos) refuse_idl(line_, "a comment has no end");
        line_ += static_cast<int>(std::count(text_.begin(), text_.begin() + static_cast<std::ptrdiff_t>(end), '\n'));
        text_.remove_prefix(end + 2);
      } else if (std::isspace(static_cast<unsigned char>(c)) != 0) {
        if (c == '\n') ++line_;
        text_.remove_prefix(1);
      } else {
        return;
      }
    }
  }

  std::string_view text_;
  IdlToken token_;
  int line_ = 1;
};

/// For sentences: a token of a damaged text may be long, or may have any bytes.
std::string quoted(const IdlToken& token) {
  if (token.kind == IdlToken::Kind::kEnd) return "the end";
  std::string text(token.text.substr(0, 40));
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
  return "'" + text + "'";
}

struct PlainIdlType {
  std::string_view name;
  IdlKind kind;
};
constexpr std::array kPlainTypes{PlainIdlType{"boolean", IdlKind::kBool},  PlainIdlType{"char", IdlKind::kChar},
                                 PlainIdlType{"octet", IdlKind::kUint8},   PlainIdlType{"int8", IdlKind::kInt8},
                                 PlainIdlType{"uint8", IdlKind::kUint8},   PlainIdlType{"int16", IdlKind::kInt16},
                                 PlainIdlType{"uint16", IdlKind::kUint16}, PlainIdlType{"int32", IdlKind::kInt32},
                                 PlainIdlType{"uint32", IdlKind::kUint32}, PlainIdlType{"int64", IdlKind::kInt64},
                                 PlainIdlType{"uint64", IdlKind::kUint64}, PlainIdlType{"float", IdlKind::kFloat},
                                 PlainIdlType{"double", IdlKind::kDouble}, PlainIdlType{"short", IdlKind::kInt16}};

/// Those that do not change the bytes of plain CDR.
constexpr std::array<std::string_view, 10> kHarmlessAnnotations{"final", "appendable", "nested", "key",   "topic",
                                                                "unit",  "min",        "max",    "range", "id"};

}  // namespace

class IdlParser {
 public:
  IdlParser(std::string_view text, IdlTypes& types) : tokens_(text), types_(types) {}

  void run() {
    while (tokens_.peek().kind != IdlToken::Kind::kEnd) definition(0);
  }

 private:
  /// What annotations before a definition, a field or a label say.
  struct Annotations {
    IdlValue otherwise;
    std::optional<std::uint64_t> value;
  };

  [[nodiscard]] int line() const { return tokens_.peek().line; }
  [[nodiscard]] bool at(std::string_view text) const {
    const IdlToken& token = tokens_.peek();
    return token.text == text && token.kind != IdlToken::Kind::kText && token.kind != IdlToken::Kind::kEnd;
  }
  bool accept(std::string_view text) {
    if (!at(text)) return false;
    static_cast<void>(tokens_.take());
    return true;
  }
  void expect(std::string_view text) {
    if (accept(text)) return;
    refuse_idl(line(), "'" + std::string(text) + "' is expected, and " + quoted(tokens_.peek()) + " stands there");
  }
  std::string name() {
    const IdlToken token = tokens_.take();
    if (token.kind != IdlToken::Kind::kName)
      refuse_idl(token.line, "a name is expected, and " + quoted(token) + " stands there");
    if (token.text.size() > 200) refuse_idl(token.line, "a name is longer than 200 characters");
    return std::string(token.text);
  }
  /// The last part of a name with modules.
  std::string scoped_name() {
    static_cast<void>(accept("::"));
    std::string last = name();
    while (accept("::")) last = name();
    return last;
  }

  void definition(int depth) {
    static_cast<void>(annotations());
    if (accept("module")) {
      if (depth >= IdlTypes::kDeepest) refuse_idl(line(), "modules stand within more than 16 modules");
      static_cast<void>(name());
      expect("{");
      while (!at("}")) definition(depth + 1);
      expect("}");
    } else if (accept("struct")) {
      structure();
    } else if (accept("enum")) {
      enumeration();
    } else if (accept("const")) {
      constant();
    } else if (accept("typedef")) {
      const IdlType* of = type(0);
      std::string alias = name();
      add_name(std::move(alias), dimensions(of));
    } else {
      refuse_idl(line(), "a structure, enumeration, constant or typedef is expected, and " + quoted(tokens_.peek()) +
                             " stands there");
    }
    expect(";");
  }

  void add_name(std::string given, const IdlType* meaning) {
    const bool taken = types_.constants_.count(given) > 0 || !types_.names_.emplace(given, meaning).second;
    if (taken) refuse_idl(line(), "'" + given + "' is defined twice");
  }

  void structure() {
    IdlType made{.kind = IdlKind::kStruct, .name = name()};
    expect("{");
    std::set<std::string, std::less<>> names;
    while (!accept("}")) {
      const Annotations said = annotations();
      const IdlType* of = type(0);
      do {
        IdlField field{name(), nullptr, said.otherwise};
        field.type = dimensions(of);
        if (!names.insert(field.name).second) refuse_idl(line(), "field '" + field.name + "' is defined twice");
        made.depth = std::max(made.depth, field.type->depth + 1);
        made.fields.push_back(std::move(field));
      } while (accept(","));
      expect(";");
    }
    if (made.fields.empty()) refuse_idl(line(), "structure '" + made.name + "' has no fields");
    add(std::move(made));
  }

  void enumeration() {
    IdlType made{.kind = IdlKind::kEnum, .name = name()};
    expect("{");
    std::uint64_t next = 0;
    std::set<std::string, std::less<>> names;
    std::set<std::uint64_t> numbers;
    do {
      const Annotations said = annotations();
      next = said.value.value_or(next);
      std::string label = name();
      const bool fits = next <= std::numeric_limits<std::uint32_t>::max();
      if (!fits || !names.insert(label).second || !numbers.insert(next).second) {
        refuse_idl(line(), "label '" + label + "' or its number is defined twice");
      }
      made.labels.emplace_back(std::move(label), static_cast<std::uint32_t>(next++));
    } while (accept(","));
    expect("}");
    add(std::move(made));
  }

  void add(IdlType made) {
    if (made.depth > IdlTypes::kDeepest) refuse_idl(line(), "'" + made.name + "' has more than 16 types within types");
    std::string given = made.name;
    const IdlType* meaning = &types_.types_.emplace_back(std::move(made));
    if (!given.empty()) add_name(std::move(given), meaning);
  }
  const IdlType* unnamed(IdlType made) {
    add(std::move(made));
    return &types_.types_.back();
  }

  void constant() {
    static_cast<void>(type(0));
    std::string given = name();
    expect("=");
    IdlValue meaning = value();
    const bool taken = types_.names_.count(given) > 0 || !types_.constants_.emplace(given, std::move(meaning)).second;
    if (taken) refuse_idl(line(), "'" + given + "' is defined twice");
  }

  const IdlType* type(int depth) {
    if (depth > IdlTypes::kDeepest) refuse_idl(line(), "sequences stand within more than 16 sequences");
    if (accept("sequence")) {
      expect("<");
      const IdlType* element = type(depth + 1);
      if (accept(",")) static_cast<void>(count());
      expect(">");
      return unnamed({.kind = IdlKind::kSequence, .element = element, .depth = element->depth + 1});
    }
    if (accept("string")) {
      if (accept("<")) {
        static_cast<void>(count());
        expect(">");
      }
      return plain(IdlKind::kString);
    }
    if (accept("unsigned")) {
      if (accept("short")) return plain(IdlKind::kUint16);
      expect("long");
      return plain(accept("long") ? IdlKind::kUint64 : IdlKind::kUint32);
    }
    if (accept("long")) {
      if (at("double")) refuse_idl(line(), "the type 'long double' is not known");
      return plain(accept("long") ? IdlKind::kInt64 : IdlKind::kInt32);
    }
    for (const PlainIdlType& one : kPlainTypes) {
      if (accept(one.name)) return plain(one.kind);
    }
    const IdlToken token = tokens_.peek();
    const std::string given = scoped_name();
    const auto found = types_.names_.find(given);
    if (found == types_.names_.end()) refuse_idl(token.line, "the type " + quoted(token) + " is not known");
    return found->second;
  }

  const IdlType* plain(IdlKind kind) {
    const IdlType*& known = plain_[static_cast<std::size_t>(kind)];
    if (known == nullptr) known = unnamed({.kind = kind});
    return known;
  }

  /// `double m[2][3]`: 2 times an array of 3.
  const IdlType* dimensions(const IdlType* of) {
    std::vector<std::uint32_t> lengths;
    while (accept("[")) {
      lengths.push_back(count());
      expect("]");
      if (lengths.size() > static_cast<std::size_t>(IdlTypes::kDeepest))
        refuse_idl(line(), "an array has too many dimensions");
    }
    for (auto length = lengths.rbegin(); length != lengths.rend(); ++length) {
      of = unnamed({.kind = IdlKind::kArray, .element = of, .length = *length, .depth = of->depth + 1});
    }
    return of;
  }

  /// A number of elements.
  std::uint32_t count() {
    const int where = line();
    const IdlValue given = value();
    const auto* number = std::get_if<std::int64_t>(&given);
    const bool fits = number != nullptr && *number > 0 && *number <= std::numeric_limits<std::uint32_t>::max();
    if (!fits) refuse_idl(where, "a number of elements from 1 to 4294967295 is expected");
    return static_cast<std::uint32_t>(*number);
  }

  /// A literal, or the name of a constant or of a label.
  IdlValue value() {
    const bool negative = accept("-");
    const IdlToken token = tokens_.peek();
    if (token.kind == IdlToken::Kind::kNumber) {
      static_cast<void>(tokens_.take());
      return number(token, negative);
    }
    if (!negative && token.kind == IdlToken::Kind::kText) return std::string(tokens_.take().text);
    if (negative || token.kind != IdlToken::Kind::kName) {
      refuse_idl(token.line, "a value is expected, and " + quoted(token) + " stands there");
    }
    if (accept("TRUE")) return true;
    if (accept("FALSE")) return false;
    std::string given = scoped_name();
    const auto known = types_.constants_.find(given);
    if (known != types_.constants_.end()) return known->second;
    return IdlLabel{std::move(given)};
  }

  static IdlValue number(const IdlToken& token, bool negative) {
    const char* begin = token.text.data();
    const char* end = begin + token.text.size();
    std::int64_t whole = 0;
    if (const auto read = std::from_chars(begin, end, whole); read.ptr == end && read.ec == std::errc()) {
      return negative ? -whole : whole;
    }
    double real = 0.0;
    const auto read = std::from_chars(begin, end, real);
    if (read.ptr != end || read.ec != std::errc())
      refuse_idl(token.line, quoted(token) + " is no number that is known");
    return negative ? -real : real;
  }

  Annotations annotations() {
    Annotations said;
    while (accept("@")) {
      const IdlToken token = tokens_.peek();
      const std::string which = scoped_name();
      if (which == "default") {
        said.otherwise = parameter();
      } else if (which == "value") {
        const int where = line();
        const IdlValue given = parameter();
        const auto* number = std::get_if<std::int64_t>(&given);
        if (number == nullptr || *number < 0 || *number > std::numeric_limits<std::uint32_t>::max()) {
          refuse_idl(where, "@value needs a number from 0 to 4294967295");
        }
        said.value = static_cast<std::uint64_t>(*number);
      } else if (std::find(kHarmlessAnnotations.begin(), kHarmlessAnnotations.end(), which) !=
                 kHarmlessAnnotations.end()) {
        if (at("(")) skip_parameters();
      } else {
        refuse_idl(token.line, "the annotation " + quoted(token) + " is not known");
      }
    }
    return said;
  }

  IdlValue parameter() {
    expect("(");
    IdlValue given = value();
    expect(")");
    return given;
  }
  void skip_parameters() {
    expect("(");
    while (!accept(")")) {
      if (tokens_.take().kind == IdlToken::Kind::kEnd) refuse_idl(line(), "an annotation has no end");
    }
  }

  IdlTokens tokens_;
  IdlTypes& types_;
  std::array<const IdlType*, static_cast<std::size_t>(IdlKind::kStruct) + 1> plain_{};
};

IdlTypes::IdlTypes(std::string_view text) {
  if (text.size() > kLongest)
    throw IdlError("it has " + std::to_string(text.size()) + " bytes, at most 262144 are read");
  IdlParser(text, *this).run();
}

const IdlType* IdlTypes::structure(std::string_view name) const {
  const auto found = names_.find(name);
  return found == names_.end() || found->second->kind != IdlKind::kStruct ? nullptr : found->second;
}

std::optional<std::int64_t> IdlTypes::constant(std::string_view name) const {
  const auto found = constants_.find(name);
  const auto* number = found == constants_.end() ? nullptr : std::get_if<std::int64_t>(&found->second);
  return number == nullptr ? std::nullopt : std::optional(*number);
}

std::string IdlType::text() const {
  switch (kind) {
    case IdlKind::kBool:
      return "boolean";
    case IdlKind::kChar:
      return "char";
    case IdlKind::kInt8:
      return "int8";
    case IdlKind::kUint8:
      return "octet";
    case IdlKind::kInt16:
      return "short";
    case IdlKind::kUint16:
      return "unsigned short";
    case IdlKind::kInt32:
      return "long";
    case IdlKind::kUint32:
      return "unsigned long";
    case IdlKind::kInt64:
      return "long long";
    case IdlKind::kUint64:
      return "unsigned long long";
    case IdlKind::kFloat:
      return "float";
    case IdlKind::kDouble:
      return "double";
    case IdlKind::kString:
      return "string";
    case IdlKind::kEnum:
      return "enumeration " + name;
    case IdlKind::kSequence:
      return "sequence of " + element->text();
    case IdlKind::kArray:
      return "array of " + std::to_string(length) + " " + element->text();
    case IdlKind::kStruct:
      break;
  }
  return "structure " + name;
}

const IdlField* IdlType::field(std::string_view wanted) const {
  const auto found =
      std::find_if(fields.begin(), fields.end(), [&](const IdlField& field) { return field.name == wanted; });
  return found == fields.end() ? nullptr : &*found;
}

}  // namespace hecaton::services::recorder
