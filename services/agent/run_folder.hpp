#pragma once
/// A folder for what a cell must remember while it is up; gone afterwards. In memory (/dev/shm) unless TMPDIR names
/// another: drivers keep theirs in a mapped file every period, and a page that is being written to a disk would make
/// them wait.

#include <filesystem>
#include <string>

namespace hecaton::services {

class RunFolder {
 public:
  /// Throws std::runtime_error with a sentence when it cannot be made.
  explicit RunFolder(const std::string& cell);
  ~RunFolder();
  RunFolder(const RunFolder&) = delete;
  RunFolder& operator=(const RunFolder&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace hecaton::services
