// `hecaton init` and `hecaton robots`.

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "services/cli/cell_draft.hpp"
#include "services/command_line/document.hpp"
#include "services/command_line/terminal.hpp"
#include "services/config/overlaps.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/unit/services/cli/run_line.hpp"

namespace hecaton::services::cli {
namespace {

namespace fs = std::filesystem;

/// A folder for the files of one test.
class InitTest : public testing::Test {
 protected:
  [[nodiscard]] std::string path(const std::string& name) const { return folder_.path(name); }
  [[nodiscard]] std::string content(const std::string& name) const {
    std::ifstream file(path(name));
    return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  }

 private:
  test::TemporaryFolder folder_;
};

TEST_F(InitTest, WritesACellThatChecksDrawsTasksAndSimulates) {
  const std::string cell = path("pair.yaml");
  const Ran init = run_line({"init", "-o", cell, "left=xarm6@-0.45 0 0", "right=xarm6@0.45 0 0 0 0 3.14"});
  ASSERT_EQ(init.code, ExitCode::kDone) << init.err;
  EXPECT_NE(init.out.find("goals: random tool positions"), std::string::npos) << init.out;
  EXPECT_TRUE(init.out.ends_with("next: hecaton check " + cell + "\n")) << init.out;
  EXPECT_TRUE(content("pair.yaml").starts_with("# A cell of Hecaton")) << content("pair.yaml");
  const Ran check = run_line({"check", cell});
  EXPECT_EQ(check.code, ExitCode::kDone) << check.err << check.out;
  EXPECT_NE(check.out.find("next: hecaton simulate " + cell), std::string::npos) << check.out;
  const Ran simulate = run_line({"simulate", cell, "--tasks", "4", "-o", "json"});
  ASSERT_NE(simulate.code, ExitCode::kBadInput) << simulate.err;
  EXPECT_EQ(Json::parse(simulate.out)["contacts"], 0);
}

/// A URDF of a body with two arms of two joints each, in which `waist` is the joint below the body.
std::string two_arms_on(const std::string& waist) {
  std::string text =
      "<robot name=\"twin\"><link name=\"foot\"/><link name=\"body\"><collision><origin xyz=\"0 0 0.2\"/>"
      "<geometry><box size=\"0.1 0.3 0.4\"/></geometry></collision></link>" +
      waist;
  for (const std::string side : {"l", "r"}) {
    const std::string y = side == "l" ? "0.3" : "-0.3";
    const std::string limit = "<limit lower=\"-2\" upper=\"2\" velocity=\"1\" effort=\"1\"/></joint>";
    for (const std::string link : {"1", "2"}) {
      text += "<link name=\"" + side + link +
              "\"><collision><origin xyz=\"0 0 0.15\"/><geometry><box size=\"0.04 0.04 "
              "0.3\"/></geometry></collision></link>";
    }
    text += "<link name=\"" + side + "t\"/><joint name=\"" + side +
            "j1\" type=\"revolute\"><parent link=\"body\"/>"
            "<child link=\"" +
            side + "1\"/><origin xyz=\"0 " + y + " 0.4\"/><axis xyz=\"0 1 0\"/>" + limit + "<joint name=\"" + side +
            "j2\" type=\"revolute\"><parent link=\"" + side + "1\"/><child link=\"" + side +
            "2\"/><origin xyz=\"0 0 0.3\"/><axis xyz=\"0 1 0\"/>" + limit + "<joint name=\"" + side +
            "jt\" type=\"fixed\"><parent link=\"" + side + "2\"/><child link=\"" + side +
            "t\"/><origin xyz=\"0 0 0.3\"/></joint>";
  }
  return text + "</robot>\n";
}

TEST_F(InitTest, TakesTwoArmsOfOneRobotAtOneBase) {
  const std::string cell = path("yumi.yaml");
  const Ran init = run_line({"init", "-o", cell, "left=yumi:left_tool0", "right=yumi:right_tool0"});
  ASSERT_EQ(init.code, ExitCode::kDone) << init.err;
  const Ran check = run_line({"check", cell});
  EXPECT_EQ(check.code, ExitCode::kDone) << check.err << check.out;
}

TEST_F(InitTest, HoldsJointsThatMoveBothArmsOfAUrdf) {
  std::ofstream(path("twin.urdf")) << two_arms_on(
      "<joint name=\"waist\" type=\"revolute\"><parent link=\"foot\"/><child link=\"body\"/><axis xyz=\"0 0 1\"/>"
      "<limit lower=\"-2\" upper=\"2\" velocity=\"1\" effort=\"1\"/></joint>");
  const std::string cell = path("twin.yaml");
  const Ran init =
      run_line({"init", "-o", cell, "left=" + path("twin.urdf") + ":lt", "right=" + path("twin.urdf") + ":rt"});
  ASSERT_EQ(init.code, ExitCode::kDone) << init.err;
  EXPECT_NE(content("twin.yaml").find("chain: ['body', 'lt']"), std::string::npos) << content("twin.yaml");
  EXPECT_EQ(run_line({"check", cell}).code, ExitCode::kDone);
  const Ran simulate = run_line({"simulate", cell, "--tasks", "4", "-o", "json"});
  ASSERT_NE(simulate.code, ExitCode::kBadInput) << simulate.err;
  EXPECT_EQ(Json::parse(simulate.out)["contacts"], 0);
}

TEST_F(InitTest, PutsTheFloorBelowTheLegsOfARobot) {
  std::ofstream(path("legs.urdf")) << two_arms_on(
      "<joint name=\"hips\" type=\"fixed\"><parent link=\"foot\"/><child link=\"body\"/></joint><link name=\"leg\">"
      "<collision><origin xyz=\"0 0 -0.4\"/><geometry><box size=\"0.1 0.1 0.8\"/></geometry></collision></link>"
      "<joint name=\"hip\" type=\"fixed\"><parent link=\"foot\"/><child link=\"leg\"/></joint>");
  const Ran init = run_line({"init", "-o", path("legs.yaml"), "left=" + path("legs.urdf") + ":lt@0 0 0.8",
                             "right=" + path("legs.urdf") + ":rt@0 0 0.8"});
  ASSERT_EQ(init.code, ExitCode::kDone) << init.err;
  const std::string text = content("legs.yaml");
  EXPECT_NE(text.find("- name: floor   # its top is "), std::string::npos) << "no table under bases at 0.8 m\n" << text;
  const auto file = config::load_cell_file(path("legs.yaml"));
  ASSERT_EQ(file.cell.scene.obstacles.size(), 1U);
  EXPECT_NEAR(file.cell.scene.obstacles[0].X_WO.translation().z(), -0.03, 0.05);
}

TEST_F(InitTest, NamesTheToolLinkOfTwoArmsAtOneBase) {
  const Ran same = run_line({"init", "-o", path("cell.yaml"), "a=ur5e", "b=ur5e"});
  EXPECT_EQ(same.code, ExitCode::kBadInput);
  EXPECT_NE(same.err.find("arms a and b are the same robot at the same base: give b another base"), std::string::npos)
      << same.err;
  std::ofstream(path("twin.urdf")) << two_arms_on(
      "<joint name=\"stand\" type=\"fixed\"><parent link=\"foot\"/><child link=\"body\"/></joint>");
  const Ran open = run_line({"init", "-o", path("cell.yaml"), "a=" + path("twin.urdf")});
  EXPECT_EQ(open.code, ExitCode::kBadInput);
  EXPECT_NE(open.err.find("say which link is the tool (" + path("twin.urdf") + ":LINK"), std::string::npos) << open.err;
  const Ran yumi = run_line({"init", "-o", path("cell.yaml"), "a=yumi", "b=yumi"});
  EXPECT_NE(yumi.err.find("as in yumi:left_tool0 and yumi:right_tool0"), std::string::npos) << yumi.err;
}

TEST_F(InitTest, IsProposedByCheckForBothArmsOfOneRobot) {
  const Ran yumi = run_line({"check", "yumi"});
  EXPECT_TRUE(yumi.out.ends_with("next: hecaton init -o cell.yaml left=yumi:left_tool0 right=yumi:right_tool0\n"))
      << yumi.out;
  std::ofstream(path("twin.urdf")) << two_arms_on(
      "<joint name=\"stand\" type=\"fixed\"><parent link=\"foot\"/><child link=\"body\"/></joint>");
  const Ran twin = run_line({"check", path("twin.urdf")});
  EXPECT_EQ(twin.code, ExitCode::kBadInput);
  EXPECT_NE(twin.err.find("for both arms: hecaton init left=" + path("twin.urdf") + ":lt right=" + path("twin.urdf") +
                          ":rt)"),
            std::string::npos)
      << twin.err;
  const Ran one = run_line({"check", path("twin.urdf"), "--tool", "lt"});
  EXPECT_TRUE(one.out.ends_with("next: hecaton init -o cell.yaml left=" + path("twin.urdf") + ":lt@\"0 0 0\"\n"))
      << one.out;
}

/// A robot of two joints whose xacro file has the argument `reach`, and whose meshes are in the package `parts`.
const std::string kXacroArm = R"xml(<robot name="stick" xmlns:xacro="http://wiki.ros.org/xacro">
<xacro:arg name="reach" default="none"/>
<link name="base"/>
<link name="upper"><collision><geometry><mesh filename="package://parts/bar.stl"/></geometry></collision></link>
<link name="lower"><collision><origin xyz="0 0 0.3"/><geometry><box size="0.05 0.05 $(arg reach)"/></geometry></collision></link>
<joint name="j1" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 1 0"/>
<limit lower="-2" upper="2" velocity="1" effort="1"/></joint>
<joint name="j2" type="revolute"><parent link="upper"/><child link="lower"/><origin xyz="0 0 0.6"/><axis xyz="0 1 0"/>
<limit lower="-2" upper="2" velocity="1" effort="1"/></joint>
</robot>)xml";

TEST_F(InitTest, PassesPackagesAndXacroArgumentsToTheCellFile) {
  std::ofstream(path("stick.urdf.xacro")) << kXacroArm;
  fs::create_directory(path("its parts"));
  std::ofstream(path("its parts/bar.stl")) << R"(solid bar
facet normal 0 0 1 outer loop vertex 0 0 0.1 vertex 0.04 0 0.1 vertex 0 0.04 0.1 endloop endfacet
facet normal 0 0 1 outer loop vertex 0 0 0.1 vertex 0.04 0 0.1 vertex 0 0 0.5 endloop endfacet
facet normal 0 0 1 outer loop vertex 0 0 0.1 vertex 0 0.04 0.1 vertex 0 0 0.5 endloop endfacet
facet normal 0 0 1 outer loop vertex 0.04 0 0.1 vertex 0 0.04 0.1 vertex 0 0 0.5 endloop endfacet
endsolid bar
)";
  // Expands what this file needs, with the argument that it is given.
  fs::create_directory(path("bin"));
  std::ofstream(path("bin/xacro")) << "#!/bin/sh\nsed -e '/xacro:arg/d' -e \"s/.(arg reach)/${2#reach:=}/\" \"$1\"\n";
  fs::permissions(path("bin/xacro"), fs::perms::owner_all);
  const std::string paths = std::getenv("PATH");
  setenv("PATH", (path("bin") + ":" + paths).c_str(), 1);
  const std::string cell = path("sticks.yaml");
  const std::string arm = path("stick.urdf.xacro");
  std::vector<std::string> line = {"init",    "-o",       cell, "left=" + arm, "right=" + arm + "@3 0 0",
                                   "--xacro", "reach=0.5"};
  const Ran without = run_line(line);
  line.insert(line.end(), {"--package", "parts=" + path("its parts")});
  const Ran init = run_line(line);
  const Ran check = run_line({"check", cell});
  setenv("PATH", paths.c_str(), 1);
  EXPECT_EQ(without.code, ExitCode::kBadInput);
  EXPECT_NE(without.err.find("map package 'parts' to its folder (--package parts=DIR)"), std::string::npos)
      << without.err;
  ASSERT_EQ(init.code, ExitCode::kDone) << init.err;
  EXPECT_NE(content("sticks.yaml").find("    packages: {'parts': 'its parts'}\n    xacro: {'reach': '0.5'}\n"),
            std::string::npos)
      << content("sticks.yaml");
  EXPECT_EQ(check.code, ExitCode::kDone) << check.err << check.out;
}

