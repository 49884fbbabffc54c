#include "tests/bench/problem_set.hpp"

#include <fstream>

#include <gtest/gtest.h>

#include "tests/support/temporary_folder.hpp"

namespace hecaton::bench {
namespace {

std::string link(const std::string& name) {
  return "<link name='" + name + "'><collision><geometry><sphere radius='0.05'/></geometry></collision></link>";
}

std::string joint(const std::string& name, const std::string& type, const std::string& parent,
                  const std::string& child) {
  return "<joint name='" + name + "' type='" + type + "'><parent link='" + parent + "'/><child link='" + child +
         "'/><origin xyz='0 0.3 0'/><axis xyz='1 0 0'/><limit lower='-1' upper='1' effort='1' velocity='1'/></joint>";
}

/// A torso that carries two arms of two joints, and a finger on the left one.
std::string torso_with_two_arms() {
  std::string urdf = "<robot name='twin'>";
  for (const char* name : {"base", "torso", "la", "lb", "finger", "ra", "rb"}) urdf += link(name);
  return urdf + joint("lift", "prismatic", "base", "torso") + joint("l1", "revolute", "torso", "la") +
         joint("l2", "revolute", "la", "lb") + joint("grip", "prismatic", "lb", "finger") +
         joint("r1", "revolute", "torso", "ra") + joint("r2", "revolute", "ra", "rb") + "</robot>";
}

constexpr const char* kScene =
    "world: {collision_objects: [{header: {frame_id: base}, id: box, primitives: [{type: box, dimensions: [1, 2, 3]}], "
    "primitive_poses: [{position: [4, 0, 0], orientation: [0, 0, 0, 1]}]}]}\n";

std::string request(const std::string& names, const std::string& start, const std::vector<std::string>& goal) {
  std::string text = "start_state: {joint_state: {name: [" + names + "], position: [" + start +
                     "]}}\ngoal_constraints: [{joint_constraints: [";
  for (const std::string& name : goal) text += "{joint_name: " + name + ", position: 0.5}, ";
  return text + "]}]\n";
}

class ProblemSetTest : public testing::Test {
 protected:
  ProblemSetTest() {
    write("twin.urdf", torso_with_two_arms());
    write("twin.srdf", "<robot name='twin'/>");
    std::filesystem::create_directories(folder_.path() / "problems/shelf");
  }
  void write(const std::string& name, const std::string& text) { std::ofstream(folder_.path() / name) << text; }
  void add_problem(const std::string& number, const std::string& names, const std::string& start,
                   const std::vector<std::string>& goal) {
    write("problems/shelf/scene" + number + ".yaml", kScene);
    write("problems/shelf/request" + number + ".yaml", request(names, start, goal));
  }
  ProblemSet read(const std::vector<std::string>& tool_links = {}) {
    return read_problem_set({path("twin.urdf"), path("twin.srdf"), path("problems"), tool_links});
  }
  /// The sentence that refuses the set, without the folder; empty: none.
  std::string refusal(const std::vector<std::string>& tool_links = {}) {
    try {
      static_cast<void>(read(tool_links));
      return {};
    } catch (const std::exception& error) {
      std::string says = error.what();
      const std::string folder = folder_.path().string() + "/";
      for (auto at = says.find(folder); at != std::string::npos; at = says.find(folder)) says.erase(at, folder.size());
      return says;
    }
  }
  [[nodiscard]] std::string path(const std::string& name) const { return (folder_.path() / name).string(); }

 private:
  test::TemporaryFolder folder_;
};

TEST_F(ProblemSetTest, PlansForTheJointsOfTheGoalAndHoldsTheOthers) {
  add_problem("0001", "lift, l1, l2, grip, r1, r2", "0.2, 0, 0.1, 0.3, 0, 0", {"l1", "l2"});
  const ProblemSet set = read();
  ASSERT_EQ(set.arms.size(), 1U);
  const planner::RobotModel& model = *set.arms.front().model;
  EXPECT_EQ(model.joint_names, (std::vector<std::string>{"l1", "l2"}));
  EXPECT_EQ(model.links[model.tool_link].name, "lb");
  ASSERT_EQ(set.problems.size(), 1U);
  EXPECT_EQ(set.problems.front().family, "shelf");
  EXPECT_EQ(set.problems.front().start, (std::vector<double>{0.0, 0.1}));
  EXPECT_EQ(set.problems.front().goal, (std::vector<double>{0.5, 0.5}));
  ASSERT_EQ(set.problems.front().world.size(), 1U);
  // The torso stands at the start's 0.2 along x.
  planner::Kinematics kinematics;
  planner::forward_kinematics(model, set.arms.front().X_WB, planner::JointVector::Zero(2), kinematics);
  EXPECT_NEAR(kinematics.X_WL[model.tool_link].translation().x(), 0.2, 1e-9);
}

TEST_F(ProblemSetTest, PlansTwoArmsOfOneRobotTogether) {
  add_problem("0001", "lift, l1, l2, grip, r1, r2", "0, 0, 0.1, 0, 0.2, 0.3", {"l1", "l2", "r1", "r2"});
  const ProblemSet set = read();
  ASSERT_EQ(set.arms.size(), 2U);
  EXPECT_TRUE(same_robot(set.arms[0], set.arms[1]));
  EXPECT_EQ(set.problems.front().start, (std::vector<double>{0.0, 0.1, 0.2, 0.3}));
  EXPECT_EQ(make_validity(set, 0.1).dimensions(), 4);
}

TEST_F(ProblemSetTest, WidensLimitsToStartsAndGoals) {
  add_problem("0001", "lift, l1, l2", "0, 1.001, 0", {"l1", "l2"});
  const ProblemSet set = read();
  EXPECT_EQ(set.arms.front().limits.upper[0], 1.001);
  EXPECT_EQ(set.arms.front().limits.upper[1], 1.0);
}

TEST_F(ProblemSetTest, RefusesWrongFilesWithOneSentence) {
  EXPECT_EQ(refusal().substr(0, 44), "problems: has no file sceneNNNN.yaml at any ");
  add_problem("0001", "lift, l1, l2", "0, 0, 0", {"l1", "panda_joint1"});
  EXPECT_EQ(refusal(),
            "problems/shelf/request0001.yaml: has a goal for joint 'panda_joint1', which twin.urdf does not have; give "
            "the problems of this robot");
  add_problem("0001", "lift, l1, l2", "0, 0, 0", {"l1"});
  EXPECT_EQ(
      refusal({"lb"}),
      "problems/shelf/request0001.yaml: has no goal for joint 'l2', which moves link 'lb'; name another link with "
      "--tool-link");
  EXPECT_EQ(refusal({"hand"}),
            "--tool-link hand: twin.urdf has no link of this name; leave the option out to take it from the requests");
  add_problem("0002", "lift, l1, l2", "0.1, 0, 0", {"l1"});
  EXPECT_EQ(
      refusal(),
      "problems/shelf/request0002.yaml: starts joint 'lift' elsewhere than problems/shelf/request0001.yaml, though "
      "no goal moves it; give only problems that hold it in one place");
  write("problems/shelf/scene0003.yaml", kScene);
  EXPECT_EQ(refusal(), "problems/shelf/scene0003.yaml: has no request0003.yaml beside it; unpack the problems again");
}

}  // namespace
}  // namespace hecaton::bench
