#include "services/planner/progress_reporter.hpp"

#include <gtest/gtest.h>

#include "services/runtime/cause.hpp"
#include "tests/support/planar_point.hpp"

namespace hecaton::services {
namespace {

using planner::TickStatus;

class ProgressReporterTest : public testing::Test {
 protected:
  Progress progress_at(TickStatus status) {
    result_.status = status;
    return progress_of(result_, goal_progress_, geometry_, seen_, {}, hold_);
  }

  /// Two balls, 18 mm apart, are the binding pair.
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
  planner::ProgressMonitor goal_progress_;
};

TEST_F(ProgressReporterTest, NamesTheRecoveryAction) {
  EXPECT_EQ(progress_at(TickStatus::kMoving).recovery_action, "moves straight to the goal");
  EXPECT_EQ(progress_at(TickStatus::kDetouring).recovery_action, "makes a detour");
  EXPECT_EQ(progress_at(TickStatus::kFollowingRoute).recovery_action, "follows a route around the obstacle");
  result_.subspaces_drawn = 2;
  EXPECT_EQ(progress_at(TickStatus::kFollowingBoundary).recovery_action, "follows the boundary, in subspace 2");
  result_.yields_to = 1;
  EXPECT_EQ(progress_at(TickStatus::kYielding).recovery_action, "yields to arm right");
}

TEST_F(ProgressReporterTest, HasKindAndSubjectOfEveryCause) {
  EXPECT_EQ(progress_at(TickStatus::kMoving).cause.kind(), msg::CauseKind::CAUSE_NONE);
  EXPECT_EQ(progress_at(TickStatus::kHolding).cause, hold_);
  EXPECT_EQ(progress_at(TickStatus::kFollowingBoundary).cause.kind(), msg::CauseKind::CAUSE_AT_JOINT_LIMITS);
  result_.yields_to = 1;
  EXPECT_EQ(progress_at(TickStatus::kYielding).cause.kind(), msg::CauseKind::CAUSE_GIVING_WAY);
  EXPECT_EQ(progress_at(TickStatus::kYielding).cause.subject(), "right");
  result_.stale_arm = 1;
  EXPECT_EQ(progress_at(TickStatus::kStaleInput).cause.kind(), msg::CauseKind::CAUSE_ARM_STATE_OLD);
  EXPECT_EQ(progress_at(TickStatus::kStaleInput).cause.subject(), "right");
  result_.stale_arm = -2;
  EXPECT_EQ(progress_at(TickStatus::kStaleInput).cause.kind(), msg::CauseKind::CAUSE_OBSTACLES_OLD);
  bind();
  EXPECT_EQ(progress_at(TickStatus::kBlocked).cause.kind(), msg::CauseKind::CAUSE_PATH_BLOCKED);
  EXPECT_EQ(progress_at(TickStatus::kBlocked).cause.subject(), "right/ball");
}

TEST_F(ProgressReporterTest, IsHeldBackUnlessItMovesFreely) {
  result_.yields_to = 1;
  EXPECT_FALSE(progress_at(TickStatus::kMoving).obstructed);
  EXPECT_FALSE(progress_at(TickStatus::kFollowingRoute).obstructed);
  EXPECT_FALSE(progress_at(TickStatus::kReached).obstructed);
  EXPECT_FALSE(progress_at(TickStatus::kHolding).obstructed) << "held by an order";
  for (const TickStatus status :
       {TickStatus::kFollowingBoundary, TickStatus::kDetouring, TickStatus::kYielding, TickStatus::kBlocked}) {
    EXPECT_TRUE(progress_at(status).obstructed) << static_cast<int>(status);
  }
}

TEST_F(ProgressReporterTest, HasTheBindingPairAndItsDistance) {
  bind();
  const Progress progress = progress_at(TickStatus::kBlocked);
  EXPECT_EQ(progress.state, msg::GoalState::GOAL_BLOCKED);
  EXPECT_EQ(progress.binding_own, "left/ball");
  EXPECT_EQ(progress.binding_other, "right/ball");
  EXPECT_EQ(progress.binding_distance, 0.018);
  EXPECT_EQ(progress.cause.text(), "no progress: left/ball – right/ball, 18 mm");
}

TEST_F(ProgressReporterTest, IsHeldBackWithABindingPair) {
  bind();
  EXPECT_TRUE(progress_at(TickStatus::kMoving).obstructed);
}

TEST_F(ProgressReporterTest, NamesTheJointLimitsWithoutABindingPair) {
  EXPECT_EQ(progress_at(TickStatus::kFollowingBoundary).cause.text(), "at its joint limits");
  bind();
  EXPECT_EQ(progress_at(TickStatus::kFollowingBoundary).cause.text(), "");
}

TEST_F(ProgressReporterTest, NamesThePairThatBoundedItLastAtTheLimitsOfAPathTolerance) {
  LastBinding last;
  const auto text = [&](TickStatus status, bool path_bound = true) {
    Progress progress = progress_at(status);
    last.update(path_bound, progress);
    return progress.cause.text();
  };
  EXPECT_EQ(text(TickStatus::kFollowingBoundary), "at its joint limits, or those of its path tolerance");
  bind();
  EXPECT_EQ(text(TickStatus::kFollowingBoundary), "");
  result_.has_binding = false;
  EXPECT_EQ(text(TickStatus::kFollowingBoundary),
            "at the limits of its path tolerance: left/ball was 0.018 m from right/ball");
  EXPECT_EQ(text(TickStatus::kFollowingBoundary, false), "at its joint limits") << "without a path tolerance";
  EXPECT_EQ(text(TickStatus::kMoving), "") << "it moves freely";
  EXPECT_EQ(text(TickStatus::kFollowingBoundary), "at its joint limits, or those of its path tolerance");
}

TEST_F(ProgressReporterTest, IsBlockedAfterTheStallTimeout) {
  for (int second = 0; second <= 10; ++second) {
    EXPECT_EQ(progress_at(TickStatus::kFollowingBoundary).state, msg::GoalState::GOAL_ACTIVE) << second;
    goal_progress_.note(1.0, 1.0);
  }
  goal_progress_.note(0.99, 1.0);
  EXPECT_EQ(progress_at(TickStatus::kFollowingBoundary).state, msg::GoalState::GOAL_BLOCKED);
  EXPECT_EQ(progress_at(TickStatus::kFollowingBoundary).cause.text(), "no path found for 11 s");
  EXPECT_TRUE(progress_at(TickStatus::kMoving).obstructed) << "a short free motion";
  goal_progress_.note(0.5, 1.0);
  EXPECT_EQ(progress_at(TickStatus::kFollowingBoundary).state, msg::GoalState::GOAL_ACTIVE);
}

TEST_F(ProgressReporterTest, NamesALostArm) {
  EXPECT_EQ(progress_at(TickStatus::kBlocked).cause.text(), "no progress within the joint limits");
  seen_[1].position_uncertainty = test::joints({0.1, 0.1});
  EXPECT_EQ(progress_at(TickStatus::kMoving).cause.text(), "");
  EXPECT_EQ(progress_at(TickStatus::kBlocked).cause.text(), "no progress; arm right was lost and may be nearer");
  bind();
  EXPECT_EQ(progress_at(TickStatus::kMoving).cause.text(), "arm right was lost and may be nearer");
  EXPECT_EQ(progress_at(TickStatus::kBlocked).cause.text(),
            "no progress: left/ball – right/ball, 18 mm; arm right was lost and may be nearer");
}

class Arrival : public testing::Test {
 protected:
  /// Periods of 0.1 s.
  const Progress& judged(bool set_point_there, const std::optional<std::string>& error, int periods = 1) {
    for (int i = 0; i < periods; ++i) {
      progress_ = Progress();
      check_.judge(set_point_there, error, "left", 0.1, progress_);
    }
    return progress_;
  }

