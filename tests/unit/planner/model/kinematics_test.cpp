// Forward kinematics against numbers derived by hand from the PUMA's dimensions, Jacobians against differences.

#include "planner/model/kinematics.hpp"

#include <array>
#include <numbers>

#include "tests/unit/planner/model/support.hpp"

namespace hecaton::planner {
namespace {

constexpr double kA2 = 0.4318;
constexpr double kA3 = -0.0203;  // Lee's sign
constexpr double kD2 = 0.15;
constexpr double kD4 = 0.4318;
constexpr double kShoulder = 0.672;
constexpr double kTool = 0.1;
constexpr double kQuarter = std::numbers::pi / 2.0;

Eigen::Matrix3d about(const Eigen::Vector3d& axis, double angle) {
  return Eigen::AngleAxisd(angle, axis).toRotationMatrix();
}

Pose tool_of(const RobotModel& model, std::initializer_list<double> joints) {
  JointVector q(static_cast<Eigen::Index>(joints.size()));
  std::copy(joints.begin(), joints.end(), q.begin());
  Kinematics kinematics;
  forward_kinematics(model, Pose::Identity(), q, kinematics);
  return kinematics.X_WT;
}

class Puma : public testing::Test {
 protected:
  std::shared_ptr<const RobotModel> model_ = load_urdf(test::kPuma);
  std::mt19937_64 random_{7};
};

TEST_F(Puma, PoseAtZeroIsAnLWithTheForearmUp) {
  // x = a2 + a3 = 0.4318 − 0.0203, y = d2, z = shoulder + d4 + tool = 0.672 + 0.4318 + 0.1
  const Pose X_WT = tool_of(*model_, {0, 0, 0, 0, 0, 0});
  EXPECT_TRUE(X_WT.translation().isApprox(Eigen::Vector3d(0.4115, 0.15, 1.2038), 1e-9));
  EXPECT_TRUE(X_WT.linear().isIdentity(1e-9));
}

TEST_F(Puma, StretchedForward) {
  // q3 = 90°: forearm and tool along x. The elbow's offset a3 lifts the forearm by −a3 = 0.0203 above the shoulder.
  // x = 0.4318 + 0.4318 + 0.1, z = 0.672 + 0.0203
  const Pose X_WT = tool_of(*model_, {0, 0, kQuarter, 0, 0, 0});
  EXPECT_TRUE(X_WT.translation().isApprox(Eigen::Vector3d(0.9636, 0.15, 0.6923), 1e-9));
  EXPECT_TRUE(X_WT.linear().col(2).isApprox(Eigen::Vector3d::UnitX(), 1e-9));
}

TEST_F(Puma, StraightUpTurnedByAQuarter) {
  // Everything up, then turned about z: the shoulder's offset y → −x, the elbow's offset −x → −y.
  // z = 0.672 + 0.4318 + 0.4318 + 0.1
  const Pose X_WT = tool_of(*model_, {kQuarter, -kQuarter, kQuarter, 0, 0, 0});
  EXPECT_TRUE(X_WT.translation().isApprox(Eigen::Vector3d(-0.15, -0.0203, 1.6356), 1e-9));
  EXPECT_TRUE(X_WT.linear().col(2).isApprox(Eigen::Vector3d::UnitZ(), 1e-9));
}

TEST_F(Puma, WristBendsSideways) {
  // q4 = 90° turns joint 5's axis from y to −x; q5 = 90° about −x takes the tool from z to y.
  const Pose X_WT = tool_of(*model_, {0, 0, 0, kQuarter, kQuarter, 0});
  EXPECT_TRUE(X_WT.translation().isApprox(Eigen::Vector3d(0.4115, 0.25, 1.1038), 1e-9));
  EXPECT_TRUE(X_WT.linear().col(2).isApprox(Eigen::Vector3d::UnitY(), 1e-9));
}

TEST_F(Puma, ReadyPoseMatchesTheUrdf) {
  const Pose X_WT = tool_of(*model_, {-0.3, -1.25, 3.5, 0, 0.89, 0});
  EXPECT_TRUE(X_WT.translation().isApprox(Eigen::Vector3d(0.508, 0.0, 0.726), 2e-3));
  EXPECT_LT(X_WT.linear()(2, 2), -0.999);
}

TEST_F(Puma, MatchesTheClosedFormEverywhere) {
  // The DH product multiplied by hand. Joints 2, 3 and 5 rotate about y, joints 1, 4 and 6 about z.
  // R = Rz(q1) Ry(q2 + q3) Rz(q4) Ry(q5) Rz(q6)
  // p = h z + Rz(q1) [ Ry(q2) (a2, d2, 0) + Ry(q2 + q3) (a3, 0, d4) ] + tool · R z
  const Eigen::Vector3d y = Eigen::Vector3d::UnitY();
  const Eigen::Vector3d z = Eigen::Vector3d::UnitZ();
  for (int i = 0; i < 1000; ++i) {
    const JointVector q = test::random_joints(model_->limits, random_);
    const Eigen::Matrix3d R = about(z, q[0]) * about(y, q[1] + q[2]) * about(z, q[3]) * about(y, q[4]) * about(z, q[5]);
    const Eigen::Vector3d p = kShoulder * z +
                              about(z, q[0]) * (about(y, q[1]) * Eigen::Vector3d(kA2, kD2, 0) +
                                                about(y, q[1] + q[2]) * Eigen::Vector3d(kA3, 0, kD4)) +
                              kTool * R * z;
    Kinematics kinematics;
    forward_kinematics(*model_, Pose::Identity(), q, kinematics);
    ASSERT_LT((kinematics.X_WT.translation() - p).norm(), 1e-12);
    ASSERT_LT((kinematics.X_WT.linear() - R).norm(), 1e-12);
  }
}

TEST_F(Puma, FiveJointArmMatchesExceptTheLastRoll) {
  const auto five = load_urdf(test::kPuma5);
  ASSERT_EQ(five->joints(), 5);
  for (int i = 0; i < 100; ++i) {
    const JointVector q5 = test::random_joints(five->limits, random_);
    JointVector q6 = JointVector::Zero(6);
    q6.head(5) = q5;
    Kinematics a;
    Kinematics b;
    forward_kinematics(*five, Pose::Identity(), q5, a);
    forward_kinematics(*model_, Pose::Identity(), q6, b);
    ASSERT_TRUE(a.X_WT.isApprox(b.X_WT, 1e-12));
  }
}

/// Arms with revolute, continuous and prismatic joints, skew axes, fixed links between and behind.
class Jacobian : public testing::TestWithParam<const char*> {
 protected:
  static std::shared_ptr<const RobotModel> model() {
    if (std::string(GetParam()) == "puma") return load_urdf(test::kPuma);
    const std::string axis_a = R"(<axis xyz="0.6 0 0.8"/>)";
    const std::string axis_b = R"(<axis xyz="0 1 1"/>)";
    const std::string origin = R"(<origin xyz="0.1 -0.2 0.3" rpy="0.3 -0.5 0.7"/>)";
    return test::load_text(test::robot(test::ball_link("base") + test::ball_link("a") + test::ball_link("b") +
                                       test::ball_link("c") + "<link name=\"between\"/><link name=\"tip\"/>" +
                                       test::joint("j1", "revolute", "base", "a", origin + axis_a + test::kLimit) +
                                       test::joint("f", "fixed", "a", "between", origin) +
                                       test::joint("j2", "prismatic", "between", "b", origin + axis_b + test::kLimit) +
                                       test::joint("j3", "continuous", "b", "c", origin + axis_a + test::kLimit) +
                                       test::joint("t", "fixed", "c", "tip", origin)));
  }
};

TEST_P(Jacobian, EqualsCentralDifferences) {
  const auto arm = model();
  Pose X_WB = Pose::Identity();
  X_WB.translation() << 0.4, -1.0, 0.2;
  X_WB.linear() = about(Eigen::Vector3d(1, 2, 3).normalized(), 0.8);
  std::mt19937_64 random(3);
  constexpr double kStep = 1e-6;
  for (int trial = 0; trial < 200; ++trial) {
    const JointVector q = test::random_joints(arm->limits, random);
    Kinematics at;
    Kinematics ahead;
    Kinematics behind;
    forward_kinematics(*arm, X_WB, q, at);
    const int link = static_cast<int>(random() % arm->links.size());
    const Eigen::Vector3d p_L(0.05, 0.1, -0.07);
    const Eigen::Vector3d p_W = at.X_WL[link] * p_L;
    const Eigen::Vector3d n_W = Eigen::Vector3d(0.2, -0.5, 0.4).normalized();
    FrameJacobian tool;
    PointJacobian point;
    JointVector row;
    tool_jacobian(*arm, at, tool);
    point_jacobian(*arm, at, link, p_W, point);
    directional_jacobian(*arm, at, link, p_W, n_W, row);
    for (int j = 0; j < arm->joints(); ++j) {
      JointVector shifted = q;
      shifted[j] = q[j] + kStep;
      forward_kinematics(*arm, X_WB, shifted, ahead);
      shifted[j] = q[j] - kStep;
      forward_kinematics(*arm, X_WB, shifted, behind);
      const Eigen::Vector3d v = (ahead.X_WT.translation() - behind.X_WT.translation()) / (2 * kStep);
      const Eigen::AngleAxisd turn(ahead.X_WT.linear() * behind.X_WT.linear().transpose());
      ASSERT_LT((tool.col(j).tail<3>() - v).norm(), 1e-8);
      ASSERT_LT((tool.col(j).head<3>() - turn.axis() * turn.angle() / (2 * kStep)).norm(), 1e-6);
      const Eigen::Vector3d v_point = (ahead.X_WL[link] * p_L - behind.X_WL[link] * p_L) / (2 * kStep);
      ASSERT_LT((point.col(j) - v_point).norm(), 1e-8);
      ASSERT_NEAR(row[j], n_W.dot(v_point), 1e-8);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Arms, Jacobian, testing::Values("puma", "mixed"));

/// Directions that kinematics take short cuts for, opposite ones, and one of no particular direction.
class Axes : public testing::TestWithParam<std::array<double, 3>> {};

TEST_P(Axes, RotateAboutOrTranslateAlongTheAxis) {
  // Two joints about and along the axis, on a base of no particular pose.
  const Eigen::Vector3d axis = Eigen::Map<const Eigen::Vector3d>(GetParam().data()).normalized();
  RobotModel model;
  model.joint_names = {"turns", "shifts"};
  for (int j = 0; j < 2; ++j) {
    Link link;
    link.parent = j - 1;
    link.joint = j;
    link.joint_type = j == 0 ? JointType::kRevolute : JointType::kPrismatic;
    link.axis = axis;
    link.X_PJ = world::pose_from_xyz_rpy({0.1, 0.2, 0.3}, {0.4, -0.5, 0.6});
    model.links.push_back(link);
  }
  model.tool_link = 1;
  const Pose X_WB = world::pose_from_xyz_rpy({1.0, 2.0, 3.0}, {0.7, 0.8, -0.9});
  JointVector q(2);
  q << 1.3, 0.25;
  Kinematics kinematics;
  forward_kinematics(model, X_WB, q, kinematics);
  const Pose X_WJ = X_WB * model.links[0].X_PJ;
  const Pose turned = X_WJ * Eigen::AngleAxisd(1.3, axis);
  const Pose shifted = turned * model.links[1].X_PJ * Eigen::Translation3d(0.25 * axis);
  EXPECT_TRUE(kinematics.X_WL[0].isApprox(turned, 1e-14));
  EXPECT_TRUE(kinematics.X_WL[1].isApprox(shifted, 1e-14));
  EXPECT_TRUE(kinematics.axis_W[0].isApprox(X_WJ.linear() * axis, 1e-14));
  EXPECT_TRUE(kinematics.origin_W[0].isApprox(X_WJ.translation(), 1e-14));

  // The short cut, if there is one, changes nothing.
  for (Link& link : model.links) link.motion = joint_motion(link);
  Kinematics shorter;
  forward_kinematics(model, X_WB, q, shorter);
  EXPECT_EQ(shorter.X_WL[1].matrix(), kinematics.X_WL[1].matrix());
  EXPECT_EQ(shorter.axis_W[0], kinematics.axis_W[0]);
}

TEST_F(Puma, JointsUseTheirSpecialCases) {
  for (const Link& link : model_->links) {
    EXPECT_EQ(link.motion, link.joint < 0 ? JointMotion::kFixed : JointMotion::kTurnsAboutZ) << link.name;
  }
}

INSTANTIATE_TEST_SUITE_P(Kinematics, Axes,
                         testing::Values(std::array{1.0, 0.0, 0.0}, std::array{0.0, 1.0, 0.0},
                                         std::array{0.0, 0.0, 1.0}, std::array{0.0, 0.0, -1.0},
                                         std::array{0.0, -1.0, 0.0}, std::array{1.0, -2.0, 2.0}));

}  // namespace
}  // namespace hecaton::planner
