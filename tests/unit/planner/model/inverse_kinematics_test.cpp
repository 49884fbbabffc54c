#include "planner/model/inverse_kinematics.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "planner/model/kinematics.hpp"
#include "planner/model/whole_turns.hpp"
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
  FreeRotation free_rotation;
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
  options.free_rotation = GetParam().free_rotation;
  int solved = 0;
  for (int i = 0; i < 1000; ++i) {
    const Pose X_WT = tool(arm, test::random_joints(arm.limits, random));
    const auto q = inverse_kinematics(arm, X_WT, start, options);
    if (!q) continue;
    ++solved;
    const Pose reached = tool(arm, *q);
    ASSERT_TRUE(within(arm.limits, *q));
    ASSERT_LE((reached.translation() - X_WT.translation()).norm(), 1.001e-4);
    if (options.free_rotation == FreeRotation::kNone) {
      ASSERT_LE(angle_between(reached, X_WT), 1.001e-3);
    }
    if (options.free_rotation == FreeRotation::kYaw) {
      ASSERT_LE(axis_angle(reached, X_WT), 1.01e-3);
    }
  }
  EXPECT_GE(solved, 990);
}

INSTANTIATE_TEST_SUITE_P(Tasks, ReachablePoses,
                         testing::Values(Case{"six_pose", test::kPuma, FreeRotation::kNone},
                                         Case{"six_position", test::kPuma, FreeRotation::kAll},
                                         Case{"six_axis", test::kPuma, FreeRotation::kYaw},
                                         Case{"five_position", test::kPuma5, FreeRotation::kAll},
                                         Case{"five_axis", test::kPuma5, FreeRotation::kYaw}),
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

TEST_F(Puma, FollowsAToolPoseThatMoves) {
  JointVector q = ready_;
  Pose X_WT = tool(arm_, ready_);
  for (int i = 0; i < 20; ++i) {
    X_WT.translation().z() += 0.01;
    const NearestPose nearest = nearest_pose(arm_, X_WT, q);
    ASSERT_LE(nearest.error.position, 1.001e-4);
    ASSERT_LE(nearest.error.orientation, 1.001e-3);
    ASSERT_LE((tool(arm_, nearest.q).translation() - X_WT.translation()).norm(), 1.001e-4);
    ASSERT_LT((nearest.q - q).cwiseAbs().maxCoeff(), 0.2) << i;
    q = nearest.q;
  }
}

TEST_F(Puma, StretchesTowardsAPoseOutOfReach) {
  Pose X_WT = tool(arm_, ready_);
  X_WT.translation().x() += 3.0;
  const NearestPose nearest = nearest_pose(arm_, X_WT, ready_);
  EXPECT_TRUE(within(arm_.limits, nearest.q));
  const Pose reached = tool(arm_, nearest.q);
  EXPECT_NEAR(nearest.error.position, (reached.translation() - X_WT.translation()).norm(), 1e-9);
  EXPECT_NEAR(nearest.error.orientation, angle_between(reached, X_WT), 1e-6);
  // No small motion of one joint is nearer, where 1 rad counts as 0.3 m.
  const auto cost = [&](const JointVector& q) {
    const Pose X = tool(arm_, q);
    return std::hypot((X.translation() - X_WT.translation()).norm(), 0.3 * angle_between(X, X_WT));
  };
  for (int j = 0; j < 6; ++j) {
    for (const double step : {-0.01, 0.01}) {
      JointVector moved = nearest.q;
      moved[j] += step;
      if (!within(arm_.limits, moved)) continue;
      EXPECT_GE(cost(moved), cost(nearest.q) - 1e-6) << j;
    }
  }
}

TEST_F(Puma, IsEmptyOutOfReach) {
  Pose X_WT = tool(arm_, ready_);
  X_WT.translation().x() += 3.0;
  EXPECT_FALSE(inverse_kinematics(arm_, X_WT, ready_));
  IkOptions position;
  position.free_rotation = FreeRotation::kAll;
  EXPECT_FALSE(inverse_kinematics(arm_, X_WT, ready_, position));
}

TEST_F(Puma, ReturnsAcceptedSolutionsOnly) {
  const Pose X_WT = tool(arm_, ready_);
  IkOptions options;
  options.free_rotation = FreeRotation::kAll;
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
  options.free_rotation = FreeRotation::kYaw;  // the roll that it cannot take is free
  EXPECT_TRUE(inverse_kinematics(arm, X_WT, ready, options));
}

/// A SCARA with links of 0.4 and 0.3 m: its tool turns about the vertical axis only.
Arm scara() {
  const auto limited = [](const char* lower, const char* upper) {
    return std::string("<limit lower=\"") + lower + "\" upper=\"" + upper + "\" velocity=\"1\" effort=\"1\"/>";
  };
  const std::string z = R"(<axis xyz="0 0 1"/>)";
  Arm arm;
  arm.name = "scara";
  arm.model = test::load_text(test::robot(
      test::ball_link("base") + test::ball_link("a") + test::ball_link("b") + test::ball_link("c") +
      test::ball_link("d") + test::joint("j1", "revolute", "base", "a", z + limited("-2.5", "2.5")) +
      test::joint("j2", "revolute", "a", "b", R"(<origin xyz="0.4 0 0"/>)" + z + limited("-2.5", "2.5")) +
      test::joint("j3", "prismatic", "b", "c", R"(<origin xyz="0.3 0 0"/><axis xyz="0 0 -1"/>)" + limited("0", "0.2")) +
      test::joint("j4", "revolute", "c", "d", z + limited("-3", "3"))));
  arm.limits = arm.model->limits;
  return arm;
}

Pose scara_goal(const Eigen::Vector3d& rpy) {
  return world::pose_from_xyz_rpy({0.4, 0.2, -0.1}, rpy);
}

TEST(Scara, TurnsItsToolAboutTheVerticalAxis) {
  const Arm arm = scara();
  for (const double yaw : {0.0, 2.0, -1.5}) {
    const auto q = inverse_kinematics(arm, scara_goal({0, 0, yaw}), JointVector::Zero(4));
    ASSERT_TRUE(q) << yaw;
    EXPECT_NEAR(std::remainder((*q)[0] + (*q)[1] + (*q)[3] - yaw, 2.0 * std::numbers::pi), 0.0, 1e-3);
  }
}

TEST(Scara, CannotTiltItsTool) {
  const Arm arm = scara();
  EXPECT_FALSE(inverse_kinematics(arm, scara_goal({std::numbers::pi, 0, 0}), JointVector::Zero(4)));
  EXPECT_FALSE(inverse_kinematics(arm, scara_goal({0, 0.8, 0}), JointVector::Zero(4)));
}

// The angle between Rz(ψ) and Rz(yaw) Ry(0.8) is smallest at ψ = yaw, where it is 0.8 rad.
TEST(Scara, HasItsNearestOrientationWithoutTilt) {
  const Arm arm = scara();
  for (const double yaw : {0.0, 1.2}) {
    const auto nearest = nearest_orientation(arm, scara_goal({0, 0.8, yaw}), JointVector::Zero(4));
    ASSERT_TRUE(nearest) << yaw;
    EXPECT_NEAR(nearest->angle, 0.8, 1e-3);
    EXPECT_TRUE(within(arm.limits, nearest->q));
    EXPECT_TRUE(nearest->X_WT.isApprox(tool(arm, nearest->q), 1e-9));
    EXPECT_LE((nearest->X_WT.translation() - Eigen::Vector3d(0.4, 0.2, -0.1)).norm(), 1.001e-4);
    EXPECT_NEAR(world::rpy_of(nearest->X_WT.linear()).z(), yaw, 2e-3);
  }
}

TEST(Scara, HasNoNearestOrientationOutOfReach) {
  Pose far = scara_goal({0, 0, 0});
  far.translation().x() = 2.0;
  EXPECT_FALSE(nearest_orientation(scara(), far, JointVector::Zero(4)));
}

TEST(Scara, TakesTheNearestOrientationThatIsAccepted) {
  const Arm arm = scara();
  IkOptions options;
  options.accept = [](const JointVector& q) { return q[1] < 0.0; };  // the elbow on one side
  const auto nearest = nearest_orientation(arm, scara_goal({0, 0.8, 0}), JointVector::Zero(4), options);
  ASSERT_TRUE(nearest);
  EXPECT_LT(nearest->q[1], 0.0);
  EXPECT_NEAR(nearest->angle, 0.8, 1e-3) << "both elbows reach it";
}

// The local minima are at yaw 0 and at limits of joints; nothing but yaws between them is accepted.
TEST(Scara, TakesAnAcceptedOrientationThatIsNoLocalMinimum) {
  const Arm arm = scara();
  const auto yaw_of = [](const JointVector& q) { return std::remainder(q[0] + q[1] + q[3], 2.0 * std::numbers::pi); };
  const Pose X_WT = scara_goal({0, 0.8, 0});
  IkOptions options;
  options.accept = [&](const JointVector& q) { return std::abs(yaw_of(q)) > 0.5 && std::abs(yaw_of(q)) < 1.5; };
  const auto nearest = nearest_orientation(arm, X_WT, JointVector::Zero(4), options);
  ASSERT_TRUE(nearest);
  EXPECT_TRUE(options.accept(nearest->q));
  EXPECT_LE((nearest->X_WT.translation() - X_WT.translation()).norm(), 1.001e-4);
  EXPECT_NEAR(nearest->angle, angle_between(nearest->X_WT, X_WT), 1e-6);
  options.accept = [](const JointVector&) { return false; };
  EXPECT_FALSE(nearest_orientation(arm, X_WT, JointVector::Zero(4), options));
}

// With the yaw free, the tool's z axis counts alone: for roll 0.8 it is 0.8 rad from the vertical.
TEST(Scara, MeasuresTheNearestOrientationWithoutTheFreeRotation) {
  IkOptions options;
  options.free_rotation = FreeRotation::kYaw;
  const auto nearest = nearest_orientation(scara(), scara_goal({0.8, 0, 3.0}), JointVector::Zero(4), options);
  ASSERT_TRUE(nearest);
  EXPECT_NEAR(nearest->angle, 0.8, 1e-3);
}

TEST(FiveJoints, HaveANearestOrientation) {
  const Arm arm = place(test::kPuma5);
  const JointVector ready = (JointVector(5) << -0.3, -1.25, 3.5, 0, 0.89).finished();
  std::mt19937_64 random(5);
  for (int i = 0; i < 20; ++i) {
    // A turn by 0.3 rad away from a reachable pose: the nearest orientation is at most that far.
    Pose X_WT = tool(arm, test::random_joints(arm.limits, random));
    X_WT.linear() = X_WT.linear() * Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    const auto nearest = nearest_orientation(arm, X_WT, ready);
    ASSERT_TRUE(nearest) << i;
    EXPECT_LE(nearest->angle, 0.3 + 1e-2) << i;
    EXPECT_NEAR(nearest->angle, angle_between(nearest->X_WT, X_WT), 1e-6);
  }
}

TEST(ToolGoalError, LeavesTheFreeRotationOut) {
  ToolGoal goal;
  goal.X_WT = world::pose_from_xyz_rpy({0.1, 0.2, 0.3}, {0.4, 0.5, 0.6});
  const auto turned = [&](const Eigen::Vector3d& axis) {
    Pose X_WT = goal.X_WT;
    X_WT.linear() = X_WT.linear() * Eigen::AngleAxisd(0.7, axis).toRotationMatrix();
    X_WT.translation().z() += 0.002;
    return tool_error(goal, X_WT);
  };
  const std::array<Eigen::Vector3d, 3> axes{Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY(),
                                            Eigen::Vector3d::UnitZ()};
  const std::array<FreeRotation, 3> free{FreeRotation::kRoll, FreeRotation::kPitch, FreeRotation::kYaw};
  for (std::size_t i = 0; i < 3; ++i) {
    goal.free_rotation = FreeRotation::kNone;
    EXPECT_NEAR(turned(axes[i]).orientation, 0.7, 1e-9);
    EXPECT_NEAR(turned(axes[i]).position, 0.002, 1e-12);
    goal.free_rotation = free[i];
    EXPECT_NEAR(turned(axes[i]).orientation, 0.0, 1e-9);
    EXPECT_NEAR(turned(axes[(i + 1) % 3]).orientation, 0.7, 1e-9);
    goal.free_rotation = FreeRotation::kAll;
    EXPECT_EQ(turned(axes[i]).orientation, 0.0);
  }
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
  options.free_rotation = FreeRotation::kAll;
  const JointVector start = (JointVector(2) << 7.0, 0.3).finished();
  const auto q = inverse_kinematics(arm, X_WT, start, options);
  ASSERT_TRUE(q);
  EXPECT_NEAR((*q)[1], 0.5, 2e-4);
  EXPECT_LE(std::abs((*q)[0] - 7.0), std::numbers::pi + 1e-9);  // the nearest of its turns
  EXPECT_NEAR(std::cos((*q)[0]), -0.6, 1e-3);
  EXPECT_NEAR(std::sin((*q)[0]), -0.8, 1e-3);
}

// A table below the shoulder: a straight motion may pass above it only, whatever turn of the joint is nearer.
TEST(WholeTurns, GoTheLongWayWhereTheShortOneIsBlocked) {
  Arm arm = place(test::kPuma);
  arm.limits.lower[1] = -2 * std::numbers::pi;
  arm.limits.upper[1] = 2 * std::numbers::pi;
  const JointVector start = JointVector::Zero(6);
  JointVector goal = start;
  goal[1] = 3.1;
  EXPECT_EQ(nearest_turns(arm, goal, start), goal);
  const auto above = [](const JointVector& q) { return std::sin(q[1]) < 0.2; };
  JointVector other = goal;
  other[1] -= 2 * std::numbers::pi;
  EXPECT_EQ(turns_with_free_way(arm, goal, start, above), other);
  EXPECT_EQ(turns_with_free_way(arm, goal, start, [](const JointVector&) { return true; }), goal);
  EXPECT_EQ(turns_with_free_way(arm, goal, start, [](const JointVector&) { return false; }), goal);
  // Both ways are blocked; the nearer one for longer.
  const auto narrow = [&](const JointVector& q) { return above(q) && std::abs(q[1] + 1.5) > 0.2; };
  EXPECT_EQ(turns_with_free_way(arm, goal, start, narrow), other);
  arm.limits.lower[1] = -3.0;  // the other turn is out of reach
  EXPECT_EQ(turns_with_free_way(arm, goal, start, above), goal);
}

// Three hinges about parallel axes move the tool in a plane; those of a PUMA in a volume.
TEST(ToolSurface, IsFoundFromTheJoints) {
  const std::string folder = std::string(HECATON_SOURCE_DIR) + "/deploy/cells/urdf/";
  EXPECT_TRUE(tool_stays_on_surface(place(folder + "planar_2r.urdf")));
  EXPECT_TRUE(tool_stays_on_surface(place(folder + "planar_3r.urdf")));
  EXPECT_FALSE(tool_stays_on_surface(place(test::kPuma)));
}

}  // namespace
}  // namespace hecaton::planner
