#pragma once
/// The files that a cell and its robots are read from: cell file, URDF, SRDF, meshes. Readers open each of them through
/// a `SourceFiles`, so that the agent can keep the files with which a cell came up, and restarted services read those.

#include <filesystem>
#include <set>
#include <string>
#include <utility>

namespace hecaton::planner {

/// Where files are read from, and which of them were read. Not thread-safe.
class SourceFiles {
 public:
  /// Reads files where they are; or, with a `snapshot`, the copies in this folder, under their absolute paths: what is
  /// not there does not exist.
  explicit SourceFiles(std::filesystem::path snapshot = {}) : snapshot_(std::move(snapshot)) {}

  /// The path under which `file` is found. Does not count as reading it.
  [[nodiscard]] std::filesystem::path place(const std::filesystem::path& file) const;
  /// The path to read `file` from; adds it to read().
  [[nodiscard]] std::filesystem::path open(const std::filesystem::path& file);

  /// Absolute paths of the files that were opened.
  [[nodiscard]] const std::set<std::string>& read() const { return read_; }
  /// Copies these files into the folder, for the `snapshot` of others. Throws std::filesystem::filesystem_error.
  void keep(const std::filesystem::path& folder) const;

 private:
  std::filesystem::path snapshot_;
  std::set<std::string> read_;
};

}  // namespace hecaton::planner
