#include "planner/cspace/sensed_planner.hpp"

#include <gtest/gtest.h>

#include "planner/model/urdf_loader.hpp"

namespace hecaton::planner::cspace {
namespace {

using Way = SensedPlanner::Way;

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
  [[nodiscard]] Way step(SensedPlanner& planner) const { return planner.guide(from_, still_, to_).way; }
  /// What it comes to once it no longer searches.
  [[nodiscard]] Way settle(SensedPlanner& planner) const {
    for (int period = 0; period < 2000; ++period) {
      if (const Way way = step(planner); way != Way::kSearching) return way;
    }
    return Way::kSearching;
  }

  Arm arm_;
  JointVector from_ = Eigen::Vector2d(-0.8, 0.0);
  JointVector to_ = Eigen::Vector2d(0.8, 0.0);
  JointVector still_ = Eigen::Vector2d(0.0, 0.0);
};

TEST_F(SensedPlannerTest, GoesStraightUntilItSeesSomething) {
  SensedPlanner planner = this->planner(Remember::kAlways);
  EXPECT_EQ(settle(planner), Way::kStraight);
  see(planner, {0.75});
  EXPECT_EQ(settle(planner), Way::kAround);
  EXPECT_EQ(planner.searches(), 2);
}

TEST_F(SensedPlannerTest, SearchesAgainOnlyWhenTheWayIsBlocked) {
  SensedPlanner planner = this->planner(Remember::kAlways);
  see(planner, {0.75});
  ASSERT_EQ(settle(planner), Way::kAround);
  see(planner, {0.95});  // the way is folded past it
  ASSERT_EQ(settle(planner), Way::kAround);
  EXPECT_EQ(planner.searches(), 1);
}

// Noise changes the map in every period of a search that takes several.
TEST_F(SensedPlannerTest, EndsASearchWhileItSeesMore) {
  for (const Remember remember : {Remember::kNever, Remember::kUntilNearer, Remember::kAlways}) {
    SensedPlanner planner = this->planner(remember, 1440);
    Way way = Way::kSearching;
    int searching = 0;
    for (int period = 0; period < 2000 && way == Way::kSearching; ++period) {
      see(planner, {period % 2 == 0 ? 0.75 : 0.757});
      way = step(planner);
      searching += way == Way::kSearching ? 1 : 0;
    }
    EXPECT_EQ(way, Way::kAround);
    EXPECT_GT(searching, 2) << "otherwise the test shows nothing";
  }
}

TEST_F(SensedPlannerTest, WhoForgetsFindsTheWayThatHasBecomeFree) {
  for (const Remember remember : {Remember::kNever, Remember::kAlways}) {
    SensedPlanner planner = this->planner(remember);
    see(planner, {0.3});  // stops the first link
    ASSERT_EQ(settle(planner), Way::kNone);
    see(planner, {});
    EXPECT_EQ(settle(planner), remember == Remember::kNever ? Way::kStraight : Way::kNone);
  }
}

// A detour ends where the goal is in sight and nearer than where it began by a cell: not before.
TEST_F(SensedPlannerTest, RemembersADetourUntilItIsNearer) {
  SensedPlanner planner = this->planner(Remember::kUntilNearer);
  see(planner, {0.75});
  ASSERT_EQ(settle(planner), Way::kAround);
  see(planner, {});
  EXPECT_EQ(settle(planner), Way::kAround) << "remembered";
  from_ = Eigen::Vector2d(0.6, 0.0);  // past it
  EXPECT_EQ(settle(planner), Way::kStraight);
  see(planner, {});
  (void)step(planner);
  EXPECT_TRUE(planner.map().points().empty()) << "forgotten";
}

TEST_F(SensedPlannerTest, MayOnlyGoWhereItCanStop) {
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

TEST_F(SensedPlannerTest, GoesBackTheWayItCame) {
  SensedPlanner planner = this->planner(Remember::kAlways);
  for (int i = 0; i <= 8; ++i) {
    from_[0] = 0.1 * (i - 8);
    ASSERT_EQ(settle(planner), Way::kStraight);
  }
  see(planner, {0.75});  // on the arm itself
  SensedPlanner::Guidance guidance = planner.guide(from_, still_, to_);
  EXPECT_EQ(guidance.way, Way::kAround);
  EXPECT_LT(guidance.q[0], 0.0) << "not on towards the goal";
  from_[0] = -0.4;
  EXPECT_EQ(settle(planner), Way::kAround);
}

TEST_F(SensedPlannerTest, StaysWhereItIsBlockedFromTheStart) {
  SensedPlanner planner = this->planner(Remember::kAlways);
  from_[0] = 0.0;
  see(planner, {0.75});
  EXPECT_EQ(step(planner), Way::kNone);
}

}  // namespace
}  // namespace hecaton::planner::cspace
