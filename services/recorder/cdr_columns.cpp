#include "services/recorder/cdr_columns.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <string_view>

#include <idl/common.h>
#include <nlohmann/json.hpp>

#include "services/bus/recorded_sample.hpp"
#include "services/recorder/cdr_reader.hpp"

namespace hecaton::services::recorder {
namespace {

using Json = nlohmann::ordered_json;
using bus::FieldKind;
using bus::FieldRule;
using bus::StructRule;

/// A value that is no structure and no sequence.
Json scalar(FieldKind kind, CdrReader& in) {
  switch (kind) {
    case FieldKind::kBool:
      return in.number<std::uint8_t>();
    case FieldKind::kInt32:
      return in.number<std::int32_t>();
    case FieldKind::kUint32:
    case FieldKind::kEnum:
    case FieldKind::kUint32s:
      return in.number<std::uint32_t>();
    case FieldKind::kInt64:
      return in.number<std::int64_t>();
    case FieldKind::kUint64:
    case FieldKind::kTerm:
      return in.number<std::uint64_t>();
    case FieldKind::kFloat:
      return in.number<float>();
    case FieldKind::kDouble:
    case FieldKind::kDoubles:
      return in.number<double>();
    case FieldKind::kName:
    case FieldKind::kText:
    case FieldKind::kNames:
      return in.text();
    case FieldKind::kStruct:
    case FieldKind::kStructs:
      break;
  }
  return nullptr;
}

void skip_scalar(FieldKind kind, CdrReader& in) {
  if (kind == FieldKind::kDouble || kind == FieldKind::kDoubles) {
    static_cast<void>(in.number<double>());
  } else if (kind == FieldKind::kName || kind == FieldKind::kText || kind == FieldKind::kNames) {
    in.skip_text();
  } else {
    static_cast<void>(scalar(kind, in));
  }
}

bool is_sequence(FieldKind kind) {
  return kind == FieldKind::kDoubles || kind == FieldKind::kUint32s || kind == FieldKind::kNames ||
         kind == FieldKind::kStructs;
}

bool has_columns(const FieldRule& field) {
  return (field.kind == FieldKind::kDoubles || field.kind == FieldKind::kUint32s) &&
         field.most <= CdrColumns::kMostElements;
}

Json value_of(const FieldRule& field, CdrReader& in);

Json object_of(const StructRule& rule, CdrReader& in) {
  Json object = Json::object();
  for (const FieldRule& field : rule.fields) object[std::string(field.name)] = value_of(field, in);
  return object;
}

Json value_of(const FieldRule& field, CdrReader& in) {
  if (field.kind == FieldKind::kStruct) return object_of(*field.of, in);
  if (!is_sequence(field.kind)) return scalar(field.kind, in);
  Json list = Json::array();
  const auto count = in.number<std::uint32_t>();
  for (std::uint32_t i = 0; i < count; ++i) {
    list.push_back(field.kind == FieldKind::kStructs ? object_of(*field.of, in) : scalar(field.kind, in));
  }
  return list;
}

/// Passes over what value_of() would read. Reading is far slower.
void skip(const FieldRule& field, CdrReader& in) {
  const std::uint32_t count = is_sequence(field.kind) ? in.number<std::uint32_t>() : 1;
  const bool structures = field.kind == FieldKind::kStruct || field.kind == FieldKind::kStructs;
  for (std::uint32_t i = 0; i < count; ++i) {
    if (structures) {
      for (const FieldRule& inner : field.of->fields) skip(inner, in);
    } else {
      skip_scalar(field.kind, in);
    }
  }
}

template <class T>
std::string shortest(T value) {
  std::array<char, 32> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
  return {text.data(), end};
}

std::string cell(FieldKind kind, CdrReader& in) {
  if (kind == FieldKind::kDouble || kind == FieldKind::kDoubles) return shortest(in.number<double>());
  if (kind == FieldKind::kFloat) return shortest(in.number<float>());
  const Json value = scalar(kind, in);
  return value.is_string() ? value.get<std::string>() : value.dump();
}

std::string path_of(const std::string& prefix, std::string_view name) {
  return prefix.empty() ? std::string(name) : prefix + "." + std::string(name);
}

using Lengths = std::map<std::string, std::size_t>;

void measure_fields(const StructRule& rule, const std::string& prefix, CdrReader& in, Lengths& lengths) {
  for (const FieldRule& field : rule.fields) {
    const std::string path = path_of(prefix, field.name);
    if (field.kind == FieldKind::kStruct) {
      measure_fields(*field.of, path, in, lengths);
    } else if (has_columns(field)) {
      const auto count = in.number<std::uint32_t>();
      lengths[path] = std::max<std::size_t>(lengths[path], count);
      for (std::uint32_t i = 0; i < count; ++i) skip_scalar(field.kind, in);
    } else {
      skip(field, in);
    }
  }
}

std::size_t length_of(const Lengths& lengths, const std::string& path) {
  const auto found = lengths.find(path);
  return found == lengths.end() ? 0 : found->second;
}

void put_names(const StructRule& rule, const std::string& prefix, const Lengths& lengths,
               std::vector<std::string>& names) {
  for (const FieldRule& field : rule.fields) {
    const std::string path = path_of(prefix, field.name);
    if (field.kind == FieldKind::kStruct) {
      put_names(*field.of, path, lengths, names);
    } else if (has_columns(field)) {
      for (std::size_t i = 0; i < length_of(lengths, path); ++i) names.push_back(path + "[" + std::to_string(i) + "]");
    } else {
      names.push_back(path);
    }
  }
}

void put_cells(const StructRule& rule, const std::string& prefix, const Lengths& lengths, CdrReader& in,
               std::vector<std::string>& cells) {
  for (const FieldRule& field : rule.fields) {
    const std::string path = path_of(prefix, field.name);
    if (field.kind == FieldKind::kStruct) {
      put_cells(*field.of, path, lengths, in, cells);
    } else if (has_columns(field)) {
      const std::size_t begin = cells.size();
      const auto count = in.number<std::uint32_t>();
      for (std::uint32_t i = 0; i < count; ++i) cells.push_back(cell(field.kind, in));
      cells.resize(begin + std::max<std::size_t>(count, length_of(lengths, path)));
    } else if (is_sequence(field.kind)) {
      cells.push_back(value_of(field, in).dump());
    } else {
      cells.push_back(cell(field.kind, in));
    }
  }
}

}  // namespace

std::optional<std::string> CdrColumns::measure(ByteSpan message) {
  const bus::CheckedSample checked = bus::check_sample(rule_, message);
  if (checked.other_schema) {
    return "version " + std::to_string(bus::schema_in(message)) + " is not version " +
           std::to_string(msg::SCHEMA_VERSION) + " of this program";
  }
  if (checked.refusal) return *checked.refusal;
  CdrReader in(message);
  measure_fields(rule_.sample, "", in, lengths_);
  return std::nullopt;
}

std::vector<std::string> CdrColumns::header() const {
  std::vector<std::string> names;
  put_names(rule_.sample, "", lengths_, names);
  return names;
}

std::vector<std::string> CdrColumns::row(ByteSpan message) const {
  std::vector<std::string> cells;
  CdrReader in(message);
  put_cells(rule_.sample, "", lengths_, in, cells);
  return cells;
}

std::string csv_line(const std::vector<std::string>& cells) {
  std::string line;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (i > 0) line += ',';
    if (cells[i].find_first_of(",\"\r\n") == std::string::npos) {
      line += cells[i];
      continue;
    }
    line += '"';
    for (const char c : cells[i]) line.append(c == '"' ? 2 : 1, c);
    line += '"';
  }
  return line + "\r\n";
}

}  // namespace hecaton::services::recorder
