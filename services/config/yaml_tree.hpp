#pragma once
/// A YAML document as a tree of plain values. yaml_tree.cpp is the only source that includes yaml-cpp.

#include <stdexcept>
#include <string>
#include <vector>

#include "planner/model/source_file.hpp"

namespace hecaton::config {

/// A rejected cell file. what() is one sentence: file, key path, value and what is allowed.
class ConfigError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A value of the document.
struct YamlNode {
  enum class Kind { kEmpty, kScalar, kSequence, kMap };

  Kind kind = Kind::kEmpty;
  std::string text;               ///< of a scalar
  bool quoted = false;            ///< a scalar in quotes is always a text
  std::vector<std::string> keys;  ///< of a map, in the file's order, each once
  std::vector<YamlNode> items;    ///< of a sequence; or a map's values, in the order of `keys`
};

/// Reads a file of one document and expands its aliases. Throws ConfigError with file and line for unreadable files,
/// malformed YAML, keys that appear twice in one map or are not plain words, several documents, files above 4 MiB, more
/// than 24 levels, and more than 200,000 values.
[[nodiscard]] YamlNode read_yaml_file(const std::string& path, planner::SourceFiles& sources);

/// The same for a text. `path` is for messages only.
[[nodiscard]] YamlNode read_yaml_text(const std::string& text, const std::string& path);

}  // namespace hecaton::config
