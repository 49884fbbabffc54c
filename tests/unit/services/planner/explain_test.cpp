#include "services/planner/explain.hpp"

#include <gtest/gtest.h>

#include "tests/support/planar_point.hpp"

namespace hecaton::services {
namespace {

using planner::TickStatus;

class ExplainTest : public testing::Test {
 protected:
  Progress told(TickStatus status) {
    result_.status = status;
    return explain(result_, approach_, geometry_, seen_, {}, "the cell is on hold");
  }

  /// The two balls, 18 mm apart, hold it back.
  void bind() {
    result_.has_binding = true;
    result_.binding.counterpart = planner::Counterpart::kArm;
    result_.binding.other = 1;
    result_.binding.own_link = result_.binding.other_link = 2;
    result_.binding.distance = 0.018;
  }

  planner::CellGeometry geometry_{{test::planar_point("left"), test::planar_point("right")}, 0};
  std::array<planner::ArmObservation, 2> seen_;
  planner::TickResult result_;
  planner::Approach approach_;
};

TEST_F(ExplainTest, WhatIsTriedHasAName) {
  EXPECT_EQ(told(TickStatus::kMoving).trying, "goes straight to the goal");
  EXPECT_EQ(told(TickStatus::kDetouring).trying, "makes a detour");
  EXPECT_EQ(told(TickStatus::kRouted).trying, "goes by a route around what stands in its way");
  result_.redraws = 2;
  EXPECT_EQ(told(TickStatus::kFollowing).trying, "follows the boundary, in subspace 2");
  result_.yields_to = 1;
  EXPECT_EQ(told(TickStatus::kYielding).trying, "makes room for arm right");
}

TEST_F(ExplainTest, OnlyWhoGoesFreelyIsNotHeldBack) {
  result_.yields_to = 1;
  EXPECT_FALSE(told(TickStatus::kMoving).held_back);
  EXPECT_FALSE(told(TickStatus::kRouted).held_back);
  EXPECT_FALSE(told(TickStatus::kReached).held_back);
  EXPECT_FALSE(told(TickStatus::kHolding).held_back) << "it is told to, nothing is in its way";
  for (const TickStatus status :
       {TickStatus::kFollowing, TickStatus::kDetouring, TickStatus::kYielding, TickStatus::kBlocked}) {
    EXPECT_TRUE(told(status).held_back) << static_cast<int>(status);
  }
}

TEST_F(ExplainTest, WhatBindsIsAPairAndItsDistance) {
  bind();
  const Progress progress = told(TickStatus::kBlocked);
  EXPECT_EQ(progress.state, msg::GoalState::GOAL_BLOCKED);
  EXPECT_EQ(progress.binding_own, "left/ball");
  EXPECT_EQ(progress.binding_other, "right/ball");
  EXPECT_EQ(progress.binding_distance, 0.018);
  EXPECT_EQ(progress.reason, "no progress: left/ball – right/ball, 18 mm");
}

TEST_F(ExplainTest, WhoIsLetGoOnlySlowlyIsHeldBackToo) {
  bind();
  EXPECT_TRUE(told(TickStatus::kMoving).held_back);
}

TEST_F(ExplainTest, ABoundaryIsAPairOrTheJointLimits) {
  EXPECT_EQ(told(TickStatus::kFollowing).reason, "at its joint limits");
  bind();
  EXPECT_EQ(told(TickStatus::kFollowing).reason, "");
}

TEST_F(ExplainTest, WhoWalksForLongWithoutComingNearerIsBlocked) {
  for (int second = 0; second <= 10; ++second) {
    EXPECT_EQ(told(TickStatus::kFollowing).state, msg::GoalState::GOAL_ACTIVE) << second;
    approach_.note(1.0, 1.0);
  }
  approach_.note(0.99, 1.0);
  EXPECT_EQ(told(TickStatus::kFollowing).state, msg::GoalState::GOAL_BLOCKED);
  EXPECT_EQ(told(TickStatus::kFollowing).reason, "no way found for 11 s");
  EXPECT_TRUE(told(TickStatus::kMoving).held_back) << "a free stretch on the way back";
  approach_.note(0.5, 1.0);
  EXPECT_EQ(told(TickStatus::kFollowing).state, msg::GoalState::GOAL_ACTIVE);
}

TEST_F(ExplainTest, ALostArmMayBeNearerThanItWasHeard) {
  EXPECT_EQ(told(TickStatus::kBlocked).reason, "no progress within the joint limits");
  seen_[1].stray = test::joints({0.1, 0.1});
  EXPECT_EQ(told(TickStatus::kMoving).reason, "");
  EXPECT_EQ(told(TickStatus::kBlocked).reason, "no progress; arm right was lost and may be nearer");
  bind();
  EXPECT_EQ(told(TickStatus::kMoving).reason, "arm right was lost and may be nearer");
  EXPECT_EQ(told(TickStatus::kBlocked).reason,
            "no progress: left/ball – right/ball, 18 mm; arm right was lost and may be nearer");
}

}  // namespace
}  // namespace hecaton::services
