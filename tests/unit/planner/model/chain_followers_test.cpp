// Links of the chain that follow joints of others, against robots whose links all have joints of their own.

#include <cmath>
#include <numbers>

#include "planner/model/arm.hpp"
#include "planner/model/inverse_kinematics.hpp"
#include "planner/model/kinematics.hpp"
#include "planner/model/kinematics_kernels.hpp"
#include "tests/support/mechanisms.hpp"

namespace hecaton::planner {
namespace {

using test::ball_link;
using test::has_note;
using test::joint;
using test::kLimit;
using test::load_text;
using test::robot;

constexpr double kPi = std::numbers::pi;

class ChainFollowers : public testing::TestWithParam<test::Mechanism> {
 protected:
  std::shared_ptr<const RobotModel> model_ = GetParam().load(false);
  std::shared_ptr<const RobotModel> independent_ = GetParam().load(true);
  Pose X_WB_ = world::pose_from_xyz_rpy({0.4, -1.0, 0.2}, {0.3, 0.8, -0.5});
  std::mt19937_64 random_{5};
};

TEST_P(ChainFollowers, AreNoJointsOfThePlanner) {
  EXPECT_EQ(model_->joint_names, GetParam().joint_names);
  EXPECT_TRUE(model_->has_followers);
  EXPECT_FALSE(independent_->has_followers);
  EXPECT_TRUE(has_note(*model_, "joints on the way to the tool follow others: "));
}

TEST_P(ChainFollowers, PlaceAllLinksAsEquivalentJointsDo) {
  for (int trial = 0; trial < 200; ++trial) {
    const JointVector q = test::random_joints(model_->limits, random_);
    Kinematics one;
    Kinematics other;
    forward_kinematics(*model_, X_WB_, q, one);
    forward_kinematics(*independent_, X_WB_, GetParam().positions(q), other);
    for (int link = 0; link < one.links; ++link) {
      ASSERT_TRUE(one.X_WL[link].isApprox(other.X_WL[link], 1e-12)) << model_->links[link].name;
    }
    ASSERT_TRUE(one.X_WT.isApprox(other.X_WT, 1e-12));
    Kinematics links_only;
    place_links(*model_, X_WB_, q, links_only);
    ASSERT_EQ(links_only.X_WL[one.links - 1].matrix(), one.X_WL[one.links - 1].matrix());
  }
}

TEST_P(ChainFollowers, HaveTheJacobiansOfEquivalentJoints) {
  const Eigen::MatrixXd gains = GetParam().gains();
  for (int trial = 0; trial < 200; ++trial) {
    const JointVector q = test::random_joints(model_->limits, random_);
    Kinematics one;
    Kinematics other;
    forward_kinematics(*model_, X_WB_, q, one);
    forward_kinematics(*independent_, X_WB_, GetParam().positions(q), other);
    FrameJacobian tool;
    FrameJacobian all_tool;
    tool_jacobian(*model_, one, tool);
    tool_jacobian(*independent_, other, all_tool);
    ASSERT_TRUE(tool.isApprox(all_tool * gains, 1e-12));
    for (int link = 0; link < one.links; ++link) {
      const Eigen::Vector3d p_W = one.X_WL[link] * Eigen::Vector3d(0.05, 0.1, -0.07);
      const Eigen::Vector3d n_W = Eigen::Vector3d(0.2, -0.5, 0.4).normalized();
      PointJacobian point;
      PointJacobian all_points;
      point_jacobian(*model_, one, link, p_W, point);
      point_jacobian(*independent_, other, link, p_W, all_points);
      ASSERT_LT((point - all_points * gains).norm(), 1e-12);
      JointVector row;
      directional_jacobian(*model_, one, link, p_W, n_W, row);
      ASSERT_LT((row.transpose() - n_W.transpose() * point).norm(), 1e-12);
    }
  }
}

TEST_P(ChainFollowers, MoveNoFasterThanTheirBound) {
  std::normal_distribution<double> normal;
  for (int trial = 0; trial < 300; ++trial) {
    Kinematics kinematics;
    forward_kinematics(*model_, X_WB_, test::random_joints(model_->limits, random_), kinematics);
    JointVector speed(model_->joints());
    JointVector qd(model_->joints());
    for (int j = 0; j < speed.size(); ++j) {
      speed[j] = std::abs(normal(random_));
      qd[j] = random_() % 2 == 0 ? speed[j] : -speed[j];
    }
    std::array<double, kMaxJoints> speeds;
    axis_speeds(*model_, speed, speeds);
    const auto& w = kinematics.angular_W;
    const auto& v = kinematics.linear_W;
    for (int link = 0; link < kinematics.links; ++link) {
      CarriedBall ball{kinematics.X_WL[link].data(), {0.1, -0.2, 0.1}, 0.15, axes_before(*model_, link)};
      baseline::bound_speeds({{w[0].data(), w[1].data(), w[2].data()}, {v[0].data(), v[1].data(), v[2].data()}},
                             speeds.data(), &ball, 1);
      const Eigen::Vector3d out = Eigen::Vector3d(normal(random_), normal(random_), normal(random_)).normalized();
      PointJacobian J;
      point_jacobian(*model_, kinematics, link, Eigen::Map<const Eigen::Vector3d>(ball.centre_W) + 0.15 * out, J);
      ASSERT_LE((J * qd).norm(), ball.fastest + 1e-12);
    }
  }
}

TEST_P(ChainFollowers, StayWithinTheReach) {
  Arm arm;
  arm.model = model_;
  arm.X_WB = X_WB_;
  arm.limits = model_->limits;
  const ArmReach reach = arm_reach(arm);
  double farthest = 0.0;
  for (int trial = 0; trial < 5000; ++trial) {
    Kinematics kinematics;
    forward_kinematics(*model_, X_WB_, test::random_joints(model_->limits, random_), kinematics);
    for (int link = 0; link < kinematics.links; ++link) {
      ASSERT_LE((kinematics.X_WL[link].translation() - reach.centre).norm(), reach.links[link] + 1e-12);
    }
    const double tool = (kinematics.X_WT.translation() - reach.centre).norm();
    ASSERT_LE(tool, reach.tool + 1e-12);
    farthest = std::max(farthest, tool / reach.tool);
  }
  EXPECT_GT(farthest, 0.5);
}

TEST_P(ChainFollowers, AreSolvedByInverseKinematics) {
  Arm arm;
  arm.model = model_;
  arm.limits = model_->limits;
  int solved = 0;
  for (int trial = 0; trial < 20; ++trial) {
    Kinematics kinematics;
    forward_kinematics(*model_, arm.X_WB, test::random_joints(model_->limits, random_), kinematics);
    const auto q = inverse_kinematics(arm, kinematics.X_WT, JointVector::Zero(model_->joints()));
    if (!q) continue;
    ++solved;
    Kinematics there;
    forward_kinematics(*model_, arm.X_WB, *q, there);
    EXPECT_LT((there.X_WT.translation() - kinematics.X_WT.translation()).norm(), 1e-3);
    EXPECT_LT(Eigen::AngleAxisd(there.X_WT.linear().transpose() * kinematics.X_WT.linear()).angle(), 1e-2);
  }
  EXPECT_GE(solved, 18);
}

INSTANTIATE_TEST_SUITE_P(Mechanisms, ChainFollowers, testing::ValuesIn(test::mechanisms()), test::CaseName());

std::string limited(const std::string& lower, const std::string& upper, const std::string& velocity = "1.5") {
  return R"(<axis xyz="0 1 0"/><limit effort="1" lower=")" + lower + "\" upper=\"" + upper + "\" velocity=\"" +
         velocity + "\"/>";
}

/// Two links, of which the second follows the first.
std::string follower(const std::string& first, const std::string& second, const std::string& type = "revolute") {
  return robot(ball_link("base") + ball_link("a") + ball_link("b") + joint("j1", type, "base", "a", first) +
               joint("j2", "revolute", "a", "b", R"(<origin xyz="0.5 0 0"/>)" + second));
}

TEST(LimitsOfFollowers, NarrowTheJointThatTheyFollow) {
  const auto model = load_text(
      follower(limited("-2", "2"), limited("-1", "3", "0.6") + R"(<mimic joint="j1" multiplier="-2" offset="1"/>)"));
  EXPECT_DOUBLE_EQ(model->limits.lower[0], -1.0);
  EXPECT_DOUBLE_EQ(model->limits.upper[0], 1.0);
  EXPECT_DOUBLE_EQ(model->limits.velocity[0], 0.3);
  EXPECT_TRUE(has_note(*model, "joint 'j1' is narrowed to -1 … 1 by the limits of joint 'j2', which follows it"));
}

TEST(LimitsOfFollowers, CountOnlyWhereTheyGiveARange) {
  const std::string mimic = R"(<mimic joint="j1" multiplier="-1"/>)";
  for (const std::string& limit : {limited("0", "0", "0"), limited("0", "6.2832"), limited("2", "-2"), std::string()}) {
    const auto model = load_text(follower(limited("-2", "2"), limit + mimic));
    EXPECT_DOUBLE_EQ(model->limits.lower[0], -2.0) << limit;
    EXPECT_DOUBLE_EQ(model->limits.upper[0], 2.0) << limit;
    EXPECT_DOUBLE_EQ(model->limits.velocity[0], 1.5) << limit;
    EXPECT_FALSE(has_note(*model, "narrowed"));
  }
}

TEST(LimitsOfFollowers, AreTakenWithTheOppositeSignWhenTheFollowerTurnsTheOtherWay) {
  const auto model =
      load_text(follower(limited("0", "0.9"), limited("0", "0.8") + R"(<mimic joint="j1" multiplier="-1"/>)"));
  EXPECT_DOUBLE_EQ(model->limits.lower[0], 0.0);
  EXPECT_DOUBLE_EQ(model->limits.upper[0], 0.8);
  EXPECT_TRUE(
      has_note(*model, "joint 'j2' follows joint 'j1' in the opposite direction; its limits, 0 to 0.8, are used"));
}

TEST(LimitsOfFollowers, AreRefusedWhenTheyLeaveNoRange) {
  EXPECT_NE(test::error_of(follower(limited("-1", "1"), limited("2", "3") + R"(<mimic joint="j1"/>)"))
                .find("r.urdf: joint 'j2' follows joint 'j1', and its limits, 2 to 3, leave no range of that joint"),
            std::string::npos);
}

const std::string kEndless = R"(<axis xyz="0 1 0"/><limit effort="1" velocity="1"/>)";

TEST(EndlessJoints, KeepTheirTurnsOnlyIfTheirFollowersRepeat) {
  const auto doubled = load_text(follower(kEndless, R"(<mimic joint="j1" multiplier="2"/>)", "continuous"));
  EXPECT_TRUE(std::isinf(doubled->limits.upper[0]));
  EXPECT_TRUE(repeats_after_turn(*doubled, 0));
  const auto halved = load_text(follower(kEndless, R"(<mimic joint="j1" multiplier="0.5"/>)", "continuous"));
  EXPECT_FALSE(repeats_after_turn(*halved, 0));
  EXPECT_DOUBLE_EQ(halved->limits.lower[0], -kPi);
  EXPECT_DOUBLE_EQ(halved->limits.upper[0], kPi);
  EXPECT_TRUE(has_note(*halved, "joint 'j1' has no limits, but its followers are elsewhere after a whole turn"));
}

TEST(EndlessJoints, AreUnwoundOnlyIfTheirFollowersRepeat) {
  // The joint turns twice. Its follower is elsewhere after a turn.
  const auto model = load_text(follower(limited("-7", "7"), R"(<mimic joint="j1" multiplier="0.5"/>)"));
  Arm arm;
  arm.model = model;
  arm.limits = model->limits;
  Kinematics at;
  const JointVector q = JointVector::Constant(1, -1.5);
  forward_kinematics(*model, arm.X_WB, q, at);
  const auto found = inverse_kinematics(arm, at.X_WT, JointVector::Constant(1, 4.5));
  ASSERT_TRUE(found.has_value());
  Kinematics there;
  forward_kinematics(*model, arm.X_WB, *found, there);
  EXPECT_LT(Eigen::AngleAxisd(there.X_WT.linear().transpose() * at.X_WT.linear()).angle(), 1e-2);
}

TEST(JointsBesideTheChain, MoveItOverTheirFollowers) {
  // A crank on the base drives the forearm over a rod that is not modelled.
  const std::string arm =
      robot(ball_link("base") + ball_link("upper") + ball_link("crank") + ball_link("fore") +
            joint("shoulder", "revolute", "base", "upper", limited("-1", "1")) +
            joint("drive", "revolute", "base", "crank", limited("-0.5", "0.7", "0.4")) +
            joint("elbow", "revolute", "upper", "fore",
                  R"(<origin xyz="0 0 1"/><axis xyz="0 1 0"/><mimic joint="drive" offset="0.2"/>)"));
  UrdfOptions options;
  options.tool_link = "fore";
  const auto model = load_text(arm, options);
  EXPECT_EQ(model->joint_names, (std::vector<std::string>{"shoulder", "drive"}));
  EXPECT_EQ(joint_type(*model, 1), JointType::kRevolute);
  EXPECT_DOUBLE_EQ(model->limits.lower[1], -0.5);
  EXPECT_DOUBLE_EQ(model->limits.velocity[1], 0.4);
  EXPECT_TRUE(has_note(*model, "links beside the chain follow its joints"));
  Kinematics kinematics;
  JointVector q(2);
  q << 0.3, 0.1;
  forward_kinematics(*model, Pose::Identity(), q, kinematics);
  EXPECT_TRUE(kinematics.X_WT.linear().isApprox(Eigen::AngleAxisd(0.6, Eigen::Vector3d::UnitY()).matrix(), 1e-12));

  options.held_joints["drive"] = 0.5;
  const auto held = load_text(arm, options);
  EXPECT_EQ(held->joint_names, (std::vector<std::string>{"shoulder"}));
  forward_kinematics(*held, Pose::Identity(), JointVector::Zero(1), kinematics);
  EXPECT_TRUE(kinematics.X_WT.linear().isApprox(Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitY()).matrix(), 1e-12));
}