/// The lines of `text` from the one that begins with `begin` on.
std::string from_line(const std::string& text, const std::string& begin) {
  const std::size_t at = text.find("\n" + begin);
  return at == std::string::npos ? "no line '" + begin + "' in: " + text : text.substr(at + 1);
}

TEST_F(InitTest, NextCommandsFindTheCellAndCanBeCopied) {
  const std::string cell = path("my cell.yaml");
  const auto steps_with = [&](const std::string& more) {
    std::ofstream(cell) << "name: small\narms:\n  - {name: north, urdf: '" << HECATON_SOURCE_DIR
                        << "/deploy/cells/urdf/puma560.urdf', base: {xyz: [0, 0, 0]}, "
                           "poses: {home: [0, -1.9, 2.6, 0, 0.6, 0], ready: [-0.3, -1.25, 3.5, 0, 0.89, 0]}"
                        << more;
    return from_line(run_line({"check", cell}).out, "then: ");
  };
  const std::string quoted = "'" + cell + "'";
  const std::string live = "then: hecaton up " + quoted + "\nand in a second terminal:\n";
  const std::string by_file = " --cell " + quoted + "\n";
  EXPECT_EQ(steps_with("}\n"), live + "  hecaton goal north --named ready --wait\n");
  EXPECT_EQ(steps_with("}\nnetwork: {domain: 7}\n"), live + "  hecaton goal north --named ready --wait" + by_file);
  EXPECT_EQ(steps_with(", host: b}\nhosts: {a: 10.0.0.1, b: 10.0.0.2}\nworld: {host: a}\nsupervision: {host: a}\n"),
            "then: hecaton up " + quoted + "\nor on each host, with its name: hecaton agent " + quoted +
                " --host a\nand in a second terminal:\n  hecaton goal north --named ready --wait\n");
  EXPECT_EQ(steps_with(", device: {type: universal_robots, robot_ip: 192.168.0.10}}\nnetwork: {domain: 7}\n"),
            live + "  hecaton device north on" + by_file + "  hecaton resume north" + by_file +
                "  # the real arm north moves now: stand at its emergency stop\n" +
                "  hecaton goal north --named ready --wait" + by_file);
}

