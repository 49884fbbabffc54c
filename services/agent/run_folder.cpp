#include "services/agent/run_folder.hpp"

#include <cstdlib>
#include <stdexcept>
#include <system_error>

#include <unistd.h>

namespace hecaton::services {
namespace {

constexpr const char* kSharedMemory = "/dev/shm";

std::filesystem::path parent_of_runs() {
  const bool chosen = std::getenv("TMPDIR") != nullptr;
  if (!chosen && ::access(kSharedMemory, W_OK | X_OK) == 0) return kSharedMemory;
  return std::filesystem::temp_directory_path();
}

}  // namespace

RunFolder::RunFolder(const std::string& cell) {
  const auto parent = parent_of_runs();
  std::string name = (parent / ("hecaton-" + cell + "-XXXXXX")).string();
  if (mkdtemp(name.data()) == nullptr) {
    throw std::runtime_error("no folder for the run can be made in " + parent.string() +
                             ": set TMPDIR to one that may");
  }
  path_ = name;
}

RunFolder::~RunFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

}  // namespace hecaton::services
