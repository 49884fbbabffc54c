#include "services/recorder/message_conversion.hpp"

#include <algorithm>
#include <array>
#include <limits>

#include "services/recorder/cdr_reader.hpp"

namespace hecaton::services::recorder {
namespace {

constexpr std::string_view kVersionField = "schema";

bool is_whole_number(IdlKind kind) {
  return kind >= IdlKind::kInt8 && kind <= IdlKind::kUint64;
}
bool is_number(IdlKind kind) {
  return is_whole_number(kind) || kind == IdlKind::kFloat || kind == IdlKind::kDouble;
}

int bits_of(IdlKind kind) {
  constexpr std::array kBits{8, 8, 16, 16, 32, 32, 64, 64};
  return kBits.at(static_cast<std::size_t>(kind) - static_cast<std::size_t>(IdlKind::kInt8));
}
bool is_signed(IdlKind kind) {
  return (static_cast<int>(kind) - static_cast<int>(IdlKind::kInt8)) % 2 == 0;
}

/// Each value of the first type is one of the second.
bool widens(IdlKind from, IdlKind to) {
  if (from == to) return true;
  if (from == IdlKind::kFloat) return to == IdlKind::kDouble;
  if (!is_whole_number(from)) return false;
  if (to == IdlKind::kDouble) return bits_of(from) <= 32;
  if (to == IdlKind::kFloat) return bits_of(from) <= 16;
  if (!is_whole_number(to)) return false;
  return is_signed(from) ? is_signed(to) && bits_of(from) <= bits_of(to)
                         : bits_of(from) < bits_of(to) || (bits_of(from) == bits_of(to) && !is_signed(to));
}

/// The field that was refused is within this one.
ConversionError within(const std::string& field, const ConversionError& error) {
  const std::string inner = error.what();
  return ConversionError(field + (inner.starts_with(' ') ? "" : ".") + inner);
}

template <class Function>
void in_field(const std::string& field, const Function& function) {
  try {
    function();
  } catch (const ConversionError& error) {
    throw within(field, error);
  } catch (const std::out_of_range&) {
    throw ConversionError(field + " is cut off");
  }
}

/// Calls `function` with a value of the C++ type of `kind`, which is a number, a truth value or a character.
template <class Function>
void with_type_of(IdlKind kind, const Function& function) {
  switch (kind) {
    case IdlKind::kBool:
    case IdlKind::kChar:
    case IdlKind::kUint8:
      return function(std::uint8_t{});
    case IdlKind::kInt8:
      return function(std::int8_t{});
    case IdlKind::kInt16:
      return function(std::int16_t{});
    case IdlKind::kUint16:
      return function(std::uint16_t{});
    case IdlKind::kInt32:
      return function(std::int32_t{});
    case IdlKind::kUint32:
    case IdlKind::kEnum:
      return function(std::uint32_t{});
    case IdlKind::kInt64:
      return function(std::int64_t{});
    case IdlKind::kUint64:
      return function(std::uint64_t{});
    case IdlKind::kFloat:
      return function(float{});
    case IdlKind::kDouble:
      return function(double{});
    case IdlKind::kString:
    case IdlKind::kSequence:
    case IdlKind::kArray:
    case IdlKind::kStruct:
      return;
  }
}

/// The number of a default; 0: none is given.
template <class T>
T number_of(const IdlValue& value) {
  if (const auto* whole = std::get_if<std::int64_t>(&value)) return static_cast<T>(*whole);
  if (const auto* truth = std::get_if<bool>(&value)) return static_cast<T>(*truth);
  const auto* real = std::get_if<double>(&value);
  if constexpr (std::is_floating_point_v<T>) return real == nullptr ? T{} : static_cast<T>(*real);
  return T{};
}

std::uint32_t label_of(const IdlType& type, const IdlValue& value) {
  const auto* wanted = std::get_if<IdlLabel>(&value);
  const auto found = std::find_if(type.labels.begin(), type.labels.end(),
                                  [&](const auto& label) { return wanted != nullptr && label.first == wanted->name; });
  return found == type.labels.end() ? type.labels.front().second : found->second;
}

}  // namespace

/// Writes plain CDR, little-endian.
class MessageConversion::Writer {
 public:
  Writer(Bytes& bytes, std::size_t most_bytes) : bytes_(bytes), most_(most_bytes) { bytes_.assign({0, 1, 0, 0}); }

