#include "planner/model/source_file.hpp"

#include <fstream>
#include <tuple>

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
  SourceFiles kept(snapshot_);
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
  ~ResourcePath() override {
    unsetenv("ROS_PACKAGE_PATH");
    unsetenv("AMENT_PREFIX_PATH");
  }

  std::string resolve(const std::string& uri) const { return resolve(uri, urdf_); }
  std::string resolve(const std::string& uri, const std::string& urdf) const {
    SourceFiles sources;
    return resolve_resource(uri, urdf, packages_, "link 'a'", sources, "--package @=DIR");
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
  EXPECT_TRUE(
      error("package://arm_description/meshes/a.stl")
          .ends_with("'meshes/a.stl'; map it to the folder that has this file (--package arm_description=DIR)"));
}

TEST_F(ResourcePath, UsesRosPackagePathLast) {
  EXPECT_NE(error("package://tools/meshes/t.stl").find("is not found: map package 'tools'"), std::string::npos);
  setenv("ROS_PACKAGE_PATH", ("/nowhere:" + folder_.path("opt/ros/share/")).c_str(), 1);
  EXPECT_TRUE(same(resolve("package://tools/meshes/t.stl"), elsewhere_));
  setenv("ROS_PACKAGE_PATH", (folder_.path("opt/ros/share/tools/") + ":/nowhere").c_str(), 1);
  EXPECT_TRUE(same(resolve("package://tools/meshes/t.stl"), elsewhere_));
}

TEST_F(ResourcePath, UsesPrefixesOfAmentBeforeRosPackagePath) {
  const std::string installed = folder_.write("install/tools/share/tools/meshes/t.stl", "");
  setenv("ROS_PACKAGE_PATH", folder_.path("opt/ros/share").c_str(), 1);
  setenv("AMENT_PREFIX_PATH", ("/nowhere:" + folder_.path("install/tools/")).c_str(), 1);
  EXPECT_TRUE(same(resolve("package://tools/meshes/t.stl"), installed));
}

TEST_F(ResourcePath, NamesTheFolderOfAPackageWithoutTheFile) {
  setenv("AMENT_PREFIX_PATH", ("/nowhere:" + folder_.path("opt/ros")).c_str(), 1);
  EXPECT_EQ(error("package://tools/meshes/T.stl"),
            "link 'a': 'package://tools/meshes/T.stl': package 'tools' is in '" + folder_.path("opt/ros/share/tools") +
                "', where there is no file 'meshes/T.stl'; add it, or map the package to the folder that has this file "
                "(--package tools=DIR)");
  EXPECT_NE(error("package://arm_description/b.stl").find("package 'arm_description' is in '"), std::string::npos);
}

TEST_F(ResourcePath, FindsAPackageByTheNameInItsPackageXml) {
  folder_.write("clone-main/package.xml", "<package>\n<name> renamed </name></package>");
  const std::string mesh = folder_.write("clone-main/meshes/m.stl", "");
  const std::string urdf = folder_.write("clone-main/urdf/r.urdf", "");
  EXPECT_TRUE(same(resolve("package://renamed/meshes/m.stl", urdf), mesh));
  EXPECT_THROW(std::ignore = resolve("package://other/meshes/m.stl", urdf), ModelError);
}

TEST_F(ResourcePath, KeepsThePackageXmlInTheSnapshot) {
  folder_.write("clone-main/package.xml", "<package><name>renamed</name></package>");
  const std::string mesh = folder_.write("clone-main/meshes/m.stl", "");
  const std::string urdf = folder_.write("clone-main/urdf/r.urdf", "");
  SourceFiles sources;
  const std::string found = resolve_resource("package://renamed/meshes/m.stl", urdf, {}, "test", sources);
  std::ignore = sources.open(found);
  sources.keep(folder_.path("snapshot"));
  SourceFiles kept(folder_.path("snapshot"));
  EXPECT_EQ(resolve_resource("package://renamed/meshes/m.stl", urdf, {}, "test", kept), found);
}