TEST(FixedFollowers, AreWhereTheirLockedJointPutsThem) {
  const auto model = load_text(robot(ball_link("base") + ball_link("a") + ball_link("b") + ball_link("lever") +
                                     joint("lock", "revolute", "base", "lever", limited("0.4", "0.4")) +
                                     joint("j1", "revolute", "base", "a", kLimit) +
                                     joint("j2", "revolute", "a", "b", R"(<axis xyz="0 1 0"/><mimic joint="lock"/>)")));
  EXPECT_EQ(model->joint_names, (std::vector<std::string>{"j1"}));
  Kinematics kinematics;
  forward_kinematics(*model, Pose::Identity(), JointVector::Zero(1), kinematics);
  const int b = model->tool_link;
  EXPECT_TRUE(kinematics.X_WL[b].linear().isApprox(Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitY()).matrix(), 1e-12));
}

TEST(ChainFollowersOfOtherArms, AreRefused) {
  const std::string arm =
      robot(ball_link("base") + ball_link("left") + ball_link("right") + ball_link("hand") +
            joint("jl", "revolute", "base", "left", kLimit) + joint("jr", "revolute", "base", "right", kLimit) +
            joint("jh", "revolute", "right", "hand", R"(<mimic joint="jl"/>)"));
  UrdfOptions options;
  options.tool_link = "hand";
  options.other_arms = {"left"};
  EXPECT_NE(test::error_of(arm, options).find("joint 'jh' moves the tool but mimics joint 'jl' of another arm"),
            std::string::npos);
}

TEST(FramesBetweenTurns, NeedNoGeometry) {
  const auto with_rod = [](const std::string& rod, const std::string& origin) {
    return robot(ball_link("base") + ball_link("a") + rod + ball_link("b") +
                 joint("j1", "revolute", "base", "a", kLimit) +
                 joint("j2", "revolute", "a", "rod", R"(<origin xyz="1 0 0"/><mimic joint="j1" multiplier="-1"/>)") +
                 joint("j3", "revolute", "rod", "b", origin + kLimit));
  };
  const auto model = load_text(with_rod(R"(<link name="rod"/>)", ""));
  EXPECT_TRUE(has_note(*model, "link 'rod', which joint 'j2' moves, has no collision geometry and no extent"));
  EXPECT_NE(test::error_of(with_rod(R"(<link name="rod"/>)", R"(<origin xyz="0.1 0 0"/>)"))
                .find("link 'rod', which joint 'j2' moves, has no collision geometry; it must have some"),
            std::string::npos);
}

}  // namespace
}  // namespace hecaton::planner
