#include "planner/model/source_file.hpp"

#include <fstream>

#include <gtest/gtest.h>
#include <unistd.h>

#include "tests/unit/planner/model/support.hpp"

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

TEST_F(SourceFile, IsReadFromTheSnapshot) {
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

TEST_F(SourceFile, DoesNotExistWithoutCopyInTheSnapshot) {
  const SourceFiles kept(snapshot_);
  EXPECT_FALSE(fs::exists(kept.place(file_)));
  EXPECT_THROW(static_cast<void>(resolve_resource("arm.urdf", file_.string(), {}, "test", kept)), ModelError);
}

class ResourcePath : public testing::Test {
 protected:
  ResourcePath() {
    urdf_ = folder_.write("ws/src/arm_description/urdf/arm.urdf", "");
    in_ancestor_ = folder_.write("ws/src/arm_description/meshes/a.stl", "");
    in_sibling_ = folder_.write("ws/src/gripper/meshes/g.stl", "");
    elsewhere_ = folder_.write("opt/ros/share/tools/meshes/t.stl", "");
    beside_ = folder_.write("ws/src/arm_description/urdf/b.stl", "");
  }
  ~ResourcePath() override { unsetenv("ROS_PACKAGE_PATH"); }

  std::string resolve(const std::string& uri) const {
    return resolve_resource(uri, urdf_, packages_, "link 'a'", SourceFiles());
  }
  std::string error(const std::string& uri) const {
    try {
      return "resolved to " + resolve(uri);
    } catch (const ModelError& caught) {
      return caught.what();
    }
  }
  static bool same(const std::string& a, const std::string& b) { return std::filesystem::equivalent(a, b); }

  test::TemporaryFolder folder_;
  std::string urdf_, in_ancestor_, in_sibling_, elsewhere_, beside_;
  std::map<std::string, std::string> packages_;
};

TEST_F(ResourcePath, FindsPackagesInAncestorsAndBesideThem) {
  EXPECT_TRUE(same(resolve("package://arm_description/meshes/a.stl"), in_ancestor_));
  EXPECT_TRUE(same(resolve("package://gripper/meshes/g.stl"), in_sibling_));
}

TEST_F(ResourcePath, PrefersThePackageMap) {
  packages_["arm_description"] = folder_.path("opt/ros/share/tools");
  EXPECT_TRUE(same(resolve("package://arm_description/meshes/t.stl"), elsewhere_));
  EXPECT_NE(error("package://arm_description/meshes/a.stl").find("is mapped to"), std::string::npos);
}

TEST_F(ResourcePath, UsesRosPackagePathLast) {
  EXPECT_NE(error("package://tools/meshes/t.stl").find("is not found: map package 'tools'"), std::string::npos);
  setenv("ROS_PACKAGE_PATH", ("/nowhere:" + folder_.path("opt/ros/share/")).c_str(), 1);
  EXPECT_TRUE(same(resolve("package://tools/meshes/t.stl"), elsewhere_));
  setenv("ROS_PACKAGE_PATH", (folder_.path("opt/ros/share/tools/") + ":/nowhere").c_str(), 1);
  EXPECT_TRUE(same(resolve("package://tools/meshes/t.stl"), elsewhere_));
}

TEST_F(ResourcePath, ResolvesAbsoluteAndRelativePaths) {
  EXPECT_TRUE(same(resolve("file://" + elsewhere_), elsewhere_));
  EXPECT_TRUE(same(resolve(elsewhere_), elsewhere_));
  EXPECT_TRUE(same(resolve("b.stl"), beside_));
  EXPECT_TRUE(same(resolve("../meshes/a.stl"), in_ancestor_));
}

TEST_F(ResourcePath, RefusesMissingFilesAndOtherSchemes) {
  EXPECT_NE(error("missing.stl").find("link 'a': mesh file '"), std::string::npos);
  EXPECT_NE(error("file://b.stl").find("must be absolute"), std::string::npos);
  EXPECT_NE(error("model://b.stl").find("has an unknown scheme"), std::string::npos);
  EXPECT_NE(error("package://meshes").find("must name a package and a file"), std::string::npos);
  EXPECT_NE(error("package:///meshes/a.stl").find("must name a package and a file"), std::string::npos);
}

}  // namespace

}  // namespace hecaton::planner