  template <class T>
  void number(T value) {
    align(sizeof(T));
    using Raw = std::array<std::uint8_t, sizeof(T)>;
    Raw raw = std::bit_cast<Raw>(value);
    if (std::endian::native == std::endian::big) std::reverse(raw.begin(), raw.end());
    append(raw);
  }
  /// `value` has the 0 at its end, or is empty.
  void text(ByteSpan value) {
    number(static_cast<std::uint32_t>(std::max<std::size_t>(value.size(), 1)));
    static constexpr std::array<std::uint8_t, 1> kEnd{0};
    append(value.empty() ? ByteSpan(kEnd) : value);
  }
  void otherwise(const IdlType& type, const IdlValue& value) {
    switch (type.kind) {
      case IdlKind::kEnum:
        return number(label_of(type, value));
      case IdlKind::kString: {
        const auto* given = std::get_if<std::string>(&value);
        const std::string none;
        const std::string& chosen = given == nullptr ? none : *given;
        return text({reinterpret_cast<const std::uint8_t*>(chosen.c_str()), chosen.size() + 1});
      }
      case IdlKind::kSequence:
        return number(std::uint32_t{0});
      case IdlKind::kArray:
        for (std::uint32_t i = 0; i < type.length; ++i) otherwise(*type.element, {});
        return;
      case IdlKind::kStruct:
        for (const IdlField& field : type.fields) otherwise(*field.type, field.otherwise);
        return;
      default:
        return with_type_of(type.kind, [&](auto zero) { number(number_of<decltype(zero)>(value)); });
    }
  }

 private:
  void align(std::size_t size) {
    const std::size_t behind = (bytes_.size() - CdrReader::kEncapsulation) % size;
    if (behind > 0) bytes_.resize(bytes_.size() + size - behind);
  }
  void append(ByteSpan raw) {
    if (raw.size() > most_ || bytes_.size() > most_ - raw.size()) {
      throw ConversionError(" makes the message longer than " + std::to_string(most_) +
                            " bytes, the most that is allowed");
    }
    bytes_.insert(bytes_.end(), raw.begin(), raw.end());
  }

  Bytes& bytes_;
  std::size_t most_;
};

/// The conversion of one message.
class MessageConversion::Run {
 public:
  Run(ByteSpan message, Writer& out) : in_(message), out_(out) {}

  void convert(const Structure& structure) {
    if (structure.in_order) return convert_in_order(structure);
    std::vector<std::size_t> places;
    for (const IdlField& field : structure.from->fields) {
      places.push_back(in_.at());
      in_field(field.name, [&] { skip(*field.type); });
    }
    const std::size_t end = in_.at();
    for (std::size_t i = 0; i < structure.to->fields.size(); ++i) {
      if (const auto source = structure.sources[i]) in_.move_to(places[*source]);
      put(structure, i);
    }
    in_.move_to(end);
  }

  [[nodiscard]] bool ended() const {
    constexpr std::size_t kPadding = 8;  // as the check of the wire allows
    return in_.left() <= kPadding;
  }

 private:
  void convert_in_order(const Structure& structure) {
    std::size_t next = 0;
    const auto skip_to = [&](std::size_t end) {
      for (; next < end; ++next) {
        const IdlField& field = structure.from->fields[next];
        in_field(field.name, [&] { skip(*field.type); });
      }
    };
    for (std::size_t i = 0; i < structure.to->fields.size(); ++i) {
      if (const auto source = structure.sources[i]) {
        skip_to(*source);
        ++next;
      }
      put(structure, i);
    }
    skip_to(structure.from->fields.size());
  }

  /// The new field.
  void put(const Structure& structure, std::size_t i) {
    const IdlField& field = structure.to->fields[i];
    const auto source = structure.sources[i];
    in_field(field.name, [&] {
      if (!source) return out_.otherwise(*field.type, field.otherwise);
      if (const Step* step = structure.steps[*source]) return convert(*step);
      skip(*structure.from->fields[*source].type);  // the version of the old structure
      out_.otherwise(*field.type, field.otherwise);
    });
  }

  void convert(const Step& step) {
    switch (step.from->kind) {
      case IdlKind::kStruct:
        return convert(*step.structure);
      case IdlKind::kSequence: {
        const auto count = in_.number<std::uint32_t>();
        // Each element has a byte at least.
        if (count > in_.left()) throw std::out_of_range("cut off");
        out_.number(count);
        return convert_elements(step, count);
      }
      case IdlKind::kArray:
        return convert_elements(step, step.from->length);
      case IdlKind::kString: {
        const ByteSpan text = in_.text_bytes();
        if (!text.empty() && text.back() != 0) throw ConversionError(" does not end with 0");
        return out_.text(text);
      }
      case IdlKind::kEnum:
        return convert_label(step);
      default:
        return with_type_of(step.from->kind, [&](auto from) {
          const auto value = in_.number<decltype(from)>();
          with_type_of(step.to->kind, [&](auto to) { out_.number(static_cast<decltype(to)>(value)); });
        });
    }
  }

