#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "services/command_line/document.hpp"
#include "tests/unit/services/cli/run_line.hpp"

namespace hecaton::services::cli {
namespace {

/// `hecaton plan` with MoveIt's files and an SRDF.
class PlanMoveIt : public testing::Test {
 protected:
  PlanMoveIt() { std::filesystem::create_directories(folder_); }
  ~PlanMoveIt() override { std::filesystem::remove_all(folder_); }

  [[nodiscard]] std::string file(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  }
  /// A small box far above the cell.
  [[nodiscard]] std::string scene(const std::string& id, const std::string& more = "") const {
    return file("scene.yaml", "world:\n  collision_objects:\n    - {id: " + id +
                                  ", primitives: [{type: box, dimensions: [0.1, 0.1, 0.1]}], primitive_poses: "
                                  "[{position: [0, 0, 5], orientation: [0, 0, 0, 1]}]}\n" +
                                  more);
  }
  /// Of a PUMA 560 that turns its first joint.
  [[nodiscard]] std::string request(const std::string& more = "") const {
    std::string text =
        "start_state: {joint_state: {name: [joint1, joint2, joint3, joint4, joint5, joint6], "
        "position: [0, -1.5, 1, 0, 0, 0]}}\ngoal_constraints:\n  - joint_constraints:\n";
    const std::vector<std::string> goal{"0.2", "-1.5", "1", "0", "0", "0"};
    for (std::size_t i = 0; i < goal.size(); ++i) {
      text += "      - {joint_name: joint" + std::to_string(i + 1) + ", position: " + goal[i] + "}\n";
    }
    return file("request.yaml", text + more);
  }

  const std::string cell_ = std::string(HECATON_SOURCE_DIR) + "/deploy/cells/three_puma.yaml";
  const std::string robot_ = std::string(HECATON_SOURCE_DIR) + "/deploy/cells/urdf/puma560.urdf";

 private:
  std::filesystem::path folder_ = std::filesystem::temp_directory_path() / ("plan_moveit" + std::to_string(::getpid()));
};

void expect_refused(const Ran& ran, const std::string& says) {
  EXPECT_EQ(ran.code, ExitCode::kBadInput) << ran.err;
  EXPECT_NE(ran.err.find(says), std::string::npos) << ran.err;
}

void expect_note(const Ran& ran, const std::string& says) {
  ASSERT_EQ(ran.code, ExitCode::kDone) << ran.err;
  const Json plan = Json::parse(ran.out);
  ASSERT_EQ(plan["findings"].size(), 1U) << ran.out;
  EXPECT_NE(plan["findings"][0]["sentence"].get<std::string>().find(says), std::string::npos) << ran.out;
}

TEST_F(PlanMoveIt, RejectsAGroupThatTheSrdfDoesNotHave) {
  const std::string srdf = file("arm.srdf",
                                "<robot name='puma560'><group name='arm'><joint name='joint1'/></group>"
                                "<group name='hand'/></robot>");
  const auto plan = [&](const std::string& group) {
    return run_line(
        {"plan", robot_, "--srdf", srdf, "--moveit-request", request("group_name: " + group + "\n"), "-o", "json"});
  };
  expect_refused(plan("banana"), "group_name = 'banana' must be arm or hand, the groups of " + srdf);
  const Ran known = plan("arm");
  ASSERT_EQ(known.code, ExitCode::kDone) << known.err;
  EXPECT_EQ(known.err.find("group_name"), std::string::npos) << known.err;
}

TEST_F(PlanMoveIt, NotesAGroupWithoutAnSrdf) {
  expect_note(run_line({"plan", robot_, "--moveit-request", request("group_name: banana\n"), "-o", "json"}),
              "group_name = 'banana' is not read");
}

TEST_F(PlanMoveIt, NotesASceneOfAnotherRobot) {
  const std::vector<std::string> words{"plan", robot_, "--from",        "0 -1.5 1 0 0 0", "--to", "0.2 -1.5 1 0 0 0",
                                       "-o",   "json", "--moveit-scene"};
  const auto plan = [&](const std::string& robot) {
    std::vector<std::string> all = words;
    all.push_back(scene("shelf", "robot_model_name: " + robot + "\n"));
    return run_line(all);
  };
  expect_note(plan("ur5"), "robot_model_name = 'ur5' is not puma560");
  EXPECT_EQ(plan("puma560").err.find("robot_model_name"), std::string::npos);
}

TEST_F(PlanMoveIt, RejectsAnObjectWithTheNameOfAnObstacle) {
  const std::string file = scene("post");
  for (const std::string method : {"rrt_connect", "potential_field", "known_cspace"}) {
    expect_refused(run_line({"plan", cell_, "--to", "ready", "--moveit-scene", file, "--method", method}),
                   file + ": world.collision_objects[0].id = 'post' must be unique");
  }
}

TEST_F(PlanMoveIt, RejectsARequestForArmsWithEqualJointNames) {
  const std::string file = request();
  expect_refused(run_line({"plan", cell_, "--arm", "west", "--arm", "north", "--moveit-request", file}),
                 file + ": start_state.joint_state.name: 'joint1' is a joint of each of the planned arms west, north");
}

TEST_F(PlanMoveIt, RejectsEmptyOptionsOfTheRobot) {
  for (const std::string option : {"--srdf", "--tool", "--package"}) {
    for (const std::string command : {"plan", "check"}) {
      expect_refused(run_line({command, robot_, option, ""}), option + " = '' must");
    }
  }
}

}  // namespace
}  // namespace hecaton::services::cli
