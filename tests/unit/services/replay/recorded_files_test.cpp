/// The cell, the robots and the meshes of a recording.

#include "services/replay/recorded_files.hpp"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "services/replay/replay.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/unit/services/replay/tape.hpp"

namespace hecaton::services::replay {
namespace {

using namespace std::chrono_literals;
using test::TemporaryFolder;

TEST(RecordedFiles, ComeFromTheRecordingAlone) {
  const TemporaryFolder folder;
  const std::string recording = folder.path("run.mcap");
  {
    // The files of the cell are gone when the recording is opened.
    const TemporaryFolder cell;
    cell.write("arm.urdf", R"(<robot name="r"><link name="base"/>
      <link name="tip"><visual><geometry><mesh filename="gone.stl"/></geometry></visual>
        <collision><geometry><mesh filename="tip.stl"/></geometry></collision></link>
      <joint name="j" type="revolute"><parent link="base"/><child link="tip"/><axis xyz="0 0 1"/>
        <limit lower="-1" upper="1" velocity="1" effort="1"/></joint></robot>)");
    cell.write(
        "tip.stl",
        "solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 0.1 0 0\nvertex 0 0.1 0\nendloop\nendfacet\n"
        "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 0.1 0 0\nvertex 0 0 0.1\nendloop\nendfacet\nendsolid "
        "s\n");
    const std::string path =
        cell.write("cell.yaml", "name: one\narms:\n  - {name: arm1, urdf: arm.urdf, allow_bare_links: true}\n");
    const config::CellFile file = config::load_cell_file(path);
    Tape tape({.path = recording}, file);
    tape.write(arm_state("arm1", 1), 0s);
    tape.close();
  }
  const RecordedFiles files = read_recorded_files({recording});
  EXPECT_EQ(files.cell.cell.name, "one");
  ASSERT_EQ(files.cell.cell.arms.size(), 1U);
  EXPECT_EQ(files.cell.cell.arms[0].arm.model->geometry.size(), 1U);
  // The mesh of the collision shape is there. The page draws the shape where the visual mesh is missing.
  EXPECT_NE(files.drawings.arms()[0].note.find("gone.stl"), std::string::npos);
}

TEST(RecordedFiles, HaveTheMeshesWithWhichArmsAreDrawn) {
  const TemporaryFolder folder;
  const std::string recording = folder.path("run.mcap");
  const std::string stl =
      "solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 0.1 0 0\nvertex 0 0.1 0\nendloop\nendfacet\n"
      "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 0.1 0 0\nvertex 0 0 0.1\nendloop\nendfacet\nendsolid s\n";
  {
    // A package in a folder that the cell file names, and one that was found by the environment of the recorder.
    const TemporaryFolder cell;
    for (const char* package : {"some/where/meshes", "share/other/meshes"}) {
      std::filesystem::create_directories(cell.path(package));
    }
    cell.write("some/where/meshes/base.dae", "<image>wood.png</image>");
    cell.write("some/where/meshes/wood.png", "wood");
    cell.write("some/where/meshes/unused.png", "unused");
    cell.write("share/other/meshes/tip.stl", stl);
    cell.write("arm.urdf", R"(<robot name="r">
      <link name="base"><visual><geometry><mesh filename="package://named/meshes/base.dae"/></geometry></visual></link>
      <link name="tip"><visual><geometry><mesh filename="package://other/meshes/tip.stl"/></geometry></visual>
        <collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision></link>
      <joint name="j" type="revolute"><parent link="base"/><child link="tip"/><axis xyz="0 0 1"/>
        <limit lower="-1" upper="1" velocity="1" effort="1"/></joint></robot>)");
    const std::string path = cell.write(
        "cell.yaml",
        "name: one\narms:\n  - {name: arm1, urdf: arm.urdf, packages: {named: some/where}, allow_bare_links: true}\n");
    setenv("AMENT_PREFIX_PATH", cell.path().c_str(), 1);
    const config::CellFile file = config::load_cell_file(path);
    Tape tape({.path = recording}, file);
    tape.write(arm_state("arm1", 1), 0s);
    tape.close();
    // All meshes of an arm, or none.
    const auto names = [&](std::uintmax_t most) {
      std::string all;
      for (const recorder::AttachedFile& attached : recorder::attachments_of(file, most)) all += attached.name + "\n";
      return all;
    };
    EXPECT_NE(names(stl.size() + 27).find("base.dae"), std::string::npos);
    EXPECT_EQ(names(stl.size() + 26).find("meshes"), std::string::npos) << names(stl.size() + 26);
    EXPECT_EQ(names(recorder::kMostMeshes).find("unused.png"), std::string::npos);
    unsetenv("AMENT_PREFIX_PATH");
  }
  const RecordedFiles files = read_recorded_files({recording});
  const view::ArmDrawing& drawing = files.drawings.arms()[0];
  EXPECT_TRUE(drawing.has_visuals);
  EXPECT_EQ(drawing.note, "");
  const auto content = [&](const std::string& url) {
    const auto file = files.drawings.mesh(url);
    if (!file) return std::string("none");
    std::ifstream stream(*file, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(stream), {});
  };
  EXPECT_EQ(content("/meshes/0/base.dae"), "<image>wood.png</image>");
  EXPECT_EQ(content("/meshes/0/wood.png"), "wood");
  EXPECT_EQ(content("/meshes/1/tip.stl"), stl);
  EXPECT_NE(drawing.urdf.find("/meshes/1/tip.stl"), std::string::npos);
}

/// A recording of one arm, of any origin.
std::string recording_of_one_arm(const TemporaryFolder& folder, const std::string& urdf,
                                 const std::vector<recorder::AttachedFile>& more = {}) {
  static int number = 0;
  const std::string path = folder.path("foreign" + std::to_string(++number) + ".mcap");
  std::vector<recorder::AttachedFile> files = {
      {"/there/cell.yaml", "application/yaml",
       "name: one\narms:\n  - {name: arm1, urdf: arm.urdf, allow_bare_links: true}\n"},
      {"/there/arm.urdf", "application/xml", urdf}};
  files.insert(files.end(), more.begin(), more.end());
  recorder::Recording({.path = path}, files, 1).close();
  return path;
}

std::string arm_with(const std::string& visuals) {
  return R"(<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro"><link name="base"/><link name="tip">)" +
         visuals + R"(<collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision></link>
         <joint name="j" type="revolute"><parent link="base"/><child link="tip"/><axis xyz="0 0 1"/>
         <limit lower="-1" upper="1" velocity="1" effort="1"/></joint></robot>)";
}

