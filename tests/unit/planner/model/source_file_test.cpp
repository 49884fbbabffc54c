#include "planner/model/source_file.hpp"

#include <fstream>

#include <gtest/gtest.h>
#include <unistd.h>


namespace hecaton::planner {
namespace {

namespace fs = std::filesystem;

class SourceFile : public testing::Test {
 protected:
  SourceFile() {
    fs::create_directories(folder_ / "robot");
    write("first");
  }
  ~SourceFile() override { fs::remove_all(folder_); }
  void write(const std::string& text) const { std::ofstream(file_) << text; }
  [[nodiscard]] std::string read(SourceFiles& sources) const {
    std::ifstream file(sources.open(file_));
    std::string text;
    std::getline(file, text);
    return text;
  }

  fs::path folder_ = testing::TempDir() + "hecaton_sources_" + std::to_string(getpid());
  fs::path file_ = folder_ / "robot/arm.urdf";
  fs::path snapshot_ = folder_ / "snapshot";
};

TEST_F(SourceFile, IsReadInPlaceWithoutSnapshot) {
  SourceFiles sources;
  EXPECT_TRUE(sources.read().empty());
  EXPECT_EQ(read(sources), "first");
  EXPECT_EQ(sources.read(), std::set<std::string>{file_.string()});
}

TEST_F(SourceFile, IsReadFromItsCopyInTheSnapshot) {
  SourceFiles sources;
  EXPECT_EQ(read(sources), "first");
  sources.keep(snapshot_);
  write("second");
  SourceFiles kept(snapshot_);
  EXPECT_EQ(read(kept), "first");
  EXPECT_EQ(read(sources), "second");
  fs::remove(file_);
  EXPECT_EQ(read(kept), "first");
  EXPECT_EQ(resolve_resource("arm.urdf", file_.string(), {}, "test", kept), file_.string()) << "names stay";
}

TEST_F(SourceFile, DoesNotExistWhenTheSnapshotLacksIt) {
  const SourceFiles kept(snapshot_);
  EXPECT_FALSE(fs::exists(kept.place(file_)));
  EXPECT_THROW(static_cast<void>(resolve_resource("arm.urdf", file_.string(), {}, "test", kept)), ModelError);
}

}  // namespace
}  // namespace hecaton::planner