TEST_F(InitTest, LeavesAnExistingFileAsItIs) {
  std::ofstream(path("cell.yaml")) << "mine\n";
  const Ran ran = run_line({"init", "-o", path("cell.yaml"), "left=ur5e"});
  EXPECT_EQ(ran.code, ExitCode::kBadInput);
  EXPECT_NE(ran.err.find("exists already"), std::string::npos) << ran.err;
  EXPECT_EQ(content("cell.yaml"), "mine\n");
}

TEST_F(InitTest, FindsPosesForAUrdfWithoutAny) {
  fs::copy_file(std::string(HECATON_SOURCE_DIR) + "/deploy/cells/urdf/puma560.urdf", path("arm.urdf"));
  const Ran ran = run_line({"init", "-o", path("cell.yaml"), "left=" + path("arm.urdf")});
  ASSERT_EQ(ran.code, ExitCode::kDone) << ran.err;
  const std::string text = content("cell.yaml");
  EXPECT_NE(text.find("urdf: 'arm.urdf'"), std::string::npos) << "relative to the cell file: " << text;
  EXPECT_NE(text.find("home: ["), std::string::npos) << text;
  EXPECT_NE(text.find("pose_sequence: [home, ready]"), std::string::npos) << "one arm has no conflicts: " << text;
  EXPECT_EQ(run_line({"check", path("cell.yaml")}).code, ExitCode::kDone);
}

