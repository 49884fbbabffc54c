// Robots by name in cell files.

#include "services/config/robot_catalogue.hpp"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "services/config/cell_file.hpp"
#include "services/config/yaml_tree.hpp"
#include "tests/support/temporary_folder.hpp"

namespace hecaton::config {
namespace {

namespace fs = std::filesystem;

const std::string kAnywhere = "/tmp/cell.yaml";  // only for messages: nothing is relative to it

CellFile cell_of(const std::string& arms) {
  return parse_cell_file("name: test\n" + arms, kAnywhere);
}

std::string error_of(const std::string& arms) {
  try {
    static_cast<void>(cell_of(arms));
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "";
}

TEST(RobotCatalogue, GivesAnArmItsRobotPosesAndAccelerations) {
  const CellFile file = cell_of("arms:\n  - {name: left, robot: panda}\n");
  const planner::Arm& arm = file.cell.arms.front().arm;
  EXPECT_EQ(arm.model->name, "panda");
  EXPECT_EQ(arm.model->links[arm.model->tool_link].name, "tool0");
  EXPECT_TRUE(arm.named.contains("home") && arm.named.contains("ready"));
  EXPECT_EQ(arm.limits.acceleration[1], 7.5);  // of the interface specification
}

TEST(RobotCatalogue, CellFileWinsOverTheCatalogue) {
  const CellFile file = cell_of(
      "arms:\n  - name: left\n    robot: panda\n    limits: {acceleration: 3}\n"
      "    poses: {home: [0, 0, 0, -1.5, 0, 1.5, 0]}\n");
  const planner::Arm& arm = file.cell.arms.front().arm;
  EXPECT_EQ(arm.limits.acceleration[1], 3.0);
  EXPECT_EQ(arm.home()[3], -1.5);
  EXPECT_TRUE(arm.named.contains("ready")) << "other poses of the catalogue stay";
}

// The second joint of its poses home and ready is at -1.5708 and -2.1.
TEST(RobotCatalogue, NotesPosesOutsideNarrowerLimits) {
  const auto notes_of = [](const std::string& more) {
    std::string all;
    for (const std::string& note : cell_of("arms:\n  - {name: left, robot: ur5e" + more + "}\n").notes)
      all += note + "\n";
    return all;
  };
  const std::string narrow = ", limits: {lower: [-6, -1, -2.8, -6, -6, -6]}";
  const std::string both = notes_of(narrow);
  EXPECT_NE(both.find("arms[0].limits: pose ready of the robot is outside of them and left out; widen them, or give "
                      "poses.ready"),
            std::string::npos)
      << both;
  EXPECT_NE(both.find("poses.home of arm left is missing: compact postures are chosen"), std::string::npos) << both;
  const std::string given = notes_of(narrow + ", poses: {home: [0, -1, 1, -1.5708, -1.5708, 0]}");
  EXPECT_EQ(given.find("pose home"), std::string::npos) << given;
  EXPECT_EQ(notes_of("").find("left out"), std::string::npos);
}

TEST(RobotCatalogue, ArmWinsOverDefaults) {
  const CellFile file = cell_of(
      "defaults: {robot: panda}\narms:\n  - {name: left}\n  - {name: right, robot: ur5e, base: {xyz: [2, 0, 0]}}\n");
  EXPECT_EQ(file.cell.arms[0].arm.model->name, "panda");
  EXPECT_EQ(file.cell.arms[1].arm.model->name, "ur5e");
}

TEST(RobotCatalogue, ArmsOfOneRobotShareItsModel) {
  const CellFile file =
      cell_of("defaults: {robot: xarm6}\narms:\n  - {name: left}\n  - {name: right, base: {xyz: [2, 0, 0]}}\n");
  EXPECT_EQ(file.cell.arms[0].arm.model, file.cell.arms[1].arm.model);
}

// The rail is held: the lists of the catalogue have it first.
TEST(RobotCatalogue, ChainAboveTheRailKeepsPosesAndAccelerations) {
  const CellFile file = cell_of("arms:\n  - {name: left, robot: ur10e_rail, chain: [carriage, tool0]}\n");
  const planner::Arm& arm = file.cell.arms.front().arm;
  ASSERT_EQ(arm.model->joints(), 6);
  EXPECT_EQ(arm.limits.acceleration[0], 7.0) << "of the first joint of the arm, the rail has 2 m/s²";
  EXPECT_EQ(arm.limits.acceleration[2], 10.0);
  ASSERT_TRUE(arm.model->named.contains("ready"));
  EXPECT_EQ(arm.named.at("ready")[1], -2.1);
}

TEST(RobotCatalogue, ShorterChainOfARobotWithTwoArmsKeepsItsAccelerations) {
  const CellFile file = cell_of("arms:\n  - {name: right, robot: yumi, tool_link: right_link_5}\n");
  const planner::Arm& arm = file.cell.arms.front().arm;
  EXPECT_EQ(arm.limits.acceleration[0], 15.0);
  ASSERT_TRUE(arm.model->named.contains("home"));
  EXPECT_EQ(arm.named.at("home")[2], -2.3562) << "of the right arm";
}

TEST(RobotCatalogue, ToolLinkChoosesTheArmOfARobotWithTwo) {
  const CellFile file = cell_of("arms:\n  - {name: right, robot: yumi, tool_link: right_tool0}\n");
  const planner::RobotModel& model = *file.cell.arms.front().arm.model;
  EXPECT_EQ(model.joint_names.front(), "right_joint_1");
  EXPECT_LT(model.named.at("home")[2], 0.0) << "the right arm's own home";
}

TEST(RobotCatalogue, RejectsAnUnknownNameWithTheNearest) {
  const std::string error = error_of("arms:\n  - {name: left, robot: ur5}\n");
  EXPECT_NE(error.find("arms[0].robot = ur5 must be the name of a robot: did you mean 'ur5e'?"), std::string::npos)
      << error;
}

TEST(RobotCatalogue, RejectsAnArmWithNameAndUrdf) {
  const std::string error = error_of("arms:\n  - {name: left, robot: ur5e, urdf: a.urdf}\n");
  EXPECT_NE(error.find("arms[0].robot = ur5e must be left out, because urdf = a.urdf describes the robot"),
            std::string::npos)
      << error;
}

TEST(RobotCatalogue, NamesRobotInTheErrorOfAnArmWithoutAny) {
  const std::string error = error_of("arms:\n  - {name: left}\n");
  EXPECT_NE(error.find("arms[0].urdf is missing, but must be given, or robot with a name"), std::string::npos) << error;
}

TEST(RobotCatalogue, RunningCellKeepsTheFilesOfItsRobots) {
  const test::TemporaryFolder made;
  const fs::path& folder = made.path();
  std::ofstream(folder / "cell.yaml") << "name: test\narms:\n  - {name: left, robot: ur3e}\n";
  const CellFile file = load_cell_file((folder / "cell.yaml").string());
  file.sources.keep(folder / "kept");
  const CellFile again = load_cell_file((folder / "cell.yaml").string(), folder / "kept");
  EXPECT_EQ(again.cell.arms.front().arm.model->name, "ur3e");
  const auto of_robot = [](const std::string& path) { return fs::path(path).stem() == "ur3e"; };
  EXPECT_EQ(std::count_if(file.sources.read().begin(), file.sources.read().end(), of_robot), 2) << "YAML and URDF";
}

TEST(RobotCatalogue, EnvironmentNamesAnotherFolder) {
  const test::TemporaryFolder made;
  const fs::path& folder = made.path();
  fs::copy_file(robots_folder() / "gp7.urdf", folder / "mine.urdf");
  fs::copy_file(robots_folder() / "gp7.yaml", folder / "mine.yaml");
  ASSERT_EQ(setenv("HECATON_ROBOTS", folder.c_str(), 1), 0);
  EXPECT_EQ(robot_names(), std::vector<std::string>{"mine"});
  EXPECT_EQ(cell_of("arms:\n  - {name: left, robot: mine}\n").cell.arms.front().arm.model->joints(), 6);
  EXPECT_FALSE(is_robot_name("gp7"));
  ASSERT_EQ(unsetenv("HECATON_ROBOTS"), 0);
}

}  // namespace
}  // namespace hecaton::config
