#include "services/command_line/document.hpp"

#include <algorithm>
#include <cstdio>
#include <vector>

#include "services/config/text.hpp"
#include "services/config/validate.hpp"

namespace hecaton::services::cli {
namespace {

constexpr auto kReplace = Json::error_handler_t::replace;  // of bytes that are not UTF-8

/// Scalars, empty maps and lists of scalars are the same text in JSON and YAML.
bool fits_one_line(const Json& value) {
  if (value.is_object()) return value.empty();
  if (!value.is_array()) return true;
  return std::all_of(value.begin(), value.end(), [](const Json& item) { return item.is_primitive(); });
}

std::string one_line(const Json& value) {
  if (!value.is_array()) return value.dump(-1, ' ', false, kReplace);
  std::string text = "[";
  for (const Json& item : value) {
    if (text.size() > 1) text += ", ";
    text += item.dump(-1, ' ', false, kReplace);
  }
  return text + "]";
}

void write(const Json& value, const std::string& indent, std::string& out);

/// Writes the value after "key:" or "-".
void write_after(const Json& value, const std::string& indent, bool in_list, std::string& out) {
  if (fits_one_line(value)) {
    out += " " + one_line(value) + "\n";
  } else if (in_list) {
    std::string nested;
    write(value, indent + "  ", nested);
    out += " " + nested.substr(indent.size() + 2);
  } else {
    out += "\n";
    write(value, indent + "  ", out);
  }
}

void write(const Json& value, const std::string& indent, std::string& out) {
  if (value.is_object()) {
    for (const auto& [key, item] : value.items()) {
      out += indent + Json(key).dump(-1, ' ', false, kReplace) + ":";
      write_after(item, indent, false, out);
    }
    return;
  }
  for (const Json& item : value) {
    out += indent + "-";
    write_after(item, indent, true, out);
  }
}

}  // namespace

std::string json_text(const Json& value) {
  return value.dump(2, ' ', false, kReplace) + "\n";
}

std::string yaml_text(const Json& value) {
  if (fits_one_line(value)) return one_line(value) + "\n";
  std::string out;
  write(value, "", out);
  return out;
}

Json findings_json(std::span<const config::Finding> findings) {
  Json list = Json::array();
  for (const config::Finding& finding : findings) {
    list.push_back({{"severity", config::name_of(finding.severity)}, {"sentence", finding.sentence}});
  }
  return list;
}

Json notes_json(std::span<const std::string> notes) {
  std::vector<config::Finding> findings;
  for (const std::string& note : notes) findings.push_back({config::Severity::kNote, note});
  return findings_json(findings);
}

void print(const Settings& settings, const Json& value, const std::string& table) {
  std::string text;
  switch (settings.format()) {
    case OutputFormat::kTable:
      text = config::valid_utf8(table);
      break;
    case OutputFormat::kJson:
      text = json_text(value);
      break;
    case OutputFormat::kYaml:
      text = yaml_text(value);
      break;
  }
  std::fwrite(text.data(), 1, text.size(), stdout);
  std::fflush(stdout);
}

}  // namespace hecaton::services::cli