TEST_F(InitTest, FindsOtherPosesWhereHomesMeet) {
  // Both UR5e reach 0.49 m along their −x at home, into the other arm.
  const Ran ran = run_line({"init", "-o", path("cell.yaml"), "left=ur5e@-0.3 0 0 0 0 3.14159", "right=ur5e@0.3 0 0"});
  ASSERT_EQ(ran.code, ExitCode::kDone) << ran.err;
  EXPECT_NE(content("cell.yaml").find("poses:"), std::string::npos) << content("cell.yaml");
  EXPECT_EQ(run_line({"check", path("cell.yaml")}).code, ExitCode::kDone);
}

std::string puma() {
  return std::string(HECATON_SOURCE_DIR) + "/deploy/cells/urdf/puma560.urdf";
}

TEST_F(InitTest, DrawsRandomGoalsForUrdfsWithoutPoses) {
  const std::string cell = path("pair.yaml");
  const Ran ran =
      run_line({"init", "-o", cell, "left=" + puma() + "@-0.6 0 0.8", "right=" + puma() + "@0.6 0 0.8 0 0 3.14"});
  ASSERT_EQ(ran.code, ExitCode::kDone) << ran.err;
  const std::string text = content("pair.yaml");
  EXPECT_NE(text.find("centre: ["), std::string::npos) << text;
  EXPECT_EQ(text.find("-0,"), std::string::npos) << text;
  EXPECT_EQ(text.find("-0]"), std::string::npos) << text;
  EXPECT_NE(text.find("name: table   # its top is "), std::string::npos) << "bases at 0.8 m: " << text;
  EXPECT_NE(text.find("ready: ["), std::string::npos) << text;
  const Json report = Json::parse(run_line({"simulate", cell, "--tasks", "6", "-o", "json"}).out);
  EXPECT_EQ(report["not_drawn"], 0);
  EXPECT_EQ(report["contacts"], 0);
}

