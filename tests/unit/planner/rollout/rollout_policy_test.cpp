// Conditions and horizons of questions.
#include "planner/rollout/rollout_policy.hpp"

#include <array>
#include <optional>

#include <gtest/gtest.h>

#include "planner/methods/registry.hpp"
#include "tests/support/planar_point.hpp"

namespace hecaton::planner {
namespace {

using test::joints;

class Policy : public testing::Test {
 protected:
  Policy()
      : controller_(CellGeometry({test::planar_point("a"), test::planar_point("b")}, 0), LocalParameters{}, 0.01, 1) {
    arms_[1] = {joints({2, 2}), joints({0.5, 0}), 0.1, true, true, true, joints({2.5, 2})};
    controller_.set_goal(joints({1, 0}));
    (void)controller_.step(MeasuredState{joints({0, 0}), joints({0, 0})}, arms_, {}, false);
    parameters_.rollout.candidates = 4;
    parameters_.rollout.horizon = 2.0;
    parameters_.rollout.horizon_growth = 2.0;
    parameters_.rollout.longest_horizon = 6.0;
    parameters_.rollout.interval = 0.095;
  }

  static TickResult status(TickStatus status) {
    TickResult result;
    result.status = status;
    return result;
  }
  /// Periods until the next question, which is left open; −1: none within 100.
  int periods_until_question(RolloutPolicy& policy, TickStatus trouble, RolloutQuestion& question) {
    for (int k = 1; k <= 100; ++k) {
      if (auto next = policy.next(controller_, status(trouble), arms_, {})) {
        question = std::move(*next);
        return k;
      }
    }
    return -1;
  }

  std::array<ArmObservation, 2> arms_{};
  ArmController controller_;
  LocalParameters parameters_;
  RolloutQuestion question_;
};

TEST_F(Policy, AsksOnlyWhenBlocked) {
  RolloutPolicy policy(parameters_, 1);
  EXPECT_EQ(periods_until_question(policy, TickStatus::kMoving, question_), -1);
  EXPECT_EQ(periods_until_question(policy, TickStatus::kFollowingBoundary, question_), 1);
}

TEST_F(Policy, BlockedArmWaitsWhenAnAnswerCanCome) {
  RolloutPolicy policy(parameters_, 1);
  ASSERT_TRUE(policy.rollout_wait());
  EXPECT_GT(*policy.rollout_wait(), 0.1);
  controller_.wait_for_rollout(*policy.rollout_wait());
  TickResult thinking = status(TickStatus::kMoving);
  thinking.awaiting_rollout = true;
  const auto asked = policy.next(controller_, thinking, arms_, {});
  ASSERT_TRUE(asked.has_value());
  EXPECT_EQ(asked->arms[0].memory.rollout_wait, 0.0) << "to go on is to turn aside at once";
  controller_.begin({});
  EXPECT_EQ(controller_.memory().rollout_wait, 0.0);
  EXPECT_FALSE(policy.rollout_wait()) << "a question is open";
  policy.answered();
  EXPECT_FALSE(policy.rollout_wait()) << "it is too soon for another one";
}

TEST_F(Policy, AsksOneQuestionAtATimeAndThenWaits) {
  RolloutPolicy policy(parameters_, 1);
  ASSERT_EQ(periods_until_question(policy, TickStatus::kBlocked, question_), 1);
  EXPECT_EQ(periods_until_question(policy, TickStatus::kBlocked, question_), -1);
  policy.answered();
  EXPECT_EQ(periods_until_question(policy, TickStatus::kBlocked, question_), 10);  // 95 ms of 10 ms
}

TEST_F(Policy, HorizonGrowsUntilTheArmIsFree) {
  RolloutPolicy policy(parameters_, 1);
  for (const double horizon : {2.0, 4.0, 6.0, 6.0}) {
    ASSERT_GT(periods_until_question(policy, TickStatus::kFollowingBoundary, question_), 0);
    EXPECT_DOUBLE_EQ(question_.horizon, horizon);
    policy.answered();
  }
  EXPECT_EQ(periods_until_question(policy, TickStatus::kMoving, question_), -1);  // 1 s of free motion
  ASSERT_GT(periods_until_question(policy, TickStatus::kFollowingBoundary, question_), 0);
  EXPECT_DOUBLE_EQ(question_.horizon, 2.0);
}

TEST_F(Policy, QuestionHoldsThePresentCell) {
  RolloutPolicy policy(parameters_, 1);
  ASSERT_EQ(periods_until_question(policy, TickStatus::kFollowingBoundary, question_), 1);
  ASSERT_EQ(question_.arms.size(), 2U);
  EXPECT_EQ(question_.arms[0].q, controller_.setpoint().q);
  EXPECT_EQ(question_.arms[0].q_goal, joints({1, 0}));
  EXPECT_DOUBLE_EQ(question_.arms[1].q[0], 2.05);  // 0.1 s old, 0.5 m/s
  EXPECT_EQ(question_.arms[1].q_goal, joints({2.5, 2}));
  EXPECT_EQ(question_.candidates, 4);
}

TEST_F(Policy, AsksNothingWithoutCandidatesOrWithAnUnknownArm) {
  parameters_.rollout.candidates = 0;
  RolloutPolicy none(parameters_, 1);
  EXPECT_EQ(periods_until_question(none, TickStatus::kBlocked, question_), -1);
  parameters_.rollout.candidates = 4;
  parameters_.method = built_in_method("local");
  RolloutPolicy constraints_alone(parameters_, 1);
  EXPECT_EQ(periods_until_question(constraints_alone, TickStatus::kBlocked, question_), -1);
  parameters_.method = built_in_method("boundary_following");
  RolloutPolicy policy(parameters_, 1);
  arms_[1].known = false;
  EXPECT_EQ(periods_until_question(policy, TickStatus::kBlocked, question_), -1);
}

/// A box in reach of arm `a`, which reaches 3 m along both axes.
class PolicyBesideABox : public Policy {
 protected:
  PolicyBesideABox() : box_(test::box_obstacle("box", {0, 7, 0}, {0.1, 0.1, 0.1})) {
    controller_.set_obstacles(std::array{box_});
    state_ = {box_.X_WO, {}, 0.0};
    state_.velocity.linear = {0, -1, 0};
  }
  std::optional<RolloutQuestion> next(RolloutPolicy& policy, TickStatus now = TickStatus::kMoving) {
    return policy.next(controller_, status(now), arms_, std::array{state_});
  }

