// The joints that move the tool, and the treatment of all others.

#include <cmath>
#include <set>

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
  EXPECT_TRUE(has_note(*model,
                       "joints outside the chain to the tool are held: 'left_joint' at 0.02, 'right_joint' at "
                       "-0.015"));
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

/// A second arm like kHand's on the same base.
const std::string kSecondHand = ball_link("arm2") + ball_link("hand2") +
                                joint("shoulder2", "revolute", "base", "arm2", kLimit) +
                                joint("wrist2", "revolute", "arm2", "hand2", R"(<origin xyz="1 0 0"/>)" + kLimit);

TEST(UrdfChain, RefusesEqualChainsWithoutToolLink) {
  UrdfOptions options;
  options.names.tool_link = "--tool LINK; both: @first @second";
  const std::string message = test::error_of(robot(kHand + kSecondHand), options);
  EXPECT_NE(
      message.find("the chains to links 'hand' and 'hand2' both have 2 joints; say which link is the tool (--tool "
                   "LINK; both: hand hand2)"),
      std::string::npos)
      << message;
}

std::string tool_of(const std::string& parts) {
  const auto model = load_text(robot(parts));
  return model->links[model->tool_link].name;
}

TEST(UrdfChain, ProposesTheHandInsteadOfAFinger) {
  const std::string grip = R"(<link name="grip"/>)" + joint("g", "fixed", "hand", "grip");
  EXPECT_EQ(tool_of(kHand + grip + finger("left", kOpening) + finger("right", kOpening)), "grip") << "both slide";
  const std::string follows = R"(<mimic joint="turn_a"/>)";
  EXPECT_EQ(tool_of(kHand + grip + ball_link("a") + ball_link("b") + joint("turn_a", "revolute", "hand", "a", kLimit) +
                    joint("turn_b", "revolute", "hand", "b", kLimit + follows)),
            "grip")
      << "one follows the other";
  EXPECT_EQ(tool_of(kHand + grip + ball_link("a") + joint("jaw_joint", "revolute", "hand", "a", kLimit)), "grip")
      << "it is named so";
}

TEST(UrdfChain, ProposesTheHandInsteadOfAThumb) {
  // Beside a thumb, which turns in two directions, the other fingers have names of their own and fewer joints.
  const std::string palm = R"(<link name="palm"/>)" + joint("p", "fixed", "hand", "palm");
  const std::string thumb =
      ball_link("thumb_base") + joint("thumb_proximal_yaw_joint", "revolute", "palm", "thumb_base", kLimit) +
      ball_link("thumb_tip") + joint("thumb_pitch", "revolute", "thumb_base", "thumb_tip", kLimit);
  const std::string index = ball_link("index_0") + joint("index_0_joint", "revolute", "palm", "index_0", kLimit);
  const std::string longer = ball_link("forearm") + joint("elbow", "revolute", "hand", "forearm", kLimit) +
                             R"(<link name="mount"/>)" + joint("m", "fixed", "forearm", "mount");
  std::string on_mount = palm + thumb + index;
  on_mount.replace(on_mount.find("\"hand\""), 6, "\"mount\"");
  EXPECT_EQ(tool_of(kHand + longer + on_mount), "palm");
}

// The flange has frames of its own, some with more fixed joints before them than the hand.
TEST(UrdfChain, ProposesTheHandInsteadOfTheFlange) {
  const auto fingers = [](const std::string& palm) {
    std::string text = finger("left", kOpening) + finger("right", kOpening);
    for (std::size_t at = 0; (at = text.find("\"hand\"", at)) != std::string::npos;) text.replace(at, 6, palm);
    return text;
  };
  const std::string flange = R"(<link name="flange"/><link name="tool0"/><link name="tool0_marker"/>)" +
                             joint("f", "fixed", "hand", "flange") + joint("t", "fixed", "flange", "tool0") +
                             joint("m", "fixed", "tool0", "tool0_marker");
  const std::string on_tool0 = ball_link("gripper") + joint("g", "fixed", "tool0", "gripper");
  EXPECT_EQ(tool_of(kHand + flange + on_tool0 + fingers("\"gripper\"")), "gripper");
  const std::string beside = ball_link("palm") + joint("p", "fixed", "hand", "palm");
  EXPECT_EQ(tool_of(kHand + flange + beside + fingers("\"palm\"")), "palm");
  EXPECT_EQ(tool_of(kHand + flange + fingers("\"tool0\"")), "tool0") << "the fingers hang on it";
}

