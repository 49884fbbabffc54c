#pragma once
/// Files that a test needs and a machine may lack: a browser, the npm packages of the page.

#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

namespace hecaton::test {

/// The first of `files` that does not exist; empty: all exist.
[[nodiscard]] inline std::string first_missing(const std::vector<std::string>& files) {
  for (const std::string& file : files) {
    if (!std::filesystem::exists(file)) return file;
  }
  return {};
}

/// A test may be skipped for a missing file. `./run test` installs them all, and sets HECATON_SKIP_NOTHING.
[[nodiscard]] inline bool may_skip() {
  return std::getenv("HECATON_SKIP_NOTHING") == nullptr;
}

}  // namespace hecaton::test