TEST_F(ResourcePath, DecodesPercentSignsUnlessAFileHasTheLiteralName) {
  const std::string blank = folder_.write("ws/src/arm_description/meshes/two words.stl", "");
  EXPECT_TRUE(same(resolve("package://arm_description/meshes/two%20words.stl"), blank));
  EXPECT_TRUE(same(resolve("package://arm%5Fdescription/meshes/two words.stl"), blank));
  std::string uri = "file://" + blank;
  uri.replace(uri.find("two words"), 9, "two%20words");
  EXPECT_TRUE(same(resolve(uri), blank));
  const std::string literal = folder_.write("ws/src/arm_description/meshes/two%20words.stl", "");
  EXPECT_TRUE(same(resolve("package://arm_description/meshes/two%20words.stl"), literal));
  EXPECT_NE(error("package://arm_description/100%.stl").find("there is no file '100%.stl'"), std::string::npos);
}

TEST_F(ResourcePath, AcceptsOtherSpellingsOfPaths) {
  EXPECT_TRUE(same(resolve("model://gripper/meshes/g.stl"), in_sibling_));
  EXPECT_TRUE(same(resolve("file://localhost" + elsewhere_), elsewhere_));
  EXPECT_TRUE(same(resolve("file:" + elsewhere_), elsewhere_));
  EXPECT_TRUE(same(resolve("..\\meshes\\a.stl"), in_ancestor_));
}

TEST_F(ResourcePath, LooksBesideALinkAndThenBesideTheFileBehindIt) {
  std::filesystem::create_directories(folder_.path("links"));
  std::filesystem::create_symlink(urdf_, folder_.path("links/arm.urdf"));
  EXPECT_TRUE(same(resolve("../meshes/a.stl", folder_.path("links/arm.urdf")), in_ancestor_));
  EXPECT_TRUE(same(resolve("package://gripper/meshes/g.stl", folder_.path("links/arm.urdf")), in_sibling_));
  const std::string own = folder_.write("links/b.stl", "");
  EXPECT_TRUE(same(resolve("b.stl", folder_.path("links/arm.urdf")), own));
}

TEST_F(ResourcePath, NamesTheOptionThatMapsAPackage) {
  EXPECT_NE(error("package://tools/x.stl").find("to its folder (--package tools=DIR), or keep"), std::string::npos);
}

TEST(Utf8Text, ReplacesLatin1AndRemovesTheByteOrderMark) {
  EXPECT_EQ(utf8_text("\xEF\xBB\xBF"
                      "ab"),
            "ab");
  EXPECT_EQ(utf8_text("Gr\xC3\xB6\xC3\x9F"
                      "er"),
            "Gr\xC3\xB6\xC3\x9F"
            "er");
  EXPECT_EQ(utf8_text("Gr\xF6\xDF"
                      "er"),
            "Gr\xC3\xB6\xC3\x9F"
            "er");
  EXPECT_EQ(utf8_text("\xC0\xAF"), "\xC3\x80\xC2\xAF") << "an overlong form is no UTF-8";
  EXPECT_TRUE(is_utf16("\xFF\xFE<"));
  EXPECT_TRUE(is_utf16(std::string("<\0r\0", 4)));
  EXPECT_FALSE(is_utf16("<robot"));
}

TEST(Utf8Text, IsCutBetweenCharacters) {
  EXPECT_EQ(cut_utf8("a\xC3\xB6"
                     "b",
                     2),
            "a");
  EXPECT_EQ(cut_utf8("a\xC3\xB6"
                     "b",
                     3),
            "a\xC3\xB6");
  EXPECT_EQ(cut_utf8("ab", 5), "ab");
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
  EXPECT_NE(error("http://b.stl").find("has an unknown scheme"), std::string::npos);
  EXPECT_NE(error("package://meshes").find("must name a package and a file"), std::string::npos);
  EXPECT_NE(error("package:///meshes/a.stl").find("must name a package and a file"), std::string::npos);
}

}  // namespace

}  // namespace hecaton::planner
