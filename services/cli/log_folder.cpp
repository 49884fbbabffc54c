#include "services/cli/log_folder.hpp"

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <system_error>

#include "services/command_line/failure.hpp"

namespace hecaton::services::cli {

LogFolder::LogFolder(const std::string& wanted, const std::string& cell) : path_(wanted), temporary_(wanted.empty()) {
  std::error_code error;
  if (!temporary_) {
    std::filesystem::create_directories(path_, error);
    path_ = std::filesystem::absolute(path_);
    if (error) throw Failure(ExitCode::kBadInput, "log folder '" + path_ + "' cannot be made: " + error.message());
    return;
  }
  const char* chosen = std::getenv("TMPDIR");
  const std::filesystem::path parent = chosen == nullptr || *chosen == '\0' ? "/tmp" : chosen;
  std::string name = parent / ("hecaton-" + cell + "-XXXXXX");
  if (mkdtemp(name.data()) == nullptr) {
    throw Failure(ExitCode::kBadInput, "no folder for the logs can be made in " + parent.string() + ": " +
                                           std::strerror(errno) + "; TMPDIR or --log-dir may name another place");
  }
  path_ = name;
}

LogFolder::~LogFolder() {
  std::error_code ignored;
  if (discard_) std::filesystem::remove_all(path_, ignored);
}

}  // namespace hecaton::services::cli
