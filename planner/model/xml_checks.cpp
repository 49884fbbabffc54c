#include "planner/model/xml_checks.hpp"

#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>
#include <string_view>

#include <tinyxml2.h>

#include "planner/model/source_file.hpp"

namespace hecaton::planner {
namespace {

/// Unlike strtod independent of the locale.
std::optional<double> number(std::string_view word) {
  if (word.starts_with('+')) word.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  const bool whole = error == std::errc() && end == word.data() + word.size();
  if (!whole || !std::isfinite(value)) return std::nullopt;
  return value;
}

}  // namespace

void load_xml(const std::string& path, const std::string& kind, tinyxml2::XMLDocument& document, SourceFiles& sources) {
  std::error_code error;
  const std::filesystem::path place = sources.open(path);
  if (!std::filesystem::exists(place, error)) throw ModelError(path + ": this " + kind + " file does not exist");
  if (!std::filesystem::is_regular_file(place, error))
    throw ModelError(path + ": a " + kind + " must be a regular file");
  constexpr std::uintmax_t kLargest = 64U << 20U;
  const std::uintmax_t size = std::filesystem::file_size(place, error);
  if (!error && size > kLargest) throw ModelError(path + ": this " + kind + " file is larger than 64 MB");
  std::ifstream file(place, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  if (!file) throw ModelError(path + ": this " + kind + " file cannot be read");
  const std::string bytes = text.str();
  if (is_utf16(bytes)) {
    throw ModelError(path + ": this " + kind + " is UTF-16; it must be UTF-8 (iconv -f UTF-16 -t UTF-8 IN > OUT)");
  }
  if (bytes.empty()) throw ModelError(path + ": this " + kind + " file is empty");
  if (is_lfs_pointer(bytes)) throw ModelError(path + ": this " + kind + " file " + kLfsPointer);
  parse_xml(utf8_text(bytes), path, kind, document);
}

void parse_xml(const std::string& text, const std::string& path, const std::string& kind,
               tinyxml2::XMLDocument& document) {
  if (document.Parse(text.data(), text.size()) == tinyxml2::XML_SUCCESS) return;
  throw ModelError(path + ":" + std::to_string(document.ErrorLineNum()) + ": malformed XML (" +
                   tinyxml2::XMLDocument::ErrorIDToName(document.ErrorID()) + "); a " + kind + " must be well-formed");
}

std::string in_quotes(const std::string& text, std::size_t longest) {
  std::string result = "'";
  for (const char c : cut_utf8(text, longest)) result += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
  return result + (text.size() > longest ? "…'" : "'");
}

std::string text_attribute(const tinyxml2::XMLElement& element, const char* name, const std::string& where) {
  const char* text = element.Attribute(name);
  if (text == nullptr || *text == '\0') {
    throw ModelError(where + ": <" + std::string(element.Name()) + "> must have the attribute '" + name + "'");
  }
  return text;
}

std::vector<double> number_attribute(const tinyxml2::XMLElement& element, const char* name, int count,
                                     const std::string& where) {
  const std::string text = text_attribute(element, name, where);
  std::vector<double> numbers;
  std::istringstream words(text);
  bool good = true;
  for (std::string word; words >> word;) {
    const auto value = number(word);
    good = good && value.has_value();
    numbers.push_back(value.value_or(0.0));
  }
  if (good && static_cast<int>(numbers.size()) == count) return numbers;
  throw ModelError(where + ": " + element.Name() + " " + name + " = " + in_quotes(text) + " must be " +
                   (count == 1 ? "a finite number" : std::to_string(count) + " finite numbers"));
}

}  // namespace hecaton::planner
