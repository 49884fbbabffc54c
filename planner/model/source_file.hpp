#pragma once
/// The files that a cell and its robots are read from: cell file, URDF, SRDF, meshes. Readers open each file through a
/// `SourceFiles`, so that the agent can keep the files with which a cell came up, and restarted services read those.

#include <filesystem>
#include <map>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>

namespace hecaton::planner {

/// A rejected URDF, SRDF or mesh. what() is one sentence: file, element, value and what is allowed.
class ModelError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Opens files in place or in a snapshot, and records which of them were read. Not thread-safe.
class SourceFiles {
 public:
  /// Without `snapshot`, opens files in place. With it, opens the copies in this folder, stored under their absolute
  /// paths; a file without a copy does not exist.
  explicit SourceFiles(std::filesystem::path snapshot = {}) : snapshot_(std::move(snapshot)) {}

  /// The path under which `file` is found. Does not count as reading it.
  [[nodiscard]] std::filesystem::path place(const std::filesystem::path& file) const;
  /// The path to read `file` from; adds it to read().
  [[nodiscard]] std::filesystem::path open(const std::filesystem::path& file);

  /// Absolute paths of the files that were opened.
  [[nodiscard]] const std::set<std::string>& read() const { return read_; }
  /// Copies these files into a folder that serves as a `snapshot`. Throws std::filesystem::filesystem_error.
  void keep(const std::filesystem::path& folder) const;

 private:
  std::filesystem::path snapshot_;
  std::set<std::string> read_;
};

/// Resolves `uri` as used in the URDF at `urdf_path`:
/// - package://P/x: packages.at(P)/x; else below the URDF's nearest ancestor folder that is named P or holds a folder
/// P;
///   else below a folder of ROS_PACKAGE_PATH likewise,
/// - file:///x and absolute paths,
/// - a path without scheme: relative to the URDF's folder.
/// The file exists in `sources`. Throws ModelError that begins with `where`.
[[nodiscard]] std::string resolve_resource(const std::string& uri, const std::string& urdf_path,
                                           const std::map<std::string, std::string>& packages, const std::string& where,
                                           const SourceFiles& sources);

}  // namespace hecaton::planner
