#pragma once
/// Checks a URDF file element by element before urdfdom parses it. urdfdom accepts files that no planner can use, for
/// example a zero axis, NaN or a loop of joints. Its messages name neither file nor value.

#include <map>
#include <string>
#include <vector>

#include "planner/model/dynamics.hpp"
#include "planner/model/source_file.hpp"
#include "planner/model/xacro.hpp"

namespace hecaton::planner {

/// A URDF that was checked.
struct UrdfDocument {
  std::string text;                ///< for urdfdom: joints, and links with their collision elements
  std::vector<std::string> notes;  ///< what was left out or replaced, a sentence each
  /// By name: joints without usable axis or limits, or that follow none that exists, and a sentence for each that
  /// begins with the file. In `text` they are fixed.
  std::map<std::string, std::string> faulty_joints;
  std::vector<BodyMass> masses;  ///< of links with an <inertial> of numbers and a mass above 0
};

/// Reads the URDF at `path`, or expands it with xacro if a part that the planner needs is xacro. In the text, names are
/// unique, references resolve, and joints form one tree. A joint that follows others leads to one that follows none.
/// Numbers are finite, axes not zero, sizes positive and ranges not reversed. Missing limits of effort and velocity
/// are 0; a follower without a range of its own has equal limits. Floating and planar joints are fixed.
/// Throws ModelError.
[[nodiscard]] UrdfDocument read_urdf_document(const std::string& path, SourceFiles& sources,
                                              const XacroOptions& xacro = {});

}  // namespace hecaton::planner
