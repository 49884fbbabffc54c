#pragma once
/// Checks a URDF file element by element before urdfdom parses it. urdfdom accepts files that no planner can use, for
/// example a zero axis, NaN or a loop of joints. Its messages name neither file nor value.

#include <string>

#include "planner/model/source_file.hpp"

namespace hecaton::planner {

/// The URDF at `path` as text for urdfdom, reduced to joints and to links with their collision elements. Missing limits
/// of effort and velocity are 0. Names are unique, references resolve, joints form one tree, numbers are finite, axes
/// not zero, sizes positive, ranges not empty. Throws ModelError.
[[nodiscard]] std::string read_urdf_document(const std::string& path, SourceFiles& sources);

}  // namespace hecaton::planner