TEST(UrdfChain, ProposesNoCameraOfTheHand) {
  const auto frames = [](const std::string& grasp) {
    return R"(<link name="camera_bottom"/><link name="camera_link"/><link name="camera_color_optical_frame"/>)"
           R"(<link name="grip"/>)" +
           joint("c1", "fixed", "hand", "camera_bottom") + joint("c2", "fixed", "camera_bottom", "camera_link") +
           joint("c3", "fixed", "camera_link", "camera_color_optical_frame") + joint("g", "fixed", "hand", "grip") +
           R"(<link name="tag"/><link name=")" + grasp + R"("/>)" + joint("t", "fixed", "grip", "tag") +
           joint("s", "fixed", "hand", grasp);
  };
  EXPECT_EQ(tool_of(kHand + frames("side")), "tag") << "the deepest of the others";
  EXPECT_EQ(tool_of(kHand + frames("link_grasp_center")), "link_grasp_center");
  EXPECT_EQ(tool_of(kHand + frames("Hand_TCP")), "Hand_TCP");
}

TEST(UrdfChain, TakesAWristForNoFinger) {
  EXPECT_EQ(tool_of(kHand + ball_link("gripper") + joint("joint3", "revolute", "hand", "gripper", kLimit)), "gripper");
  EXPECT_EQ(tool_of(kHand + ball_link("flange") + joint("gripper_roll", "revolute", "hand", "flange", kLimit)),
            "flange");
}

TEST(UrdfChain, HoldsOtherJointsWhereTheOptionsSay) {
  UrdfOptions options;
  options.tool_link = "hand";
  options.names.held_joints = "--joint NAME=VALUE";
  options.held_joints = {{"left_joint", 0.05}};
  const std::string parts = kHand + finger("left", kOpening) +
                            finger("right", kOpening, R"(<mimic joint="left_joint" multiplier="-1" offset="0.01"/>)");
  EXPECT_TRUE(has_note(*load_text(robot(parts), options),
                       "held (--joint NAME=VALUE sets them): 'left_joint' at 0.05, "
                       "'right_joint' at -0.04"));
  const auto refusal = [&](const std::string& name, double position) {
    options.held_joints = {{name, position}};
    return test::error_of(robot(parts), options);
  };
  EXPECT_NE(refusal("thumb", 0)
                .find("joint 'thumb' = 0: the robot has no such joint; it must be one of those outside "
                      "the chain: 'left_joint'"),
            std::string::npos)
      << refusal("thumb", 0);
  EXPECT_NE(refusal("wrist", 0).find("joint 'wrist' = 0: it moves the tool; remove it here"), std::string::npos);
  EXPECT_NE(refusal("right_joint", 0).find("it follows joint 'left_joint'; give that"), std::string::npos);
  EXPECT_NE(refusal("left_joint", 1).find("= 1 must be within its limits, 0.02 to 0.08"), std::string::npos);
}

TEST(UrdfChain, BeginsAtTheBaseLink) {
  UrdfOptions options;
  options.base_link = "arm";
  options.tool_link = "hand";
  options.held_joints = {{"shoulder", 1.0}};
  const auto model = load_text(robot(kHand), options);
  EXPECT_EQ(model->joint_names, std::vector<std::string>{"wrist"});
  Kinematics kinematics;
  forward_kinematics(*model, Pose::Identity(), JointVector::Zero(1), kinematics);
  // The shoulder turns about x, along which the wrist is 1 m away.
  EXPECT_TRUE(kinematics.X_WT.translation().isApprox(Eigen::Vector3d(1, 0, 0)));
  EXPECT_TRUE(kinematics.X_WT.linear().isApprox(Eigen::AngleAxisd(1.0, Eigen::Vector3d::UnitX()).toRotationMatrix()));
  options.base_link = "hand";
  options.tool_link = "arm";
  EXPECT_NE(test::error_of(robot(kHand), options).find("tool link 'arm' must hang on base link 'hand'"),
            std::string::npos);
}

