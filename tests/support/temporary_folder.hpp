#pragma once
/// A folder for the files of one test.

#include <filesystem>
#include <fstream>
#include <string>

#include "services/runtime/temporary_folder.hpp"

namespace hecaton::test {

/// A folder of its own for every test, removed afterwards.
class TemporaryFolder : public services::TemporaryFolder {
 public:
  using services::TemporaryFolder::path;
  [[nodiscard]] std::string path(const std::string& name) const { return (path() / name).string(); }

  std::string write(const std::string& name, const std::string& text) const {
    const std::filesystem::path file = path() / name;
    std::filesystem::create_directories(file.parent_path());
    std::ofstream(file, std::ios::binary) << text;
    return file.string();
  }
};

}  // namespace hecaton::test
