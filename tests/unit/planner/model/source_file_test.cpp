#include "planner/model/source_file.hpp"

#include <fstream>

#include <gtest/gtest.h>
#include <unistd.h>

#include "planner/model/model_error.hpp"
#include "planner/model/resource_path.hpp"

namespace hecaton::planner {
namespace {

namespace fs = std::filesystem;

class SourceFile : public testing::Test {
 protected:
  SourceFile() {
    fs::create_directories(folder_ / "robot");
    write("first");
  }
  ~SourceFile() override {
    read_sources_from({});
    fs::remove_all(folder_);
  }
  void write(const std::string& text) const { std::ofstream(file_) << text; }
  [[nodiscard]] std::string read() const {
    std::ifstream file(open_source(file_));
    std::string text;
    std::getline(file, text);
    return text;
  }

  fs::path folder_ = testing::TempDir() + "hecaton_sources_" + std::to_string(getpid());
  fs::path file_ = folder_ / "robot/arm.urdf";
  fs::path snapshot_ = folder_ / "snapshot";
};

TEST_F(SourceFile, IsReadWhereItIs) {
  EXPECT_EQ(read(), "first");
  EXPECT_TRUE(sources_read().contains(file_.string()));
}

TEST_F(SourceFile, AndFromItsCopyOnceItIsKept) {
  EXPECT_EQ(read(), "first");
  keep_sources(snapshot_);
  write("second");
  read_sources_from(snapshot_);
  EXPECT_EQ(read(), "first");
  fs::remove(file_);
  EXPECT_EQ(read(), "first");
  EXPECT_EQ(resolve_resource("arm.urdf", file_.string(), {}, "test"), file_.string()) << "names stay as they were";
}

TEST_F(SourceFile, WhatWasNotReadThenDoesNotExist) {
  read_sources_from(snapshot_);
  EXPECT_FALSE(fs::exists(source_place(file_)));
  EXPECT_THROW(static_cast<void>(resolve_resource("arm.urdf", file_.string(), {}, "test")), ModelError);
}

}  // namespace
}  // namespace hecaton::planner
