// The joints that move the tool, and the treatment of all others.

#include <cmath>

#include "planner/model/kinematics.hpp"
#include "tests/unit/planner/model/support.hpp"

namespace hecaton::planner {
namespace {

using test::ball_link;
using test::has_note;
using test::joint;
using test::kLimit;
using test::load_text;
using test::robot;

const std::string kHand = ball_link("base") + ball_link("arm") + ball_link("hand") +
                          joint("shoulder", "revolute", "base", "arm", kLimit) +
                          joint("wrist", "revolute", "arm", "hand", R"(<origin xyz="1 0 0"/>)" + kLimit);

std::string finger(const std::string& name, const std::string& limit, const std::string& extra = "") {
  return ball_link(name) + joint(name + "_joint", "prismatic", "hand", name, R"(<axis xyz="0 1 0"/>)" + limit + extra);
}

const std::string kOpening = R"(<limit lower="0.02" upper="0.08" effort="1" velocity="1"/>)";

TEST(UrdfChain, FixesFingersAtTheNearestLimitAndMimicsWithThem) {
  UrdfOptions options;
  options.tool_link = "hand";
  const auto model = load_text(robot(kHand + finger("left", kOpening) +
                                     finger("right", R"(<limit lower="-1" upper="1" effort="1" velocity="0"/>)",
                                            R"(<mimic joint="left_joint" multiplier="-1" offset="0.005"/>)")),
                               options);
  EXPECT_EQ(model->joint_names, (std::vector<std::string>{"shoulder", "wrist"}));
  EXPECT_TRUE(has_note(*model, "joint 'left_joint' is outside the chain to the tool and held at 0.02"));
  Kinematics kinematics;
  forward_kinematics(*model, Pose::Identity(), JointVector::Zero(2), kinematics);
  for (std::size_t i = 0; i < model->links.size(); ++i) {
    const Eigen::Vector3d p = kinematics.X_WL[i].translation();
    if (model->links[i].name == "left") {
      EXPECT_TRUE(p.isApprox(Eigen::Vector3d(1, 0.02, 0)));
    }
    if (model->links[i].name == "right") {
      EXPECT_TRUE(p.isApprox(Eigen::Vector3d(1, -0.015, 0)));
    }
  }
  // hand and fingers are one body, neighbour of arm; base is not its neighbour: 3 pairs.
  EXPECT_EQ(model->self_pairs.size(), 3U);
}

TEST(UrdfChain, RefusesEqualChainsWithoutToolLink) {
  const std::string message = test::error_of(robot(kHand + finger("left", kOpening) + finger("right", kOpening)));
  EXPECT_NE(message.find("both have 3 joints; say which link is the tool"), std::string::npos) << message;
}

TEST(UrdfChain, TakesTheLongestChain) {
  const auto model = load_text(robot(kHand + ball_link("lamp") + joint("nod", "revolute", "base", "lamp", kLimit)));
  EXPECT_EQ(model->joint_names, (std::vector<std::string>{"shoulder", "wrist"}));
  EXPECT_EQ(model->links[model->tool_link].name, "hand");
  EXPECT_TRUE(has_note(*model, "joint 'nod' is outside the chain"));
}

TEST(UrdfChain, PrefersTool0AmongFramesOfTheLastBody) {
  const std::string frames = R"(<link name="a_frame"/><link name="tool0"/><link name="far"/>)" +
                             joint("f1", "fixed", "hand", "a_frame") + joint("f2", "fixed", "hand", "tool0") +
                             joint("f3", "fixed", "a_frame", "far");
  const auto model = load_text(robot(kHand + frames));
  EXPECT_EQ(model->links[model->tool_link].name, "tool0");
  UrdfOptions options;
  options.tool_link = "far";
  const auto far = load_text(robot(kHand + frames), options);
  EXPECT_EQ(far->links[far->tool_link].name, "far");
}

TEST(UrdfChain, RefusesCoupledMechanisms) {
  const std::string in_chain =
      robot(ball_link("base") + ball_link("a") + ball_link("b") + joint("j1", "revolute", "base", "a", kLimit) +
            joint("j2", "revolute", "a", "b", kLimit + R"(<mimic joint="j1"/>)"));
  EXPECT_NE(test::error_of(in_chain).find("joint 'j2' moves the tool but mimics joint 'j1'"), std::string::npos);
  const std::string rod = joint("rod_joint", "revolute", "base", "rod", kLimit + R"(<mimic joint="wrist"/>)");
  EXPECT_NE(test::error_of(robot(kHand + ball_link("rod") + rod)).find("joint 'rod_joint' follows joint 'wrist'"),
            std::string::npos);
  EXPECT_TRUE(has_note(*load_text(robot(kHand + R"(<link name="rod"/>)" + rod)), "'rod_joint' follows joint 'wrist'"));
}

TEST(UrdfChain, RefusesMoreJointsOrLinksThanTheCapacity) {
  std::string links = ball_link("l0");
  for (int i = 1; i <= 16; ++i) {
    links += ball_link("l" + std::to_string(i)) +
             joint("j" + std::to_string(i), "revolute", "l" + std::to_string(i - 1), "l" + std::to_string(i), kLimit);
  }
  EXPECT_EQ(load_text(robot(links))->joints(), 16);
  EXPECT_NE(test::error_of(robot(links + ball_link("l17") + joint("j17", "revolute", "l16", "l17", kLimit)))
                .find("17 joints move the tool; at most 16"),
            std::string::npos);
  for (int i = 17; i < 48; ++i) {
    const std::string name = "f" + std::to_string(i);
    links += "<link name=\"" + name + "\"/>" + joint(name, "fixed", "l0", name);
  }
  EXPECT_EQ(load_text(robot(links))->links.size(), 48U);
  EXPECT_NE(test::error_of(robot(links + "<link name=\"more\"/>" + joint("more", "fixed", "l0", "more")))
                .find("has 49 links; at most 48"),
            std::string::npos);
}

}  // namespace
}  // namespace hecaton::planner