/// The numbers of the first `name: [...]` of `text`.
std::vector<double> numbers_of(const std::string& text, const std::string& name) {
  const std::size_t at = text.find(name + ": [");
  if (at == std::string::npos) return {};
  std::istringstream list(text.substr(at + name.size() + 3));
  std::vector<double> numbers;
  char separator = ',';
  for (double number = 0.0; separator == ',' && list >> number; list >> separator) numbers.push_back(number);
  return numbers;
}

TEST_F(InitTest, ChoosesAPoseReadyThatMovesMoreThanTheWrist) {
  const std::string cell = path("pair.yaml");
  const Ran ran =
      run_line({"init", "-o", cell, "left=" + puma() + "@-0.6 0 0.8", "right=" + puma() + "@0.6 0 0.8 0 0 3.14"});
  ASSERT_EQ(ran.code, ExitCode::kDone) << ran.err;
  const std::string text = content("pair.yaml");
  const std::vector<double> home = numbers_of(text, "home");
  const std::vector<double> ready = numbers_of(text, "ready");
  ASSERT_EQ(home.size(), 6U) << text;
  ASSERT_EQ(ready.size(), 6U) << text;
  EXPECT_FALSE(std::equal(home.begin(), home.begin() + 3, ready.begin())) << text;
}

TEST_F(InitTest, CheckOfAXacroFilePassesItsArgumentsToInit) {
  fs::create_directory(path("bin"));
  std::ofstream(path("bin/xacro")) << "#!/bin/sh\ncat '" << puma() << "'\n";
  fs::permissions(path("bin/xacro"), fs::perms::owner_all);
  std::ofstream(path("arm.xacro")) << "<robot name=\"arm\"><link name=\"base\"/><xacro:arm/></robot>\n";
  const std::string before = std::getenv("PATH");
  setenv("PATH", (path("bin") + ":" + before).c_str(), 1);
  const Ran plain = run_line({"check", path("arm.xacro")});
  const Ran ran = run_line({"check", path("arm.xacro"), "--xacro", "side=left"});
  setenv("PATH", before.c_str(), 1);
  ASSERT_EQ(ran.code, ExitCode::kDone) << ran.err;
  EXPECT_TRUE(plain.out.ends_with("next: hecaton init -o cell.yaml left=" + path("arm.xacro") + "@\"0 0 0\"\n"))
      << plain.out;
  EXPECT_TRUE(
      ran.out.ends_with("next: hecaton init -o cell.yaml left=" + path("arm.xacro") + "@\"0 0 0\" --xacro side=left\n"))
      << ran.out;
}

