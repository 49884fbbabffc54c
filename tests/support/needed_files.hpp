#pragma once
/// Files that a test needs and a machine may lack: a browser, the npm packages of the page.

#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>

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

/// Leaves a test, or a void function of one, when one of the files is missing: skipped, or failed where nothing may be.
#define HECATON_NEED_FILES(...)                                                                                    \
  if (const std::string hecaton_missing = ::hecaton::test::first_missing(__VA_ARGS__); !hecaton_missing.empty()) { \
    ASSERT_TRUE(::hecaton::test::may_skip()) << hecaton_missing << " is missing";                                  \
    GTEST_SKIP() << hecaton_missing << " is missing";                                                              \
  }                                                                                                                \
  static_cast<void>(0)
