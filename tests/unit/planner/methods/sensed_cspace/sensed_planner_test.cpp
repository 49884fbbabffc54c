#include "planner/methods/sensed_cspace/sensed_planner.hpp"

#include <gtest/gtest.h>

#include "planner/model/urdf_loader.hpp"

namespace hecaton::planner::cspace {
namespace {

using Path = SensedPlanner::Path;

/// The planar arm, standing at −0.8 with its goal at 0.8, in front of points that it sees.
class SensedPlannerTest : public testing::Test {
 protected:
  SensedPlannerTest() {
    arm_.model = load_urdf(std::string(HECATON_SOURCE_DIR) + "/deploy/cells/urdf/planar_2r.urdf");
    arm_.limits = arm_.model->limits;
    arm_.limits.acceleration = Eigen::Vector2d(8.0, 8.0);
  }

  [[nodiscard]] SensedPlanner planner(Remember remember, int cells = 360) const {
    return SensedPlanner(arm_, {.cells = cells, .margin = 0.03, .remember = remember}, 0.01);
  }
  /// One scan, from a sensor on the base.
  void see(SensedPlanner& planner, const std::vector<double>& distances) const {
    RangeScan scan{0, 0, from_, {}};
    for (const double distance : distances) scan.readings.push_back({{}, distance, true});
    planner.sense(scan);
  }
  [[nodiscard]] Path step(SensedPlanner& planner) const { return planner.guide(from_, still_, to_).path; }
  /// What it comes to once it no longer searches.
  [[nodiscard]] Path settle(SensedPlanner& planner) const {
    for (int period = 0; period < 2000; ++period) {
      if (const Path path = step(planner); path != Path::kSearching) return path;
    }
    return Path::kSearching;
  }