TEST_F(InitTest, WritesWhatTheUrdfLacks) {
  std::ofstream(path("arm.urdf")) << R"(<robot name="arm"><link name="base"/><link name="a">
      <collision><origin xyz="0 0 0.2"/><geometry><cylinder radius="0.05" length="0.4"/></geometry></collision></link>
    <link name="b"/>
    <joint name="j" type="revolute"><parent link="base"/><child link="a"/><axis xyz="0 1 0"/>
      <limit lower="-1" upper="1" effort="1" velocity="0"/></joint>
    <joint name="k" type="revolute"><parent link="a"/><child link="b"/><origin xyz="0 0 0.4"/><axis xyz="0 1 0"/>
      <limit lower="-1" upper="1" effort="1" velocity="2"/></joint></robot>)";
  const Ran ran = run_line({"init", "-o", path("cell.yaml"), "left=" + path("arm.urdf")});
  ASSERT_EQ(ran.code, ExitCode::kDone) << ran.err;
  EXPECT_NE(content("cell.yaml").find("allow_bare_links: true   # some moving link"), std::string::npos);
  EXPECT_NE(content("cell.yaml").find("limits: {velocity: 1}"), std::string::npos);
  EXPECT_EQ(run_line({"check", path("cell.yaml")}).code, ExitCode::kDone);
}

TEST_F(InitTest, RejectsARobotWithoutAnyGeometry) {
  std::ofstream(path("arm.urdf")) << R"(<robot name="arm"><link name="base"/><link name="a"/>
    <joint name="j" type="revolute"><parent link="base"/><child link="a"/><axis xyz="0 1 0"/>
      <limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>)";
  const Ran ran = run_line({"init", "-o", path("cell.yaml"), "left=" + path("arm.urdf")});
  EXPECT_EQ(ran.code, ExitCode::kBadInput);
  EXPECT_NE(ran.err.find("add <collision> elements"), std::string::npos) << ran.err;
}

TEST_F(InitTest, RejectsWhatIsNoArm) {
  struct Case {
    const char* word;
    const char* piece;
  };
  for (const Case& one : {Case{"ur5e", "must be NAME=ROBOT@"}, Case{"left=ur5", "did you mean 'ur5e'?"},
                          Case{"left=ur5e@1 2", "must be NAME=ROBOT@"}, Case{"=ur5e", "must be NAME=ROBOT@"},
                          Case{"left=ur5e@1 2 x", "must be NAME=ROBOT@"}, Case{"left=ur5e@1e9 0 0", "within ±100"}}) {
    const Ran ran = run_line({"init", "-o", path("cell.yaml"), one.word});
    EXPECT_EQ(ran.code, ExitCode::kBadInput) << one.word;
    EXPECT_NE(ran.err.find(one.piece), std::string::npos) << one.word << ": " << ran.err;
    EXPECT_FALSE(fs::exists(path("cell.yaml")));
  }
}

