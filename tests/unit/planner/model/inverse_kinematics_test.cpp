#include "planner/model/inverse_kinematics.hpp"

#include <cmath>
#include <numbers>

#include "planner/model/kinematics.hpp"
#include "tests/unit/planner/model/support.hpp"

namespace hecaton::planner {
namespace {

Arm place(const std::string& urdf) {
  Arm arm;
  arm.name = "arm";
  arm.model = load_urdf(urdf);
  arm.limits = arm.model->limits;
  arm.X_WB.translation() << 0.7, -0.3, 0.1;
  arm.X_WB.linear() = Eigen::AngleAxisd(2.0, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  return arm;
}

Pose tool(const Arm& arm, const JointVector& q) {
  Kinematics kinematics;
  forward_kinematics(*arm.model, arm.X_WB, q, kinematics);
  return kinematics.X_WT;
}

bool within(const JointLimits& limits, const JointVector& q) {
  return (q.array() >= limits.lower.array()).all() && (q.array() <= limits.upper.array()).all();
}

double angle_between(const Pose& a, const Pose& b) {
  return Eigen::AngleAxisd(a.linear().transpose() * b.linear()).angle();
}

double axis_angle(const Pose& a, const Pose& b) {
  return std::acos(std::clamp(a.linear().col(2).dot(b.linear().col(2)), -1.0, 1.0));
}

struct Case {
  const char* name;
  std::string urdf;
  IkTask task;
};
void PrintTo(const Case& c, std::ostream* out) {
  *out << c.name;
}

class ReachablePoses : public testing::TestWithParam<Case> {};

TEST_P(ReachablePoses, AreSolvedWithinLimits) {
  const Arm arm = place(GetParam().urdf);
  JointVector start = JointVector::Zero(arm.model->joints());
  start.head(5) << -0.3, -1.25, 3.5, 0, 0.89;
  std::mt19937_64 random(42);
  IkOptions options;
  options.task = GetParam().task;
  int solved = 0;
  for (int i = 0; i < 1000; ++i) {
    const Pose X_WT = tool(arm, test::random_joints(arm.limits, random));
    const auto q = inverse_kinematics(arm, X_WT, start, options);
    if (!q) continue;
    ++solved;
    const Pose reached = tool(arm, *q);
    ASSERT_TRUE(within(arm.limits, *q));
    ASSERT_LE((reached.translation() - X_WT.translation()).norm(), 1.001e-4);
    if (options.task == IkTask::kPose) {
      ASSERT_LE(angle_between(reached, X_WT), 1.001e-3);
    }
    if (options.task == IkTask::kPositionAndAxis) {
      ASSERT_LE(axis_angle(reached, X_WT), 1.01e-3);
    }
  }
  EXPECT_GE(solved, 990);
}

INSTANTIATE_TEST_SUITE_P(Tasks, ReachablePoses,
                         testing::Values(Case{"six_pose", test::kPuma, IkTask::kPose},
                                         Case{"six_position", test::kPuma, IkTask::kPosition},
                                         Case{"six_axis", test::kPuma, IkTask::kPositionAndAxis},
                                         Case{"five_position", test::kPuma5, IkTask::kPosition},
                                         Case{"five_axis", test::kPuma5, IkTask::kPositionAndAxis}),
                         test::CaseName());

class Puma : public testing::Test {
 protected:
  Arm arm_ = place(test::kPuma);
  JointVector ready_ = (JointVector(6) << -0.3, -1.25, 3.5, 0, 0.89, 0).finished();
};

TEST_F(Puma, ReturnsAStartThatSolves) {
  const auto q = inverse_kinematics(arm_, tool(arm_, ready_), ready_);
  ASSERT_TRUE(q);
  EXPECT_TRUE(q->isApprox(ready_, 1e-12));
}

TEST_F(Puma, SolvesNearbyGoalsNearTheStart) {
  Pose X_WT = tool(arm_, ready_);
  X_WT.translation().z() += 0.03;
  const auto q = inverse_kinematics(arm_, X_WT, ready_);
  ASSERT_TRUE(q);
  EXPECT_LT((*q - ready_).cwiseAbs().maxCoeff(), 0.3);
}

TEST_F(Puma, UnwindsFullTurnsTowardsTheStart) {
  JointVector start = ready_;
  start[5] = 4.0;  // the same tool pose as 4 − 2π = −2.28, both within ±4.64
  JointVector goal = ready_;
  goal[5] = 4.0 - 2.0 * std::numbers::pi;
  const auto q = inverse_kinematics(arm_, tool(arm_, goal), start);
  ASSERT_TRUE(q);
  EXPECT_NEAR((*q)[5], 4.0, 1e-2);
}

TEST_F(Puma, IsEmptyOutOfReach) {
  Pose X_WT = tool(arm_, ready_);
  X_WT.translation().x() += 3.0;
  EXPECT_FALSE(inverse_kinematics(arm_, X_WT, ready_));
  IkOptions position;
  position.task = IkTask::kPosition;
  EXPECT_FALSE(inverse_kinematics(arm_, X_WT, ready_, position));
}

TEST_F(Puma, ReturnsAcceptedSolutionsOnly) {
  const Pose X_WT = tool(arm_, ready_);
  IkOptions options;
  options.task = IkTask::kPosition;
  options.accept = [](const JointVector& q) { return q[2] < 1.0; };  // elbow below; ready's is above, at 3.5
  const auto q = inverse_kinematics(arm_, X_WT, ready_, options);
  ASSERT_TRUE(q);
  EXPECT_LT((*q)[2], 1.0);
  EXPECT_LE((tool(arm_, *q).translation() - X_WT.translation()).norm(), 1.001e-4);
  options.accept = [](const JointVector&) { return false; };
  EXPECT_FALSE(inverse_kinematics(arm_, X_WT, ready_, options));
}

TEST_F(Puma, GivesTheSameSolutionForTheSameSeed) {
  std::mt19937_64 random(9);
  for (int i = 0; i < 50; ++i) {
    const Pose X_WT = tool(arm_, test::random_joints(arm_.limits, random));
    const auto a = inverse_kinematics(arm_, X_WT, ready_);
    const auto b = inverse_kinematics(arm_, X_WT, ready_);
    ASSERT_EQ(a.has_value(), b.has_value());
    if (a) {
      ASSERT_EQ(*a, *b);
    }
  }
}

TEST_F(Puma, KeepsTightenedLimits) {
  arm_.limits.lower[5] = -0.1;  // the cell file's, tighter than the URDF's
  arm_.limits.upper[5] = 0.1;
  std::mt19937_64 random(10);
  int solved = 0;
  for (int i = 0; i < 100; ++i) {
    const auto q = inverse_kinematics(arm_, tool(arm_, test::random_joints(arm_.limits, random)), ready_);
    if (!q) continue;
    ++solved;
    ASSERT_TRUE(within(arm_.limits, *q));
  }
  EXPECT_GE(solved, 90);
}

TEST(FiveJoints, RefuseAnUnreachablePose) {
  const Arm arm = place(test::kPuma5);
  const JointVector ready = (JointVector(5) << -0.3, -1.25, 3.5, 0, 0.89).finished();
  Pose X_WT = tool(arm, ready);
  X_WT.linear() = X_WT.linear() * Eigen::AngleAxisd(0.9, Eigen::Vector3d(0, 0, 1)).toRotationMatrix();
  X_WT.translation() += Eigen::Vector3d(0.01, 0.02, 0.03);
  IkOptions options;
  options.seeds = 8;
  EXPECT_FALSE(inverse_kinematics(arm, X_WT, ready, options));
  options.task = IkTask::kPositionAndAxis;  // the roll that it cannot take is free
  EXPECT_TRUE(inverse_kinematics(arm, X_WT, ready, options));
}

TEST(ContinuousAndPrismatic, AreSolvedToo) {
  Arm arm;
  arm.name = "arm";
  arm.model = test::load_text(test::robot(
      test::ball_link("base") + test::ball_link("a") + test::ball_link("b") +
      test::joint("spin", "continuous", "base", "a", R"(<axis xyz="0 0 1"/><limit velocity="1" effort="1"/>)") +
      test::joint("reach", "prismatic", "a", "b",
                  R"(<axis xyz="1 0 0"/><limit lower="0.2" upper="1" velocity="1" effort="1"/>)")));
  arm.limits = arm.model->limits;
  Pose X_WT = Pose::Identity();
  X_WT.translation() << -0.3, -0.4, 0;  // at 0.5 m, 180° + 53.13° from x
  IkOptions options;
  options.task = IkTask::kPosition;
  const JointVector start = (JointVector(2) << 7.0, 0.3).finished();
  const auto q = inverse_kinematics(arm, X_WT, start, options);
  ASSERT_TRUE(q);
  EXPECT_NEAR((*q)[1], 0.5, 2e-4);
  EXPECT_LE(std::abs((*q)[0] - 7.0), std::numbers::pi + 1e-9);  // the nearest of its turns
  EXPECT_NEAR(std::cos((*q)[0]), -0.6, 1e-3);
  EXPECT_NEAR(std::sin((*q)[0]), -0.8, 1e-3);
}

}  // namespace
}  // namespace hecaton::planner
