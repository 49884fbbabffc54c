#pragma once
/// A folder for files of a moment.

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <system_error>

namespace hecaton::services {

/// The folder lives as long as the object.
class TemporaryFolder {
 public:
  /// Below TMPDIR, or /tmp. Throws std::runtime_error with a sentence.
  TemporaryFolder() {
    std::error_code error;
    std::string name = (std::filesystem::temp_directory_path(error) / "hecaton-XXXXXX").string();
    if (error || mkdtemp(name.data()) == nullptr) {
      throw std::runtime_error(
          "no temporary folder can be made: " + (error ? error.message() : std::string(std::strerror(errno))) +
          "; name another place by TMPDIR");
    }
    path_ = name;
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace hecaton::services
