#pragma once
/// A URDF file checked element by element, before urdfdom sees it: urdfdom accepts much that no planner can use (a zero
/// axis, NaN, a joint loop beside the tree), and its messages name neither the file nor the value.

#include <string>

#include "planner/model/source_file.hpp"

namespace hecaton::planner {

/// The URDF at `path` as text for urdfdom, reduced to what a planner needs: links with their collision elements, and
/// joints; limits without effort or velocity have them written as 0. Every name is unique and every reference resolves;
/// the joints form one tree; numbers are finite, axes not zero, sizes positive, ranges not empty.
/// Throws ModelError.
[[nodiscard]] std::string read_urdf_document(const std::string& path, SourceFiles& sources);

}  // namespace hecaton::planner
