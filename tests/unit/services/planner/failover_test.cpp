// What makes a planner stand by and take over, without a network.

#include "services/planner/failover.hpp"

#include <chrono>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

namespace hecaton::services {
namespace {

TEST(DutyOfAPlanner, BeginsWithTheFirstCellModeThatNamesIt) {
  Duty duty("p", true);
  EXPECT_FALSE(duty.in_charge());
  duty.hear({});
  EXPECT_FALSE(duty.in_charge());
  duty.hear({"p", 4});
  EXPECT_TRUE(duty.in_charge());
  EXPECT_EQ(duty.term(), 4U);
  duty.hear({"q", 6});
  EXPECT_FALSE(duty.in_charge());
  duty.hear({"p", 4});
  EXPECT_FALSE(duty.in_charge()) << "old news";
}

TEST(DutyOfAPlanner, WithoutAStandbyTheCellsTermIsEnough) {
  Duty only("p", true);
  only.hear({{}, 2});
  EXPECT_TRUE(only.in_charge());
  Duty second("q", false);
  second.hear({{}, 2});
  EXPECT_FALSE(second.in_charge());
}

TEST(DutyOfAPlanner, EndsWhenTheDriverGoesByAnother) {
  Duty duty("p", true);
  duty.hear({"p", 4});
  duty.hear_driver({{}, 4});
  EXPECT_TRUE(duty.in_charge()) << "nobody has commanded under it yet";
  duty.hear_driver({"q", 4});
  EXPECT_FALSE(duty.in_charge());
  duty.hear({"p", 5});
  EXPECT_TRUE(duty.in_charge());
}

msg::GoalStatus status(const std::string& goal, msg::GoalState state) {
  msg::GoalStatus message;
  message.goal(goal);
  message.state(state);
  return message;
}

TEST(UnpublishedEndsOfAStandby, IsWhatThePlannerInChargeDidNotLiveToTell) {
  UnpublishedEnds unpublished;
  unpublished.keep({status("a", msg::GoalState::GOAL_ACTIVE), status("a", msg::GoalState::GOAL_REACHED),
                    status("b", msg::GoalState::GOAL_REJECTED)});
  unpublished.heard(status("a", msg::GoalState::GOAL_ACTIVE));
  unpublished.heard(status("b", msg::GoalState::GOAL_REJECTED));
  const auto left = unpublished.take();
  ASSERT_EQ(left.size(), 1U);
  EXPECT_EQ(left[0].goal(), "a");
  EXPECT_EQ(left[0].state(), msg::GoalState::GOAL_REACHED);
  EXPECT_TRUE(unpublished.take().empty());
}

TEST(UnpublishedEndsOfAStandby, EndsAreThoseThatAreStillToBeTold) {
  UnpublishedEnds unpublished;
  unpublished.keep({status("a", msg::GoalState::GOAL_REACHED), status("b", msg::GoalState::GOAL_CANCELLED),
                    status("c", msg::GoalState::GOAL_ACTIVE)});
  unpublished.heard(status("a", msg::GoalState::GOAL_REACHED));
  EXPECT_EQ(unpublished.ends(), (std::vector<GoalSnapshot::End>{{"b", msg::GoalState::GOAL_CANCELLED}}));
}

TEST(UnpublishedEndsOfAStandby, IsNothingThatWasToldBeforeItWasKnownHere) {
  UnpublishedEnds unpublished;
  unpublished.heard(status("a", msg::GoalState::GOAL_REACHED));
  unpublished.keep({status("a", msg::GoalState::GOAL_REACHED)});
  EXPECT_TRUE(unpublished.take().empty());
}

using namespace std::chrono_literals;

/// A planner that is restarted remembers what was true under term 4, until 100 s on its host's clock.
class Remembering : public ::testing::Test {
 protected:
  /// By planner "p"; `newest`: the mandate that it knows of now.
  [[nodiscard]] static Recollection judge(const ArmLease& under, const ArmLease& newest,
                                          const std::optional<LastCommand>& last) {
    Duty duty("p", true);
    duty.hear(newest);
    return judge_recollection(under, kUntil, duty, last);
  }
  /// The driver's last, so much later than we knew of anything.
  [[nodiscard]] static LastCommand command(std::uint64_t term, std::chrono::milliseconds later) {
    return {term, kUntil + later};
  }
  static constexpr std::chrono::nanoseconds kUntil = std::chrono::seconds(100);
  const ArmLease ours_{"p", 4};
  const ArmLease others_{"q", 4};
};

TEST_F(Remembering, NothingIsKnownBeforeTheFirstMandate) {
  EXPECT_EQ(judge(ours_, {}, command(4, 0ms)), Recollection::kUnknown);
}

TEST_F(Remembering, WhoeverWasInChargeAndStillIsGoesOn) {
  EXPECT_EQ(judge(ours_, ours_, std::nullopt), Recollection::kCounts);
  EXPECT_EQ(judge(ours_, ours_, command(4, 0ms)), Recollection::kCounts);
}

// A goal that was reached, cancelled or replaced while the other one had the arm must not come back.
TEST_F(Remembering, WhatTheOtherPlannerHasHadSinceIsItsOwn) {
  const ArmLease taken_over{"q", 6};
  EXPECT_EQ(judge(ours_, taken_over, std::nullopt), Recollection::kUnknown) << "it may be dead";
  EXPECT_EQ(judge(ours_, taken_over, command(4, 0ms)), Recollection::kUnknown) << "it may be dead";
  EXPECT_EQ(judge(ours_, taken_over, command(6, 10ms)), Recollection::kOutdated);
  const ArmLease given_back{"p", 8};
  EXPECT_EQ(judge(ours_, given_back, command(6, 10ms)), Recollection::kOutdated);
  EXPECT_EQ(judge(ours_, given_back, std::nullopt), Recollection::kUnknown);
  EXPECT_EQ(judge(ours_, given_back, command(4, 0ms)), Recollection::kCounts) << "the other never began";
}

TEST_F(Remembering, WhoeverStoodByGoesOnWhereBothEndedTogether) {
  EXPECT_EQ(judge(others_, others_, std::nullopt), Recollection::kUnknown);
  EXPECT_EQ(judge(others_, others_, command(4, -20ms)), Recollection::kCounts);
  EXPECT_EQ(judge(others_, others_, command(4, kTogether)), Recollection::kCounts);
  EXPECT_EQ(judge(others_, others_, command(4, kTogether + 1ms)), Recollection::kOutdated) << "it has gone on alone";
  const ArmLease ours_now{"p", 6};
  EXPECT_EQ(judge(others_, ours_now, command(4, 10ms)), Recollection::kCounts);
  EXPECT_EQ(judge(others_, ours_now, command(4, 400ms)), Recollection::kOutdated);
}

TEST_F(Remembering, ADriverThatKnowsOfNoCommandProvesNothing) {
  EXPECT_EQ(judge(others_, others_, command(0, -20ms)), Recollection::kOutdated);
}

class Heeding : public ::testing::Test {
 protected:
  static msg::GoalStatus told(msg::GoalState state, std::uint64_t term) {
    msg::GoalStatus message = status("a", state);
    message.term(term);
    return message;
  }
  Duty duty_{"p", true};
};

TEST_F(Heeding, WaitsUntilItIsKnownWhoIsInCharge) {
  EXPECT_EQ(heed(told(msg::GoalState::GOAL_REACHED, 4), duty_, true), Heed::kLater);
  duty_.hear({"q", 4});
  EXPECT_EQ(heed(told(msg::GoalState::GOAL_REACHED, 4), duty_, false), Heed::kLater)
      << "what is remembered comes first";
  EXPECT_EQ(heed(told(msg::GoalState::GOAL_REACHED, 4), duty_, true), Heed::kFollow);
}

TEST_F(Heeding, FollowsThePlannerInChargeAndAnyEnd) {
  duty_.hear({"q", 4});
  EXPECT_EQ(heed(told(msg::GoalState::GOAL_ACTIVE, 4), duty_, true), Heed::kFollow);
  EXPECT_EQ(heed(told(msg::GoalState::GOAL_ACTIVE, 5), duty_, true), Heed::kFollow) << "it knows more";
  EXPECT_EQ(heed(told(msg::GoalState::GOAL_ACTIVE, 2), duty_, true), Heed::kIgnore)
      << "the last word of an earlier term";
  EXPECT_EQ(heed(told(msg::GoalState::GOAL_CANCELLED, 2), duty_, true), Heed::kFollow);
}

TEST_F(Heeding, InChargeItListensToWhoeverReplacedItOnceItKnowsOfThat) {
  duty_.hear({"p", 4});
  EXPECT_EQ(heed(told(msg::GoalState::GOAL_REACHED, 3), duty_, true), Heed::kIgnore);
  EXPECT_EQ(heed(told(msg::GoalState::GOAL_REACHED, 6), duty_, true), Heed::kLater);
}

}  // namespace
}  // namespace hecaton::services