  void convert_elements(const Step& step, std::uint32_t count) {
    for (std::uint32_t i = 0; i < count; ++i) convert(*step.element);
  }

  void convert_label(const Step& step) {
    const auto number = in_.number<std::uint32_t>();
    const auto found = step.numbers.find(number);
    if (found == step.numbers.end()) {
      throw ConversionError(" is " + std::to_string(number) + ", which " + step.from->text() +
                            " of the recording does not have");
    }
    if (found->second) return out_.number(*found->second);
    const auto label = std::find_if(step.from->labels.begin(), step.from->labels.end(),
                                    [&](const auto& one) { return one.second == number; });
    throw ConversionError(" is " + label->first + ", which this program does not know");
  }

  /// Each value has a byte at least: the work is bounded by the bytes of the message.
  void skip(const IdlType& type) {
    switch (type.kind) {
      case IdlKind::kStruct:
        for (const IdlField& field : type.fields) skip(*field.type);
        return;
      case IdlKind::kSequence: {
        const auto count = in_.number<std::uint32_t>();
        if (count > in_.left()) throw std::out_of_range("cut off");
        for (std::uint32_t i = 0; i < count; ++i) skip(*type.element);
        return;
      }
      case IdlKind::kArray:
        for (std::uint32_t i = 0; i < type.length; ++i) skip(*type.element);
        return;
      case IdlKind::kString:
        return in_.skip_text();
      default:
        return with_type_of(type.kind, [&](auto value) { static_cast<void>(in_.number<decltype(value)>()); });
    }
  }

  CdrReader in_;
  Writer& out_;
};

MessageConversion::MessageConversion(const IdlType& from, const IdlType& to, std::size_t most_bytes)
    : most_bytes_(most_bytes) {
  root_ = structure(from, to, true);
}

ByteSpan MessageConversion::convert(ByteSpan message) {
  const bool plain = message.size() >= CdrReader::kEncapsulation && message[0] == 0 && message[1] <= 1;
  if (!plain) throw ConversionError("its encoding is not plain CDR");
  Writer writer(converted_, most_bytes_);
  Run run(message, writer);
  run.convert(*root_);
  if (!run.ended()) throw ConversionError(root_->from->name + " has too many bytes");
  return converted_;
}

const MessageConversion::Structure* MessageConversion::structure(const IdlType& from, const IdlType& to,
                                                                 bool outermost) {
  Structure made{.from = &from, .to = &to, .steps = std::vector<const Step*>(from.fields.size()), .sources = {}};
  for (const IdlField& field : to.fields) {
    const IdlField* source = from.field(field.name);
    const bool is_version = outermost && field.name == kVersionField;
    if (source == nullptr) {
      differ();
      made.sources.emplace_back();
      if (!is_version) added_.push_back(to.name + "." + field.name);
      continue;
    }
    const auto index = static_cast<std::size_t>(source - from.fields.data());
    const bool behind = std::all_of(made.sources.begin(), made.sources.end(),
                                    [&](const auto& former) { return !former || *former < index; });
    if (!behind) made.in_order = false;
    if (index != made.sources.size()) differ();
    made.sources.emplace_back(index);
    if (!is_version) in_field(field.name, [&] { made.steps[index] = step(*source->type, *field.type); });
  }
  for (const IdlField& field : from.fields) {
    if (to.field(field.name) != nullptr) continue;
    differ();
    removed_.push_back(from.name + "." + field.name);
  }
  return &structures_.emplace_back(std::move(made));
}

const MessageConversion::Step* MessageConversion::step(const IdlType& from, const IdlType& to) {
  const std::pair key(&from, &to);
  if (const auto found = known_.find(key); found != known_.end()) return found->second;
  Step made{.from = &from, .to = &to};
  const bool numbers = is_number(from.kind) && widens(from.kind, to.kind);
  const bool arrays = from.kind != IdlKind::kArray || from.length == to.length;
  if (!numbers && (from.kind != to.kind || !arrays)) {
    throw ConversionError(" is " + from.text() + " in the recording, and " + to.text() +
                          " in this program, which is no wider form of it");
  }
  if (from.kind != to.kind) differ();
  if (from.kind == IdlKind::kStruct) made.structure = structure(from, to, false);
  if (from.element != nullptr) made.element = step(*from.element, *to.element);
  for (const auto& [label, number] : from.labels) {
    const auto same = std::find_if(to.labels.begin(), to.labels.end(),
                                   [&, &name = label](const auto& one) { return one.first == name; });
    auto& meaning = made.numbers[number];
    if (same != to.labels.end()) meaning = same->second;
    if (meaning != number) differ();
  }
  return known_.emplace(key, &steps_.emplace_back(std::move(made))).first->second;
}

}  // namespace hecaton::services::recorder