  Arm arm_;
  JointVector from_ = Eigen::Vector2d(-0.8, 0.0);
  JointVector to_ = Eigen::Vector2d(0.8, 0.0);
  JointVector still_ = Eigen::Vector2d(0.0, 0.0);
};

TEST_F(SensedPlannerTest, GoesStraightUntilASensorMeasuresAnObstacle) {
  SensedPlanner planner = this->planner(Remember::kAlways);
  EXPECT_EQ(settle(planner), Path::kStraight);
  see(planner, {0.75});
  EXPECT_EQ(settle(planner), Path::kAround);
  EXPECT_EQ(planner.searches(), 2);
}

TEST_F(SensedPlannerTest, SearchesAgainOnlyWhenThePathIsBlocked) {
  SensedPlanner planner = this->planner(Remember::kAlways);
  see(planner, {0.75});
  ASSERT_EQ(settle(planner), Path::kAround);
  see(planner, {0.95});  // the way is folded past it
  ASSERT_EQ(settle(planner), Path::kAround);
  EXPECT_EQ(planner.searches(), 1);
}

// Algorithm 3, step 2.3: what is seen again is not modelled again.
TEST_F(SensedPlannerTest, MapsOnlyNewPoints) {
  for (const Remember remember : {Remember::kNever, Remember::kUntilNearer, Remember::kAlways}) {
    SensedPlanner planner = this->planner(remember);
    see(planner, {0.75});
    ASSERT_EQ(settle(planner), Path::kAround);
    const std::int64_t mapped = planner.mapped();
    EXPECT_GT(mapped, 0);
    for (int period = 0; period < 20; ++period) {
      see(planner, {0.75});
      (void)step(planner);
    }
    EXPECT_EQ(planner.mapped(), mapped);
    see(planner, {0.75, 0.8});
    (void)step(planner);
    EXPECT_GT(planner.mapped(), mapped);
  }
}

// Noise changes the map in every period of a search that takes several.
TEST_F(SensedPlannerTest, FinishesASearchWhileNewPointsArrive) {
  for (const Remember remember : {Remember::kNever, Remember::kUntilNearer, Remember::kAlways}) {
    SensedPlanner planner = this->planner(remember, 1440);
    Path path = Path::kSearching;
    int searching = 0;
    for (int period = 0; period < 2000 && path == Path::kSearching; ++period) {
      see(planner, {period % 2 == 0 ? 0.75 : 0.757});
      path = step(planner);
      searching += path == Path::kSearching ? 1 : 0;
    }
    EXPECT_EQ(path, Path::kAround);
    EXPECT_GT(searching, 2) << "otherwise the test shows nothing";
  }
}

TEST_F(SensedPlannerTest, ForgettingArmFindsAPathThatHasBecomeFree) {
  for (const Remember remember : {Remember::kNever, Remember::kAlways}) {
    SensedPlanner planner = this->planner(remember);
    see(planner, {0.3});  // stops the first link
    ASSERT_EQ(settle(planner), Path::kNone);
    see(planner, {});
    EXPECT_EQ(settle(planner), remember == Remember::kNever ? Path::kStraight : Path::kNone);
  }
}

// A detour ends where the goal is in sight and nearer than where it began by a cell: not before.
TEST_F(SensedPlannerTest, RemembersADetourUntilTheGoalIsNearer) {
  SensedPlanner planner = this->planner(Remember::kUntilNearer);
  see(planner, {0.75});
  ASSERT_EQ(settle(planner), Path::kAround);
  see(planner, {});
  EXPECT_EQ(settle(planner), Path::kAround) << "remembered";
  from_ = Eigen::Vector2d(0.6, 0.0);  // past it
  EXPECT_EQ(settle(planner), Path::kStraight);
  see(planner, {});
  (void)step(planner);
  EXPECT_TRUE(planner.map().points().empty()) << "forgotten";
}

TEST_F(SensedPlannerTest, AllowsOnlyMotionThatCanStop) {
  SensedPlanner planner = this->planner(Remember::kAlways);
  see(planner, {0.75});
  (void)settle(planner);
  EXPECT_TRUE(planner.may_go(from_, from_, still_));
  EXPECT_TRUE(planner.may_go(from_, from_, Eigen::Vector2d(0.3, 0.0)));
  const JointVector close = Eigen::Vector2d(-0.2, 0.0);
  const JointVector inside = Eigen::Vector2d(0.0, 0.0);
  ASSERT_TRUE(planner.may_go(close, close, still_));
  EXPECT_FALSE(planner.may_go(close, close, Eigen::Vector2d(1.4, 0.0)));
  EXPECT_FALSE(planner.may_go(close, inside, Eigen::Vector2d(0.1, 0.0))) << "not even slowly";
  EXPECT_FALSE(planner.may_go(inside, inside, Eigen::Vector2d(1.0, 0.0))) << "blocked, and fast";
  EXPECT_TRUE(planner.may_go(inside, inside, Eigen::Vector2d(0.1, 0.0))) << "leaves it, slowly";
}

TEST_F(SensedPlannerTest, ReturnsAlongItsTrail) {
  SensedPlanner planner = this->planner(Remember::kAlways);
  for (int i = 0; i <= 8; ++i) {
    from_[0] = 0.1 * (i - 8);
    ASSERT_EQ(settle(planner), Path::kStraight);
  }
  see(planner, {0.75});  // on the arm itself
  MotionGuide::Aim guidance = planner.guide(from_, still_, to_);
  EXPECT_EQ(guidance.path, Path::kAround);
  EXPECT_LT(guidance.q[0], 0.0) << "not on towards the goal";
  from_[0] = -0.4;
  EXPECT_EQ(settle(planner), Path::kAround);
}

TEST_F(SensedPlannerTest, StaysWhenBlockedFromTheStart) {
  SensedPlanner planner = this->planner(Remember::kAlways);
  from_[0] = 0.0;
  see(planner, {0.75});
  EXPECT_EQ(step(planner), Path::kNone);
}

// Looked at in other places, a line in sight may not be one on which the arm is let go: it must not stand there for
// ever.
TEST_F(SensedPlannerTest, RefusedMotionContinuesFromRestToRest) {
  SensedPlanner planner = this->planner(Remember::kAlways);
  see(planner, {0.75});
  ASSERT_EQ(settle(planner), Path::kAround);
  const int searches = planner.searches();
  bool left = false;
  for (int period = 0; period < 50 && !left; ++period) left = step(planner) == Path::kSearching;
  ASSERT_TRUE(left) << "it rests away from its target";
  ASSERT_EQ(settle(planner), Path::kAround);
  EXPECT_EQ(planner.searches(), searches + 1);
  // The careful path begins in the arm's own cell. The arm waits there.
  for (int period = 0; period < 50; ++period) {
    const MotionGuide::Aim guidance = planner.guide(from_, still_, to_);
    EXPECT_EQ(guidance.path, Path::kAround);
    EXPECT_EQ(planner.map().cell_at(guidance.q), planner.map().cell_at(from_));
  }
  EXPECT_EQ(planner.searches(), searches + 1);
}

TEST_F(SensedPlannerTest, ExplainsWhyThereIsNoPath) {
  SensedPlanner planner = this->planner(Remember::kAlways);
  EXPECT_EQ(settle(planner), Path::kStraight);
  EXPECT_EQ(planner.no_path_reason(from_), std::nullopt);
  see(planner, {0.3});
  ASSERT_EQ(settle(planner), Path::kNone);
  EXPECT_EQ(planner.no_path_reason(from_), "the known obstacles leave no path to the goal");

  SensedPlanner near_goal = this->planner(Remember::kAlways);
  see(near_goal, {0.75});
  to_ = Eigen::Vector2d(0.0, 0.0);
  ASSERT_EQ(settle(near_goal), Path::kNone);
  EXPECT_TRUE(near_goal.no_path_reason(from_).value_or("").starts_with("its goal is nearer to a known obstacle"));
  from_ = Eigen::Vector2d(0.01, 0.0);
  SensedPlanner near = this->planner(Remember::kAlways);
  see(near, {0.75});
  ASSERT_EQ(settle(near), Path::kNone);
  EXPECT_TRUE(near.no_path_reason(from_).value_or("").starts_with("the arm's position is nearer to a known obstacle"));
}

// At a limit, the centre of the first cell is outside: an arm that moves to it would stand at the limit forever.
TEST_F(SensedPlannerTest, StopsOnAPathStayWithinTheLimits) {
  arm_.limits.lower[0] = -0.801;  // 0.002 inside the cell's centre
  SensedPlanner planner = this->planner(Remember::kAlways);
  see(planner, {0.75});
  ASSERT_EQ(settle(planner), Path::kAround);
  while (from_[0] < 0.0) from_ = planner.guide(from_, still_, to_).q;
  from_ = Eigen::Vector2d(-0.8, 0.8);  // the way is out of sight: it goes on from rest to rest
  ASSERT_EQ(step(planner), Path::kSearching);
  for (int period = 0; period < 20'000 && from_ != to_; ++period) {
    const JointVector q = planner.guide(from_, still_, to_).q;
    ASSERT_GE(q[0], arm_.limits.lower[0]);
    from_ = q;
  }
  EXPECT_EQ(from_, to_);
}

class SensedPlannerInSpace : public testing::Test {
 protected:
  SensedPlannerInSpace() {
    arm_.model = load_urdf(std::string(HECATON_SOURCE_DIR) + "/deploy/cells/urdf/puma560_3dof.urdf");
    arm_.limits = arm_.model->limits;
    arm_.limits.acceleration = Eigen::Vector3d(6.0, 6.0, 6.0);
  }