  ArrivalCheck check_;
  Progress progress_;
};

TEST_F(Arrival, ReachesTheGoalWhenSetPointAndMeasuredPositionAreThere) {
  EXPECT_EQ(judged(false, std::nullopt).state, msg::GoalState::GOAL_ACTIVE);
  EXPECT_EQ(judged(true, "the tool is 2 mm away", 3).state, msg::GoalState::GOAL_ACTIVE);
  EXPECT_EQ(judged(true, std::nullopt).state, msg::GoalState::GOAL_REACHED);
}

TEST_F(Arrival, IsBlockedWhenTheDriveStaysAwayForASecond) {
  EXPECT_EQ(judged(true, "the tool is 2 mm away", 9).state, msg::GoalState::GOAL_ACTIVE);
  EXPECT_TRUE(is_none(progress_.cause));
  EXPECT_EQ(judged(true, "the tool is 2 mm away", 2).state, msg::GoalState::GOAL_BLOCKED);
  EXPECT_EQ(progress_.cause.kind(), msg::CauseKind::CAUSE_DEVICE_DOES_NOT_FOLLOW);
  EXPECT_EQ(progress_.cause.text(), "the drive does not follow: the tool is 2 mm away");
  EXPECT_EQ(judged(false, std::nullopt).state, msg::GoalState::GOAL_ACTIVE);
  EXPECT_EQ(judged(true, "the tool is 2 mm away", 9).state, msg::GoalState::GOAL_ACTIVE) << "counts from 0 again";
}

}  // namespace
}  // namespace hecaton::services
