#include "services/cli/log_folder.hpp"

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <system_error>

#include "services/cli/failure.hpp"

namespace hecaton::services::cli {

LogFolder::LogFolder(const std::string& wanted, const std::string& cell) : path_(wanted), temporary_(wanted.empty()) {
  std::error_code error;
  if (!temporary_) {
    std::filesystem::create_directories(path_, error);
    path_ = std::filesystem::absolute(path_);
    if (error) throw Failure(ExitCode::kBadInput, "log folder '" + path_ + "' cannot be made: " + error.message());
    return;
  }
  std::string name = std::filesystem::temp_directory_path(error) / ("hecaton-" + cell + "-XXXXXX");
  if (error || mkdtemp(name.data()) == nullptr) {
    throw Failure(ExitCode::kBadInput, "no temporary folder can be made for the logs: " +
                                           (error ? error.message() : std::string(std::strerror(errno))));
  }
  path_ = name;
}

LogFolder::~LogFolder() {
  std::error_code ignored;
  if (discard_) std::filesystem::remove_all(path_, ignored);
}

}  // namespace hecaton::services::cli