  [[nodiscard]] SensedPlanner planner(Remember remember) const {
    return SensedPlanner(arm_, {.cells = 180, .margin = 0.03, .remember = remember}, 0.02);
  }
  /// Points of one scan from a sensor on the base, from x = 0.5 on.
  void see(SensedPlanner& planner, int points, double first = 0.0) const {
    RangeScan scan{0, 0, q_, {}};
    for (int i = points; i > 0; --i) scan.readings.push_back({{}, 0.5 + first + 0.005 * i, true});
    planner.sense(scan);
  }

  Arm arm_;
  JointVector q_ = Eigen::Vector3d(-1.5, -1.9, 2.6);
  JointVector q_goal_ = Eigen::Vector3d(1.5, -1.0, 2.2);
  JointVector still_ = Eigen::Vector3d::Zero();
};

// A period's work is bounded, however much comes into sight at once; what is not mapped yet stops the arm.
TEST_F(SensedPlannerInSpace, MapsNearestPointsFirstAndWaits) {
  for (const Remember remember : {Remember::kAlways, Remember::kUntilNearer, Remember::kNever}) {
    SensedPlanner planner = this->planner(remember);
    (void)planner.guide(q_, still_, q_goal_);
    ASSERT_TRUE(planner.may_go(q_, q_, still_));
    constexpr int kPoints = 200;
    see(planner, kPoints);
    (void)planner.guide(q_, still_, q_goal_);
    const std::size_t first = planner.map().points().size();
    EXPECT_GT(first, 0U);
    EXPECT_LE(planner.mapped(), 4'096);
    EXPECT_DOUBLE_EQ(planner.map().points().front().x(), 0.505);
    EXPECT_FALSE(planner.may_go(q_, q_, still_));
    for (int period = 1; period < kPoints && !planner.may_go(q_, q_, still_); ++period) {
      const std::int64_t before = planner.mapped();
      (void)planner.guide(q_, still_, q_goal_);
      EXPECT_LE(planner.mapped() - before, 4'096);
    }
    EXPECT_EQ(planner.map().points().size(), static_cast<std::size_t>(kPoints));
  }
}

// Its map never holds less than it sees, and in the end no more.
TEST_F(SensedPlannerInSpace, ForgettingArmRemapsInShares) {
  constexpr std::size_t kPoints = 100;
  SensedPlanner planner = this->planner(Remember::kNever);
  see(planner, kPoints);
  for (int period = 0; period < 100; ++period) (void)planner.guide(q_, still_, q_goal_);
  ASSERT_EQ(planner.map().points().size(), kPoints);
  const double aside = 0.5 * 0.005 * kPoints;
  see(planner, kPoints, aside);  // half of them are the same
  int periods = 0;
  for (; planner.map().points().size() != kPoints || periods == 0; ++periods) {
    ASSERT_LT(periods, 100);
    const std::int64_t before = planner.mapped();
    (void)planner.guide(q_, still_, q_goal_);
    EXPECT_LE(planner.mapped() - before, 4'096);
    if (!planner.may_go(q_, q_, still_)) continue;
    for (std::size_t i = 1; i <= kPoints; ++i) {
      EXPECT_TRUE(planner.map().holds({0.5 + aside + 0.005 * static_cast<double>(i), 0.0, 0.0})) << i;
    }
  }
  EXPECT_GT(periods, 2) << "otherwise the test shows nothing";
  EXPECT_FALSE(planner.map().holds({0.505, 0.0, 0.0}));
}

}  // namespace
}  // namespace hecaton::planner::cspace
