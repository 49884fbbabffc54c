#pragma once
/// Loading XML files (URDF, SRDF) and checking attributes. All functions throw ModelError.

#include <string>
#include <vector>

#include "planner/model/source_file.hpp"

namespace tinyxml2 {
class XMLDocument;
class XMLElement;
}  // namespace tinyxml2

namespace hecaton::planner {

/// Parses the file into `document`, as UTF-8: utf8_text(). Throws when it is missing, unreadable, larger than 64 MB,
/// UTF-16 or not well-formed. `kind` names it in the sentence: "URDF", "SRDF".
void load_xml(const std::string& path, const std::string& kind, tinyxml2::XMLDocument& document, SourceFiles& sources);

/// The same for a text that stands for the file.
void parse_xml(const std::string& text, const std::string& path, const std::string& kind,
               tinyxml2::XMLDocument& document);

/// The longest text in quotes of a sentence: a value of a file, and what another library or program says [bytes].
inline constexpr std::size_t kLongestValue = 120;
inline constexpr std::size_t kLongestReason = 600;
/// 'text' in quotes for a sentence, without control characters, cut after `longest` bytes.
[[nodiscard]] std::string in_quotes(const std::string& text, std::size_t longest = kLongestValue);

/// The attribute's text; throws when it is missing or empty.
[[nodiscard]] std::string text_attribute(const tinyxml2::XMLElement& element, const char* name,
                                         const std::string& where);

/// The attribute's `count` numbers, separated by blanks; throws when it is missing, has another count, or holds
/// anything but finite numbers.
[[nodiscard]] std::vector<double> number_attribute(const tinyxml2::XMLElement& element, const char* name, int count,
                                                   const std::string& where);

}  // namespace hecaton::planner
