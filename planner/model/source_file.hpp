#pragma once
/// The files that a cell and its robots are read from: cell file, URDF, SRDF, meshes. Readers open each file through a
/// `SourceFiles`. The agent keeps the files with which a cell came up, and restarted services read those.

#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <string_view>
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

  /// The snapshot gets `text` instead of a copy of `file`: a program made it from the file, such as xacro.
  void keep_as(const std::filesystem::path& file, std::string text);

  /// Absolute paths of the files that were opened.
  [[nodiscard]] const std::set<std::string>& read() const { return read_; }
  /// Copies these files into a folder that serves as a `snapshot`. Throws std::filesystem::filesystem_error.
  void keep(const std::filesystem::path& folder) const;

 private:
  std::filesystem::path snapshot_;
  std::set<std::string> read_;
  std::map<std::string, std::string> texts_;  ///< by absolute path: keep_as()
};

/// True for bytes that begin with the byte-order mark of UTF-16 or UTF-32, or with an ASCII character in UTF-16.
[[nodiscard]] bool is_utf16(const std::string& bytes);

/// What to say after the name of a file that is_lfs_pointer().
inline constexpr const char* kLfsPointer = "is a pointer of Git LFS, not the file itself; fetch it with 'git lfs pull'";

/// True for bytes of a pointer that Git LFS leaves in place of a large file that was not fetched.
[[nodiscard]] bool is_lfs_pointer(std::string_view bytes);

/// A file's bytes as UTF-8: without byte-order mark; bytes that are no UTF-8 are read as Latin-1.
[[nodiscard]] std::string utf8_text(std::string bytes);

/// The bytes of the UTF-8 character that begins at `i` < text.size(); 0: none does.
[[nodiscard]] std::size_t utf8_length(std::string_view text, std::size_t i);

/// The characters of a UTF-8 text that fit into `most_bytes`.
[[nodiscard]] std::string cut_utf8(const std::string& text, std::size_t most_bytes);

/// Resolves `uri` as used in the URDF at `urdf_path`:
/// - package://P/x and model://P/x: the first of these that exists.
///   1. packages.at(P)/x.
///   2. Below the nearest ancestor folder of the URDF that is P: by its name, by its package.xml, or as a folder in it.
///   3. Below share/P of a prefix of AMENT_PREFIX_PATH.
///   4. Below a folder of ROS_PACKAGE_PATH, by the rules of 2.
/// - file:///x and absolute paths.
/// - A path without scheme is relative to the URDF's folder.
/// If the URDF is a symbolic link, the folder of its target comes after the folder of the link. When no file has the
/// literal name, %XX in `uri` stands for a byte, and a backslash for a slash.
/// The file exists in `sources`. `remedy` says in the sentence of a missing package how the user maps it; with @ for
/// the package's name. Throws ModelError that begins with `where`.
[[nodiscard]] std::string resolve_resource(const std::string& uri, const std::string& urdf_path,
                                           const std::map<std::string, std::string>& packages, const std::string& where,
                                           SourceFiles& sources, const std::string& remedy = "");

/// The folder of package P, by the same rules; empty: there is none.
[[nodiscard]] std::optional<std::filesystem::path> package_folder(const std::string& package,
                                                                  const std::string& urdf_path,
                                                                  const std::map<std::string, std::string>& packages,
                                                                  SourceFiles& sources);

}  // namespace hecaton::planner