std::string visual(const std::string& mesh) {
  return R"(<visual><geometry><mesh filename=")" + mesh + R"("/></geometry></visual>)";
}

// A recording may come from elsewhere, and name any file of this machine.
TEST(RecordedFiles, NameNoMeshesOfThisMachine) {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder.path("secrets/meshes"));
  const std::string secret = folder.write("secrets/meshes/secret.stl", "secret");
  setenv("AMENT_PREFIX_PATH", folder.path().c_str(), 1);
  setenv("ROS_PACKAGE_PATH", folder.path().c_str(), 1);
  for (const std::string& uri :
       {secret, "file://" + secret, "../../../../../.." + secret, std::string("package://secrets/meshes/secret.stl")}) {
    const RecordedFiles files = read_recorded_files({recording_of_one_arm(
        folder, arm_with(visual("known.stl") + visual(uri)), {{"/there/known.stl", "model/stl", "known"}})});
    const view::ArmDrawing& drawing = files.drawings.arms()[0];
    EXPECT_FALSE(drawing.has_visuals) << uri;
    EXPECT_EQ(drawing.note, "/there/arm.urdf: the recording has no mesh '" + uri + "'");
    EXPECT_EQ(files.note, "drawn by collision shapes: arm1; " + drawing.note);
    EXPECT_EQ(files.drawings.mesh("/meshes/1/secret.stl"), std::nullopt);
    EXPECT_EQ(files.drawings.mesh_named(uri), std::nullopt);
    EXPECT_EQ(files.cell.cell.arms[0].arm.model->geometry.size(), 1U) << "what the planner measures with is drawn";
  }
  unsetenv("AMENT_PREFIX_PATH");
  unsetenv("ROS_PACKAGE_PATH");
  const RecordedFiles whole = read_recorded_files(
      {recording_of_one_arm(folder, arm_with(visual("known.stl")), {{"/there/known.stl", "model/stl", "known"}})});
  EXPECT_TRUE(whole.drawings.arms()[0].has_visuals);
  EXPECT_EQ(whole.note, "");
}

TEST(RecordedFiles, RunNoXacro) {
  const TemporaryFolder folder;
  const std::string ran = folder.path("ran");
  std::filesystem::create_directories(folder.path("bin"));
  const std::string program = folder.write("bin/xacro", "#!/bin/sh\ntouch " + ran + "\ncat \"$1\"\n");
  std::filesystem::permissions(program, std::filesystem::perms::owner_all);
  const std::string path = std::getenv("PATH");
  setenv("PATH", (folder.path("bin") + ":" + path).c_str(), 1);
  const std::string colour = recording_of_one_arm(
      folder, arm_with("<visual><xacro:grey/><geometry><box size=\"1 1 1\"/></geometry></visual>"));
  EXPECT_EQ(error_of([&] { static_cast<void>(read_recorded_files({colour})); }), "accepted");
  const std::string needed =
      recording_of_one_arm(folder, R"(<robot name="r" xmlns:xacro="x"><link name="base"/><xacro:arm/></robot>)");
  const std::string refusal = error_of([&] { static_cast<void>(read_recorded_files({needed})); });
  EXPECT_NE(refusal.find("/there/arm.urdf: the copy of this file is xacro"), std::string::npos) << refusal;
  setenv("PATH", path.c_str(), 1);
  EXPECT_FALSE(std::filesystem::exists(ran));
}

TEST(RecordedFiles, AreRefusedWithASentence) {
  const TemporaryFolder folder;
  const std::string none = folder.path("none.mcap");
  recorder::Recording({.path = none}, {}, 1).close();
  EXPECT_EQ(error_of([&] { static_cast<void>(read_recorded_files({none})); }),
            none + " has no cell file attached; name a file that `hecaton record` has written");
  const std::string evil = folder.path("evil.mcap");
  recorder::Recording({.path = evil},
                      {{"/cell.yaml", "application/yaml", "name: 7"},
                       {"/../../../../../.." + folder.path("out.txt"), "text/plain", "outside"},
                       {"relative.txt", "text/plain", "outside"}},
                      1)
      .close();
  EXPECT_NE(error_of([&] { static_cast<void>(read_recorded_files({evil})); }).find("/cell.yaml: "), std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(folder.path("out.txt")));
  EXPECT_FALSE(std::filesystem::exists("relative.txt"));
  Tape tape({.path = folder.path("run.mcap")});
  const std::string run = tape.close().front();
  EXPECT_EQ(error_of([&] {
              static_cast<void>(read_recorded_files({run, evil}));
            }),
            evil + " has another cell file than " + run + "; name the files of one recording");
  EXPECT_EQ(error_of([&] { static_cast<void>(index_recording({run}, cell_file())); }),
            run + " has no messages of a cell that can be read; name another recording");
}

}  // namespace
}  // namespace hecaton::services::replay
