#pragma once
/// Where the files are that a URDF names: package://, file:// and relative paths.

#include <map>
#include <string>

#include "planner/model/source_file.hpp"

namespace hecaton::planner {

/// Resolves `uri` as used in the URDF at `urdf_path`:
/// - package://P/x: packages.at(P)/x; else below the URDF's nearest ancestor folder that is named P or holds a folder
/// P;
///   else below a folder of ROS_PACKAGE_PATH likewise
/// - file:///x, and paths that are absolute already
/// - anything without scheme: relative to the URDF's folder
/// The result exists in `sources`. Throws ModelError that begins with `where`.
[[nodiscard]] std::string resolve_resource(const std::string& uri, const std::string& urdf_path,
                                           const std::map<std::string, std::string>& packages, const std::string& where,
                                           const SourceFiles& sources);

}  // namespace hecaton::planner
