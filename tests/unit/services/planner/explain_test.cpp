#include "services/planner/explain.hpp"

#include <gtest/gtest.h>

#include "services/runtime/cause.hpp"
#include "tests/support/planar_point.hpp"

namespace hecaton::services {
namespace {

using planner::TickStatus;

class ExplainTest : public testing::Test {
 protected:
  Progress told(TickStatus status) {
    result_.status = status;
    return explain(result_, approach_, geometry_, seen_, {}, hold_);
  }

  /// The two balls, 18 mm apart, hold it back.
  void bind() {
    result_.has_binding = true;
    result_.binding.counterpart = planner::Counterpart::kArm;
    result_.binding.other = 1;
    result_.binding.own_link = result_.binding.other_link = 2;
    result_.binding.distance = 0.018;
  }

  const msg::Cause hold_ = make_cause(msg::CauseKind::CAUSE_HOLD_ORDERED, "left", "the cell is on hold");
  planner::CellGeometry geometry_{{test::planar_point("left"), test::planar_point("right")}, 0};
  std::array<planner::ArmObservation, 2> seen_;
  planner::TickResult result_;
  planner::Approach approach_;
};

TEST_F(ExplainTest, WhatIsTriedHasAName) {
  EXPECT_EQ(told(TickStatus::kMoving).recovery_action, "goes straight to the goal");
  EXPECT_EQ(told(TickStatus::kDetouring).recovery_action, "makes a detour");
  EXPECT_EQ(told(TickStatus::kRouted).recovery_action, "goes by a route around what stands in its way");
  result_.redraws = 2;
  EXPECT_EQ(told(TickStatus::kFollowing).recovery_action, "follows the boundary, in subspace 2");
  result_.yields_to = 1;
  EXPECT_EQ(told(TickStatus::kYielding).recovery_action, "makes room for arm right");
}

TEST_F(ExplainTest, EveryStandstillHasAKindAndASubject) {
  EXPECT_EQ(told(TickStatus::kMoving).cause.kind(), msg::CauseKind::CAUSE_NONE);
  EXPECT_EQ(told(TickStatus::kHolding).cause, hold_);
  EXPECT_EQ(told(TickStatus::kFollowing).cause.kind(), msg::CauseKind::CAUSE_AT_JOINT_LIMITS);
  result_.yields_to = 1;
  EXPECT_EQ(told(TickStatus::kYielding).cause.kind(), msg::CauseKind::CAUSE_GIVING_WAY);
  EXPECT_EQ(told(TickStatus::kYielding).cause.subject(), "right");
  result_.stale_arm = 1;
  EXPECT_EQ(told(TickStatus::kStaleInput).cause.kind(), msg::CauseKind::CAUSE_ARM_STATE_OLD);
  EXPECT_EQ(told(TickStatus::kStaleInput).cause.subject(), "right");
  result_.stale_arm = -2;
  EXPECT_EQ(told(TickStatus::kStaleInput).cause.kind(), msg::CauseKind::CAUSE_OBSTACLES_OLD);
  bind();
  EXPECT_EQ(told(TickStatus::kBlocked).cause.kind(), msg::CauseKind::CAUSE_WAY_BLOCKED);
  EXPECT_EQ(told(TickStatus::kBlocked).cause.subject(), "right/ball");
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
  EXPECT_EQ(progress.cause.text(), "no progress: left/ball – right/ball, 18 mm");
}

TEST_F(ExplainTest, WhoIsLetGoOnlySlowlyIsHeldBackToo) {
  bind();
  EXPECT_TRUE(told(TickStatus::kMoving).held_back);
}

TEST_F(ExplainTest, ABoundaryIsAPairOrTheJointLimits) {
  EXPECT_EQ(told(TickStatus::kFollowing).cause.text(), "at its joint limits");
  bind();
  EXPECT_EQ(told(TickStatus::kFollowing).cause.text(), "");
}

TEST_F(ExplainTest, WhoWalksForLongWithoutComingNearerIsBlocked) {
  for (int second = 0; second <= 10; ++second) {
    EXPECT_EQ(told(TickStatus::kFollowing).state, msg::GoalState::GOAL_ACTIVE) << second;
    approach_.note(1.0, 1.0);
  }
  approach_.note(0.99, 1.0);
  EXPECT_EQ(told(TickStatus::kFollowing).state, msg::GoalState::GOAL_BLOCKED);
  EXPECT_EQ(told(TickStatus::kFollowing).cause.text(), "no way found for 11 s");
  EXPECT_TRUE(told(TickStatus::kMoving).held_back) << "a free stretch on the way back";
  approach_.note(0.5, 1.0);
  EXPECT_EQ(told(TickStatus::kFollowing).state, msg::GoalState::GOAL_ACTIVE);
}

TEST_F(ExplainTest, ALostArmMayBeNearerThanItWasHeard) {
  EXPECT_EQ(told(TickStatus::kBlocked).cause.text(), "no progress within the joint limits");
  seen_[1].stray = test::joints({0.1, 0.1});
  EXPECT_EQ(told(TickStatus::kMoving).cause.text(), "");
  EXPECT_EQ(told(TickStatus::kBlocked).cause.text(), "no progress; arm right was lost and may be nearer");
  bind();
  EXPECT_EQ(told(TickStatus::kMoving).cause.text(), "arm right was lost and may be nearer");
  EXPECT_EQ(told(TickStatus::kBlocked).cause.text(),
            "no progress: left/ball – right/ball, 18 mm; arm right was lost and may be nearer");
}

}  // namespace
}  // namespace hecaton::services
