#pragma once
/// Expands xacro files, from which most public URDFs are made, with the program `xacro` of ROS.

#include <chrono>
#include <map>
#include <optional>
#include <string>

#include "planner/model/source_file.hpp"

namespace hecaton::planner {

/// Arguments of a xacro file: `name:=value`.
using XacroArguments = std::map<std::string, std::string>;

/// What the user gives for a xacro file.
struct XacroOptions {
  XacroArguments arguments;
  std::map<std::string, std::string> packages;  ///< name → folder, for $(find NAME)
  std::string arguments_option;  ///< how messages name the option for arguments: "--xacro NAME=VALUE"; empty: none
  std::string packages_option;   ///< the same for packages, with @ for the name: "--package @=DIR"
  std::chrono::seconds time_limit{60};  ///< of each run of the program, which is killed then
};

/// What `xacro` writes for the file `path` of `sources`. Waits until the program ends, up to the time limit. It finds
/// packages where resolve_resource() does. Empty when the PATH has no such program. Throws ModelError, which begins
/// with `path`, when the program fails or takes too long; the sentence ends with the program's reason, or with what to
/// do about a missing package. Throws it also for a copy in a snapshot, which may come from elsewhere: xacro evaluates
/// Python and reads any file.
[[nodiscard]] std::optional<std::string> expand_xacro(const std::string& path, SourceFiles& sources,
                                                      const XacroOptions& options);

}  // namespace hecaton::planner
