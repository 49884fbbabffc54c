#pragma once
/// The files that a cell and its robots are read from: cell file, URDF, SRDF, meshes. All of them are opened through
/// here, so that a running cell can keep what it came up with: whoever edits them meanwhile edits the next cell.
///
/// One set of files for the whole process, because libraries open some of them by name.

#include <filesystem>
#include <set>
#include <string>

namespace hecaton::planner {

/// From now on files are read from the copy in this folder, under their absolute paths; what is not there does not
/// exist. Empty: from where they are.
void read_sources_from(const std::filesystem::path& snapshot);

/// Where to look for the file. To look is not to read.
[[nodiscard]] std::filesystem::path source_place(const std::filesystem::path& file);
/// Where to read it; it is remembered as one of sources_read().
[[nodiscard]] std::filesystem::path open_source(const std::filesystem::path& file);

/// Absolute paths of all that were read since the process began.
[[nodiscard]] std::set<std::string> sources_read();
/// Copies all that were read into the folder. Throws std::filesystem::filesystem_error.
void keep_sources(const std::filesystem::path& snapshot);

}  // namespace hecaton::planner