  world::Obstacle box_;
  world::ObstacleState state_;
};

TEST_F(PolicyBesideABox, LooksAheadRepeatedlyWhileTheBoxApproaches) {
  RolloutPolicy policy(parameters_, 1);
  const auto asked = next(policy);
  ASSERT_TRUE(asked.has_value());
  EXPECT_TRUE(asked->lookahead);
  EXPECT_FALSE(policy.awaiting_rollout()) << "nothing holds it back";
  EXPECT_FALSE(next(policy)) << "a question is open";
  policy.answered();
  int periods = 1;
  while (!next(policy)) ++periods;
  EXPECT_GE(periods, 9);
  EXPECT_LE(periods, 31);
}

TEST_F(PolicyBesideABox, IgnoresAStaticOrLeavingOrDistantBox) {
  RolloutPolicy policy(parameters_, 1);
  state_.velocity.linear = {0, 0, 0};
  EXPECT_FALSE(next(policy));
  state_.velocity.linear = {0, 1, 0};
  EXPECT_FALSE(next(policy));
  state_.velocity.linear = {0, -1, 0};
  state_.X_WO.translation().y() = 20.0;
  EXPECT_FALSE(next(policy));
}

TEST_F(PolicyBesideABox, LooksAheadForABoxThatOnlyTurnsWithinReach) {
  RolloutPolicy policy(parameters_, 1);
  box_.shapes[0].X_BS.translation().x() = 1.0;
  controller_.set_obstacles(std::array{box_});
  state_.X_WO.translation().y() = 2.0;
  state_.velocity = {};
  EXPECT_FALSE(next(policy));
  state_.velocity.angular = {0, 0, 1};
  EXPECT_TRUE(next(policy));
}

TEST_F(PolicyBesideABox, LooksAheadWithoutAGoalButNotWhenHeld) {
  RolloutPolicy policy(parameters_, 1);
  controller_.cancel_goal();
  EXPECT_FALSE(next(policy, TickStatus::kHolding));
  EXPECT_FALSE(next(policy, TickStatus::kStaleInput));
  const auto asked = next(policy, TickStatus::kIdle);
  ASSERT_TRUE(asked.has_value());
  EXPECT_FALSE(asked->arms[0].has_goal);
  EXPECT_TRUE(asked->arms[0].plans);
}

TEST_F(PolicyBesideABox, LooksAheadBeforeItSearchesManoeuvres) {
  RolloutPolicy policy(parameters_, 1);
  const auto asked = next(policy, TickStatus::kFollowingBoundary);
  ASSERT_TRUE(asked.has_value());
  EXPECT_TRUE(asked->lookahead);
  EXPECT_FALSE(policy.awaiting_rollout());
  policy.answered();
  const auto then = next(policy, TickStatus::kFollowingBoundary);
  ASSERT_TRUE(then.has_value()) << "it is too soon for another of those";
  EXPECT_FALSE(then->lookahead);
  EXPECT_TRUE(policy.awaiting_rollout());
}

TEST_F(PolicyBesideABox, DoesNotLookAheadWithoutCandidates) {
  parameters_.rollout.candidates = 0;
  RolloutPolicy policy(parameters_, 1);
  EXPECT_FALSE(next(policy));
}

}  // namespace
}  // namespace hecaton::planner