TEST_F(InitTest, TakesColonsAndAtSignsInThePathOfAFile) {
  const std::string folder = path("v1:2");
  fs::create_directory(folder);
  for (const std::string name : {"arm.urdf", "arm@home.urdf"}) {
    const std::string file = folder + "/" + name;
    std::ofstream(file) << "<robot/>";
    for (const std::string base : {"", "@1 0 0"}) {
      for (const std::string link : {"", "tool0"}) {
        const std::string word = "a=" + file + (link.empty() ? "" : ":" + link) + base;
        const DraftArm arm = parse_draft_arm(word);
        EXPECT_EQ(arm.robot, file) << word;
        EXPECT_EQ(arm.tool_link, link) << word;
        EXPECT_EQ(arm.base[0], base.empty() ? 0.0 : 1.0) << word;
      }
    }
  }
  EXPECT_EQ(parse_draft_arm("a=" + folder + "/none.urdf@1 0 0").robot, folder + "/none.urdf") << "for the message";
  EXPECT_EQ(parse_draft_arm("a=yumi:left_tool0@1 0 0").tool_link, "left_tool0");
}

// Next to the security distance an arm comes to rest slowly, or not at all.
TEST_F(InitTest, ChoosesPosesInWhichAnArmComesToRest) {
  constexpr double kMargin = 0.015;
  for (const std::string robot : {"ur10e", "ur5e", "ur3e", "iiwa14", "panda", "gen3", "xarm7"}) {
    DraftArm arm;
    arm.name = "a";
    arm.robot = std::string(HECATON_SOURCE_DIR) + "/deploy/robots/" + robot + ".urdf";  // without the poses of its YAML
    const config::CellFile file = draft_cell({arm}, path(robot + ".yaml")).file;
    const planner::PlannedArm& planned = file.cell.arms[0];
    const planner::CellGeometry geometry({planned.arm}, 0);
    const double kept = planned.parameters.damper.self_security_distance;
    for (const char* name : {"home", "ready"}) {
      const auto bodies = config::place_arm({}, geometry, 0, planned.arm.named.at(name));
      EXPECT_FALSE(config::nearest_self_pair(bodies, geometry, kept + kMargin, planner::kRestShare).found)
          << robot << " at " << name;
    }
  }
}

TEST_F(InitTest, RejectsTwoArmsOfOneName) {
  const Ran ran = run_line({"init", "-o", path("cell.yaml"), "a=ur5e@0 0 0", "a=ur5e@2 0 0"});
  EXPECT_EQ(ran.code, ExitCode::kBadInput);
  EXPECT_NE(ran.err.find("two arms have the name a"), std::string::npos) << ran.err;
}

TEST(AskForArms, AsksAgainAfterAnAnswerThatIsNoArm) {
  std::istringstream in("my arm\nleft\nur5\nur5e\n-0.5 0 0\nleft\nright\npanda\n0.5 0\n\n\n");
  std::ostringstream out;
  const std::vector<std::string> arms = ask_for_arms(in, out);
  ASSERT_EQ(arms.size(), 2U) << out.str();
  EXPECT_EQ(parse_draft_arm(arms[0]).robot, "ur5e");
  EXPECT_EQ(parse_draft_arm(arms[0]).base[0], -0.5);
  EXPECT_EQ(parse_draft_arm(arms[1]).robot, "panda");
  EXPECT_EQ(parse_draft_arm(arms[1]).base[0], 1.0) << "the proposal for a second arm";
  for (const char* piece :
       {"'my arm' must be a name", "did you mean 'ur5e'?", "another arm has the name left", "must be NAME=ROBOT@"}) {
    EXPECT_NE(out.str().find(piece), std::string::npos) << piece << ": " << out.str();
  }
}

TEST(AskForArms, ProposesTheSameBaseForTheOtherArmOfARobot) {
  std::istringstream in("left\nyumi:left_tool0\n0.1 0 0\nright\nyumi:right_tool\nyumi:right_tool0\n\n\n");
  std::ostringstream out;
  const std::vector<std::string> arms = ask_for_arms(in, out);
  ASSERT_EQ(arms.size(), 2U) << out.str();
  EXPECT_EQ(parse_draft_arm(arms[1]).base, parse_draft_arm(arms[0]).base);
  EXPECT_NE(out.str().find("tool link 'right_tool' must be one of its links"), std::string::npos) << out.str();
}

TEST(AskForArms, FailsWhenTheInputEnds) {
  std::istringstream in("left\n");
  std::ostringstream out;
  EXPECT_THROW(static_cast<void>(ask_for_arms(in, out)), Failure);
}

