#include "services/agent/run_folder.hpp"

#include <cstdlib>
#include <stdexcept>
#include <system_error>

namespace hecaton::services {

RunFolder::RunFolder(const std::string& cell) {
  const auto parent = std::filesystem::temp_directory_path();
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
