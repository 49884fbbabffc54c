#pragma once
/// A YAML document as a tree of plain values. yaml_tree.cpp is the only file of the project that includes yaml-cpp.

#include <string>
#include <vector>

#include "planner/model/source_file.hpp"

namespace hecaton::config {

struct YamlNode {
  enum class Kind { kEmpty, kScalar, kSequence, kMap };

  Kind kind = Kind::kEmpty;
  int line = 0;                   ///< 1 is the first
  std::string text;               ///< of a scalar
  bool quoted = false;            ///< a scalar in quotes is a text, whatever it looks like
  std::vector<std::string> keys;  ///< of a map, in the file's order, each once
  std::vector<YamlNode> items;    ///< of a sequence; or a map's values, in the order of `keys`
};

/// Reads the only document of the file. Aliases are expanded. Throws ConfigError with file and line for unreadable
/// files, malformed YAML, keys that appear twice in one map, keys that are no plain words, several documents, and for
/// files that are too large, too deep or expand too far.
[[nodiscard]] YamlNode read_yaml_file(const std::string& path, planner::SourceFiles& sources);

/// The same for a text; `path` is only named in messages.
[[nodiscard]] YamlNode read_yaml_text(const std::string& text, const std::string& path);

}  // namespace hecaton::config