TEST(UrdfChain, LeavesOutWhatOtherArmsOfTheRobotMove) {
  UrdfOptions options;
  options.tool_link = "hand";
  options.other_arms = {"hand2"};
  options.held_joints = {{"wrist2", 0.1}};
  const auto model =
      load_text(robot(kHand + kSecondHand + ball_link("box") + joint("f", "fixed", "base", "box")), options);
  std::set<std::string> names;
  for (const Link& link : model->links) names.insert(link.name);
  EXPECT_EQ(names, (std::set<std::string>{"base", "arm", "hand", "box"}));
  EXPECT_EQ(model->geometry.size(), 4U);
}

TEST(UrdfChain, TakesTheLongestChain) {
  const auto model = load_text(robot(kHand + ball_link("lamp") + joint("nod", "revolute", "base", "lamp", kLimit)));
  EXPECT_EQ(model->joint_names, (std::vector<std::string>{"shoulder", "wrist"}));
  EXPECT_EQ(model->links[model->tool_link].name, "hand");
  EXPECT_TRUE(has_note(*model, "outside the chain to the tool are held: 'nod' at 0"));
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

TEST(UrdfChain, FixesJointsThatCannotMove) {
  const std::string locked = R"(<axis xyz="0 0 1"/><limit lower="0.5" upper="0.5" effort="1" velocity="1"/>)";
  const auto model = load_text(robot(kHand + ball_link("lamp") + joint("nod", "revolute", "hand", "lamp", locked)));
  EXPECT_EQ(model->joint_names, (std::vector<std::string>{"shoulder", "wrist"}));
  EXPECT_EQ(model->links[model->tool_link].name, "lamp");
  EXPECT_TRUE(has_note(*model, "joint 'nod' is fixed: both its limits are 0.5"));
}

TEST(UrdfChain, AcceptsFaultyJointsOutsideTheChainOnly) {
  const std::string lamp = kHand + ball_link("lamp") + joint("nod", "revolute", "base", "lamp");
  EXPECT_TRUE(has_note(*load_text(robot(lamp)),
                       "joint 'nod' has no <limit>; revolute and prismatic joints need lower "
                       "and upper; it is outside the chain to the tool and held at 0"));
  UrdfOptions options;
  options.tool_link = "lamp";
  EXPECT_NE(test::error_of(robot(lamp), options).find("r.urdf: joint 'nod' has no <limit>"), std::string::npos);
}

TEST(UrdfChain, AcceptsFollowersOfMissingJointsOutsideTheChainOnly) {
  const std::string lamp =
      kHand + ball_link("lamp") + joint("nod", "revolute", "base", "lamp", kLimit + R"(<mimic joint="neck"/>)");
  EXPECT_TRUE(has_note(*load_text(robot(lamp)),
                       "joint 'nod': it mimics joint 'neck', which does not exist in this file; it is outside the "
                       "chain to the tool and held at 0"));
  UrdfOptions options;
  options.tool_link = "lamp";
  EXPECT_NE(test::error_of(robot(lamp), options).find("r.urdf: joint 'nod': it mimics joint 'neck'"),
            std::string::npos);
}

TEST(UrdfChain, HoldsAFloatingOrPlanarBase) {
  for (const std::string type : {"floating", "planar"}) {
    const auto model = load_text(
        robot(kHand + R"(<link name="world"/>)" + joint("mount", type, "world", "base", R"(<origin xyz="0 0 2"/>)")));
    EXPECT_EQ(model->joints(), 2);
    EXPECT_TRUE(has_note(*model, "joint 'mount' is " + type + " and held in its zero position"));
    EXPECT_DOUBLE_EQ(model->links[1].X_PJ.translation().z(), 2.0);
  }
}

TEST(UrdfChain, RefusesMoreJointsThanTheCapacityAndMergesFixedLinks) {
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
  const auto merged = load_text(robot(links + "<link name=\"more\"/>" + joint("more", "fixed", "l0", "more")));
  EXPECT_EQ(merged->links.size(), 48U);
  EXPECT_TRUE(has_note(*merged, "the robot has 49 links; 1 of them"));
}

}  // namespace
}  // namespace hecaton::planner
