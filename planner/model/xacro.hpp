#pragma once
/// Expands xacro files, from which most public URDFs are made, with the program `xacro` of ROS.

#include <map>
#include <optional>
#include <string>

namespace hecaton::planner {

/// Arguments of a xacro file: `name:=value`.
using XacroArguments = std::map<std::string, std::string>;

/// What `xacro` writes for the file `path`, which it reads at `place`. Waits until the program ends. Empty when the
/// PATH has no such program. Throws ModelError, which begins with `path`, when the program fails; the sentence ends
/// with the program's last line.
[[nodiscard]] std::optional<std::string> expand_xacro(const std::string& path, const std::string& place,
                                                      const XacroArguments& arguments);

}  // namespace hecaton::planner