TEST(Robots, ListsFiguresSourcesAndWhatIsApproximate) {
  const Json robots = Json::parse(run_line({"robots", "-o", "json"}).out)["robots"];
  ASSERT_GE(robots.size(), 26U);
  for (const Json& robot : robots) {
    EXPECT_GT(robot["reach_m"].get<double>(), 0.0) << robot["name"];
    EXPECT_GT(robot["payload_kg"].get<double>(), 0.0) << robot["name"];
    EXPECT_FALSE(robot["sources"].empty()) << robot["name"];
    EXPECT_FALSE(robot["approximate"].empty()) << robot["name"];
    for (const Json& tool : robot["tools"]) {
      EXPECT_EQ(tool["joints"].size(), tool["poses"]["home"].size()) << robot["name"];
    }
  }
  const std::string table = run_line({"robots"}).out;
  EXPECT_NE(table.find("ABB YuMi"), std::string::npos) << table;
  EXPECT_NE(table.find("7 + 7"), std::string::npos) << table;
  EXPECT_EQ(table.find("data sheet"), std::string::npos) << "sources are for one robot: " << table;
  std::istringstream lines(table);
  for (std::string line; std::getline(lines, line);) EXPECT_LE(display_width(line), 120U) << line;
  const std::string one = run_line({"robots", "yumi"}).out;
  EXPECT_NE(one.find("source: "), std::string::npos) << one;
  EXPECT_NE(one.find("approximate: "), std::string::npos) << one;
}

// As that of the robot's meshes beside the user.
TEST(Robots, AreMeantAlthoughAFolderHasTheName) {
  const test::TemporaryFolder folder;
  std::filesystem::create_directory(std::filesystem::path(folder.path()) / "ur5e");
  const auto before = std::filesystem::current_path();
  std::filesystem::current_path(folder.path());
  const Ran check = run_line({"check", "ur5e"});
  const Ran draft = run_line({"init", "-o", "cell.yaml", "left=ur5e"});
  std::filesystem::current_path(before);
  EXPECT_EQ(check.code, ExitCode::kDone) << check.err;
  EXPECT_EQ(draft.code, ExitCode::kDone) << draft.err;
}

TEST(Robots, AreNotMeantWhenAFileHasTheName) {
  const test::TemporaryFolder folder;
  std::filesystem::copy_file(std::string(HECATON_SOURCE_DIR) + "/deploy/cells/urdf/puma560.urdf", folder.path("ur5e"));
  const auto before = std::filesystem::current_path();
  std::filesystem::current_path(folder.path());
  const Ran check = run_line({"check", "ur5e", "-o", "json"});
  std::filesystem::current_path(before);
  ASSERT_EQ(check.code, ExitCode::kDone) << check.err;
  const Json robot = Json::parse(check.out);
  EXPECT_EQ(robot["name"], "puma560");
  EXPECT_TRUE(std::any_of(robot["findings"].begin(), robot["findings"].end(), [](const Json& finding) {
    return finding["sentence"].get<std::string>().starts_with("the file 'ur5e' is read, not the robot of this name");
  })) << robot["findings"];
}

TEST(Robots, StandInForAUrdfInCommands) {
  const Ran check = run_line({"check", "ur5e"});
  EXPECT_EQ(check.code, ExitCode::kDone) << check.err;
  EXPECT_NE(check.out.find("robot ur5e: 6 joints"), std::string::npos) << check.out;
  const Ran plan = run_line({"plan", "xarm6", "--from", "home", "--to", "ready", "-o", "json"});
  EXPECT_EQ(plan.code, ExitCode::kDone) << plan.err;
  const Ran unknown = run_line({"check", "ur5"});
  EXPECT_EQ(unknown.code, ExitCode::kBadInput);
  EXPECT_NE(unknown.err.find("did you mean 'ur5e'?"), std::string::npos) << unknown.err;
}

}  // namespace
}  // namespace hecaton::services::cli
