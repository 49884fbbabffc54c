// Files in which what must not be forgotten is mapped.
#include "services/runtime/mapped_file.hpp"

#include <csignal>
#include <cstring>
#include <filesystem>
#include <stdexcept>

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

namespace hecaton::services {
namespace {

class MappedFileTest : public ::testing::Test {
 protected:
  ~MappedFileTest() override { std::filesystem::remove(path_); }

  const std::string path_ =
      (std::filesystem::temp_directory_path() / ("hecaton_mapped_" + std::to_string(getpid()))).string();
};

TEST_F(MappedFileTest, BeginsEmptyAndKeepsWhatWasWritten) {
  {
    const MappedFile file(path_, 100, "it");
    const std::string zeros(100, '\0');
    EXPECT_EQ(std::memcmp(file.data(), zeros.data(), zeros.size()), 0);
    std::memcpy(file.data(), "kept", 4);
  }
  const MappedFile again(path_, 200, "it");
  EXPECT_EQ(std::memcmp(again.data(), "kept", 4), 0);
}

TEST_F(MappedFileTest, WithoutAPathThereIsNone) {
  EXPECT_EQ(MappedFile("", 100, "it").data(), nullptr);
}

/// No file of this process may become longer than `bytes`, as on a disk that is full.
class LimitOfFiles {
 public:
  explicit LimitOfFiles(rlim_t bytes) : on_excess_(std::signal(SIGXFSZ, SIG_IGN)) {
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit{bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~LimitOfFiles() {
    setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, on_excess_);
  }

 private:
  void (*on_excess_)(int);
  rlimit before_{};
};

TEST_F(MappedFileTest, WhatHasNoPlaceIsSaidAtOnceInASentence) {
  const LimitOfFiles limit(50);
  try {
    const MappedFile file(path_, 100, "what must not be forgotten");
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_EQ(error.what(), path_ + ": what must not be forgotten cannot be kept there: File too large");
  }
}

}  // namespace
}  // namespace hecaton::services
