#include "services/planner/goal_desk.hpp"

#include <gtest/gtest.h>

namespace hecaton::services {
namespace {

using namespace std::chrono_literals;
using Told = std::vector<std::pair<std::string, msg::GoalState>>;

class Desk : public testing::Test {
 protected:
  msg::Goal goal(const std::string& name, double time_limit = 0.0) {
    msg::Goal message;
    message.arm("arm1");
    message.goal(name);
    message.client("test");
    message.sequence_number(++sent_);
    message.time_limit(time_limit);
    return message;
  }
  static GoalAnswer yes(const msg::Goal& goal) { return {goal, true, planner::JointVector::Zero(1), ""}; }
  static GoalAnswer no(const msg::Goal& goal) { return {goal, false, {}, "in collision"}; }

  bool ask_and_accept() {
    const auto question = desk_.next_question();
    return question && desk_.answer(yes(*question), now_);
  }
  void send_and_accept(const msg::Goal& goal) {
    desk_.receive(goal, now_);
    ASSERT_TRUE(ask_and_accept());
  }
  Told told() {
    Told list;
    for (const auto& status : statuses_ = desk_.take_statuses()) list.emplace_back(status.goal(), status.state());
    return list;
  }
  static Progress in(msg::GoalState state, const std::string& reason = "") {
    Progress progress;
    progress.state = state;
    progress.reason = reason;
    return progress;
  }

  GoalDesk desk_{"arm1", "planner/arm1"};
  GoalDesk::Clock::time_point now_{10s};
  std::uint64_t sent_ = 0;
  std::vector<msg::GoalStatus> statuses_;
};

TEST_F(Desk, TellsHowLongAnArmHasBeenHeldBack) {
  send_and_accept(goal("a"));
  (void)told();
  const auto held_for = [this](bool held_back, GoalDesk::Clock::duration later) {
    now_ += later;
    Progress progress = in(msg::GoalState::GOAL_ACTIVE);
    progress.held_back = held_back;
    desk_.progress(progress, now_);
    (void)told();
    return statuses_.back().held_for();
  };
  EXPECT_EQ(held_for(false, 1s), 0.0);
  EXPECT_EQ(held_for(true, 1s), 0.0);
  EXPECT_DOUBLE_EQ(held_for(true, 2s), 2.0);
  EXPECT_DOUBLE_EQ(held_for(false, 300ms), 2.3) << "a moment of freedom does not count";
  EXPECT_DOUBLE_EQ(held_for(true, 300ms), 2.6);
  EXPECT_DOUBLE_EQ(held_for(false, 300ms), 2.9);
  EXPECT_DOUBLE_EQ(held_for(false, 600ms), 0.0);
}

TEST_F(Desk, AClaimIsToldAtOnce) {
  send_and_accept(goal("a"));
  desk_.progress(in(msg::GoalState::GOAL_ACTIVE), now_);
  (void)told();
  now_ += 10ms;
  desk_.progress(in(msg::GoalState::GOAL_ACTIVE), now_);
  EXPECT_TRUE(told().empty());
  Progress asking = in(msg::GoalState::GOAL_ACTIVE);
  asking.claim = 3;
  desk_.progress(asking, now_);
  ASSERT_EQ(told().size(), 1U);
  EXPECT_EQ(statuses_.back().claim(), 3U);
}

TEST_F(Desk, AcceptedActiveReached) {
  send_and_accept(goal("a"));
  EXPECT_EQ(told(), (Told{{"a", msg::GoalState::GOAL_ACCEPTED}}));
  now_ += 10ms;
  desk_.progress(in(msg::GoalState::GOAL_ACTIVE), now_);
  EXPECT_EQ(told(), (Told{{"a", msg::GoalState::GOAL_ACTIVE}}));
  now_ += 1990ms;
  desk_.progress(in(msg::GoalState::GOAL_REACHED), now_);
  EXPECT_EQ(told(), (Told{{"a", msg::GoalState::GOAL_REACHED}}));
  EXPECT_DOUBLE_EQ(statuses_[0].elapsed(), 2.0);
  EXPECT_FALSE(desk_.has_active());
  EXPECT_FALSE(desk_.take_forget()) << "it keeps the place that it was sent to";
}

TEST_F(Desk, TellsChangesAtOnceAndTheRestEvery100ms) {
  send_and_accept(goal("a"));
  desk_.progress(in(msg::GoalState::GOAL_ACTIVE), now_);
  (void)told();
  for (int k = 0; k < 9; ++k) desk_.progress(in(msg::GoalState::GOAL_ACTIVE), now_ += 10ms);
  EXPECT_EQ(told(), Told{});
  desk_.progress(in(msg::GoalState::GOAL_ACTIVE), now_ += 10ms);
  EXPECT_EQ(told(), (Told{{"a", msg::GoalState::GOAL_ACTIVE}}));
  desk_.progress(in(msg::GoalState::GOAL_BLOCKED, "pallet"), now_ += 10ms);
  ASSERT_EQ(told(), (Told{{"a", msg::GoalState::GOAL_BLOCKED}}));
  EXPECT_EQ(statuses_[0].reason(), "pallet");
  EXPECT_EQ(statuses_[0].sequence_number(), 4U);
}

TEST_F(Desk, ARejectedGoalLeavesTheActiveOneAlone) {
  send_and_accept(goal("a"));
  (void)told();
  desk_.receive(goal("b"), now_);
  const auto question = desk_.next_question();
  ASSERT_TRUE(question);
  EXPECT_FALSE(desk_.answer(no(*question), now_));
  ASSERT_EQ(told(), (Told{{"b", msg::GoalState::GOAL_REJECTED}}));
  EXPECT_EQ(statuses_[0].reason(), "in collision");
  EXPECT_TRUE(desk_.has_active());
}

TEST_F(Desk, ALaterGoalReplacesWithoutABrake) {
  send_and_accept(goal("a"));
  send_and_accept(goal("b"));
  EXPECT_EQ(told(), (Told{{"a", msg::GoalState::GOAL_ACCEPTED},
                          {"a", msg::GoalState::GOAL_REPLACED},
                          {"b", msg::GoalState::GOAL_ACCEPTED}}));
  EXPECT_FALSE(desk_.take_forget());
}

TEST_F(Desk, OneQuestionAtATimeInTheOrderOfArrival) {
  desk_.receive(goal("a"), now_);
  desk_.receive(goal("b"), now_);
  const auto first = desk_.next_question();
  ASSERT_TRUE(first);
  EXPECT_EQ(first->goal(), "a");
  EXPECT_FALSE(desk_.next_question());
  desk_.answer(yes(*first), now_);
  EXPECT_EQ(desk_.next_question()->goal(), "b");
}

TEST_F(Desk, CancellingEndsAGoalWhereverItIs) {
  msg::Goal active = goal("active");
  msg::Goal asked = goal("asked");
  msg::Goal waiting = goal("waiting");
  send_and_accept(active);
  desk_.receive(asked, now_);
  desk_.receive(waiting, now_);
  ASSERT_TRUE(desk_.next_question());
  (void)told();
  for (msg::Goal* each : {&waiting, &asked, &active}) {
    each->cancel(true);
    desk_.receive(*each, now_);
  }
  EXPECT_EQ(told(), (Told{{"waiting", msg::GoalState::GOAL_CANCELLED}, {"active", msg::GoalState::GOAL_CANCELLED}}));
  EXPECT_TRUE(desk_.take_forget()) << "the arm brakes and stays";
  EXPECT_FALSE(desk_.answer(yes(asked), now_));
  EXPECT_EQ(told(), (Told{{"asked", msg::GoalState::GOAL_CANCELLED}}));
  EXPECT_FALSE(desk_.has_active());
}

TEST_F(Desk, TimeLimitEndsItWithTheReason) {
  send_and_accept(goal("a", 0.5));
  desk_.progress(in(msg::GoalState::GOAL_BLOCKED, "pallet in the way"), now_ + 500ms);
  EXPECT_TRUE(desk_.has_active());
  (void)told();
  desk_.progress(in(msg::GoalState::GOAL_BLOCKED, "pallet in the way"), now_ + 510ms);
  ASSERT_EQ(told(), (Told{{"a", msg::GoalState::GOAL_TIMED_OUT}}));
  EXPECT_EQ(statuses_[0].reason(), "not reached within 0.5 s: pallet in the way");
  EXPECT_TRUE(desk_.take_forget());
}

TEST_F(Desk, WhatCannotBeJudgedInTimeIsRefused) {
  desk_.receive(goal("a"), now_);
  desk_.receive(goal("b"), now_ + 2s);
  desk_.refuse_waiting(now_ + 3s, 3s, "no world");
  EXPECT_EQ(told(), Told{});
  desk_.refuse_waiting(now_ + 4s, 3s, "no world");
  ASSERT_EQ(told(), (Told{{"a", msg::GoalState::GOAL_REJECTED}}));
  EXPECT_EQ(statuses_[0].reason(), "no world");
  EXPECT_EQ(desk_.next_question()->goal(), "b");
}

TEST_F(Desk, WhenNobodyResolvesGoalsAllAreRefusedAndALateAnswerIsForNobody) {
  send_and_accept(goal("active"));
  for (const auto* name : {"asked", "waiting"}) desk_.receive(goal(name), now_);
  const auto question = desk_.next_question();
  ASSERT_TRUE(question);
  (void)told();
  desk_.refuse_all("nobody answers");
  EXPECT_EQ(told(), (Told{{"asked", msg::GoalState::GOAL_REJECTED}, {"waiting", msg::GoalState::GOAL_REJECTED}}));
  EXPECT_EQ(statuses_[0].reason(), "nobody answers");
  EXPECT_TRUE(desk_.has_active());
  desk_.receive(goal("next"), now_);
  EXPECT_FALSE(desk_.next_question()) << "nobody is there to be asked";
  desk_.refuse_all("nobody answers");
  EXPECT_EQ(told(), (Told{{"next", msg::GoalState::GOAL_REJECTED}})) << "each is told once";
  EXPECT_EQ(desk_.account(now_).handled.size(), 4U) << "they are answered, for a successor, too";
  EXPECT_FALSE(desk_.answer(yes(*question), now_));
  EXPECT_TRUE(told().empty());
  send_and_accept(goal("after"));
  EXPECT_EQ(told().back(), (Told::value_type{"after", msg::GoalState::GOAL_ACCEPTED}));
}

TEST_F(Desk, WhatIsCancelledWhileNobodyResolvesGoalsIsSaidToBe) {
  msg::Goal asked = goal("asked");
  desk_.receive(asked, now_);
  ASSERT_TRUE(desk_.next_question());
  asked.cancel(true);
  desk_.receive(asked, now_);
  desk_.refuse_all("nobody answers");
  EXPECT_EQ(told(), (Told{{"asked", msg::GoalState::GOAL_CANCELLED}}));
  EXPECT_EQ(statuses_[0].reason(), "its client gave it up");
}

TEST_F(Desk, WaitingCountsFromWhenItIsInCharge) {
  desk_.receive(goal("a"), now_);
  desk_.wait_from(now_ + 5s);
  desk_.refuse_waiting(now_ + 6s, 3s, "no driver");
  EXPECT_EQ(told(), Told{});
  desk_.refuse_waiting(now_ + 9s, 3s, "no driver");
  EXPECT_EQ(told(), (Told{{"a", msg::GoalState::GOAL_REJECTED}}));
}

TEST_F(Desk, RepetitionsAndOtherArmsGoalsAreIgnored) {
  const msg::Goal once = goal("a");
  send_and_accept(once);
  desk_.receive(once, now_);
  msg::Goal other = goal("b");
  other.arm("arm2");
  desk_.receive(other, now_);
  EXPECT_FALSE(desk_.next_question());
}

msg::GoalStatus told_by_the_other(const std::string& goal, msg::GoalState state) {
  msg::GoalStatus status;
  status.arm("arm1");
  status.goal(goal);
  status.state(state);
  status.elapsed(2.0);
  status.q_goal({0.5});
  return status;
}

TEST_F(Desk, FollowsAGoalThatItNeverHeardOf) {
  EXPECT_TRUE(desk_.follow(told_by_the_other("a", msg::GoalState::GOAL_ACTIVE), now_));
  EXPECT_EQ(desk_.q_goal()[0], 0.5);
  EXPECT_FALSE(desk_.follow(told_by_the_other("a", msg::GoalState::GOAL_ACTIVE), now_)) << "it is active already";
  EXPECT_TRUE(told().empty()) << "the other tells";
  desk_.progress(in(msg::GoalState::GOAL_REACHED), now_);
  EXPECT_EQ(told(), (Told{{"a", msg::GoalState::GOAL_REACHED}}));
  EXPECT_GT(statuses_[0].elapsed(), 1.9);
  EXPECT_FALSE(desk_.follow(told_by_the_other("a", msg::GoalState::GOAL_ACTIVE), now_)) << "it has ended here";
}

TEST_F(Desk, AFollowedGoalIsTheSameWhenItsClientIsHeard) {
  ASSERT_TRUE(desk_.follow(told_by_the_other("a", msg::GoalState::GOAL_ACTIVE), now_));
  desk_.receive(goal("a", 60.0), now_);
  EXPECT_FALSE(desk_.next_question());
  EXPECT_TRUE(desk_.has_active());
  EXPECT_TRUE(told().empty());
}

TEST_F(Desk, EndsWhatThePlannerInChargeHasEnded) {
  send_and_accept(goal("a"));
  static_cast<void>(told());
  EXPECT_FALSE(desk_.follow(told_by_the_other("a", msg::GoalState::GOAL_CANCELLED), now_));
  EXPECT_FALSE(desk_.has_active());
  EXPECT_TRUE(desk_.take_forget());
  send_and_accept(goal("b"));
  EXPECT_FALSE(desk_.follow(told_by_the_other("a", msg::GoalState::GOAL_REACHED), now_));
  EXPECT_TRUE(desk_.has_active()) << "another goal's end";
  EXPECT_FALSE(desk_.follow(told_by_the_other("b", msg::GoalState::GOAL_REACHED), now_));
  EXPECT_FALSE(desk_.take_forget()) << "the arm keeps the place that it was sent to";
}

class Restarted : public Desk {
 protected:
  /// A desk that knows what ours would tell its successor now.
  GoalDesk successor(GoalDesk::Clock::duration ago = 0s) {
    GoalDesk desk("arm1", "planner/arm1");
    resumed_ = desk.resume(desk_.account(now_), ago, now_ + ago);
    return desk;
  }
  static Told told_by(GoalDesk& desk) {
    Told list;
    for (const auto& status : desk.take_statuses()) list.emplace_back(status.goal(), status.state());
    return list;
  }
  bool resumed_ = false;
};

TEST_F(Restarted, GoesOnWithTheGoalThatWasAcceptedBeforeAnybodyWasTold) {
  const msg::Goal a = goal("a");
  send_and_accept(a);  // its status is not even taken
  GoalDesk desk = successor();
  EXPECT_TRUE(resumed_);
  ASSERT_TRUE(desk.has_active());
  EXPECT_EQ(desk.q_goal(), planner::JointVector::Zero(1));
  EXPECT_EQ(told_by(desk), (Told{{"a", msg::GoalState::GOAL_ACTIVE}}));
  // Its client is still there, and the bus hands its goal to the newcomer.
  desk.receive(a, now_);
  EXPECT_FALSE(desk.next_question());
  desk.progress(in(msg::GoalState::GOAL_REACHED), now_);
  EXPECT_EQ(told_by(desk), (Told{{"a", msg::GoalState::GOAL_REACHED}}));
}

TEST_F(Restarted, AGoalThatWasReplacedDoesNotReturnWithItsClient) {
  const msg::Goal a = goal("a");
  send_and_accept(a);
  send_and_accept(goal("b"));
  GoalDesk desk = successor();
  EXPECT_EQ(told_by(desk), (Told{{"a", msg::GoalState::GOAL_REPLACED}, {"b", msg::GoalState::GOAL_ACTIVE}}));
  desk.receive(a, now_);
  EXPECT_FALSE(desk.next_question());
}

TEST_F(Restarted, AnEndIsToldOnceMoreAndNothingIsUnderWay) {
  send_and_accept(goal("a"));
  msg::Goal withdrawn = goal("a");
  withdrawn.cancel(true);
  desk_.receive(withdrawn, now_);
  GoalDesk desk = successor();
  EXPECT_FALSE(resumed_);
  EXPECT_FALSE(desk.has_active());
  EXPECT_EQ(told_by(desk), (Told{{"a", msg::GoalState::GOAL_CANCELLED}}));
}

TEST_F(Restarted, WhatWasNotAnsweredIsAskedAgain) {
  const msg::Goal asked = goal("asked");
  const msg::Goal waiting = goal("waiting");
  desk_.receive(asked, now_);
  desk_.receive(waiting, now_);
  ASSERT_TRUE(desk_.next_question());
  GoalDesk desk = successor();
  EXPECT_FALSE(resumed_);
  desk.receive(asked, now_);
  desk.receive(waiting, now_);
  const auto question = desk.next_question();
  ASSERT_TRUE(question);
  EXPECT_EQ(question->goal(), "asked");
  (void)desk.answer(yes(*question), now_);
  EXPECT_TRUE(desk.next_question());
}

TEST_F(Restarted, TheTimeLimitGoesOnWhileNobodyIsThere) {
  send_and_accept(goal("a", 5.0));
  now_ += 2s;
  GoalDesk desk = successor(2s);
  (void)told_by(desk);
  desk.progress(in(msg::GoalState::GOAL_ACTIVE), now_ + 2900ms);
  EXPECT_TRUE(desk.has_active()) << "4.9 s after it was accepted";
  desk.progress(in(msg::GoalState::GOAL_ACTIVE), now_ + 3100ms);
  EXPECT_FALSE(desk.has_active());
  EXPECT_EQ(told_by(desk).back().second, msg::GoalState::GOAL_TIMED_OUT);
}

TEST_F(Restarted, AndASuccessorOfTheSuccessorKnowsItAll) {
  const msg::Goal a = goal("a");
  const msg::Goal b = goal("b");
  send_and_accept(a);
  send_and_accept(b);
  GoalDesk desk = successor();
  const GoalAccount first = desk_.account(now_);
  EXPECT_TRUE(desk.account(now_) == first);
  EXPECT_EQ(first.handled.size(), 2U);
}

// Who stood by has told none of its ends but those that it still owes.
TEST_F(Restarted, TellsOnlyTheEndsThatItOwes) {
  for (const auto* name : {"a", "b", "c"}) send_and_accept(goal(name));
  desk_.owe_ends({{"b", msg::GoalState::GOAL_REACHED}});
  GoalDesk desk = successor();
  EXPECT_EQ(told_by(desk), (Told{{"b", msg::GoalState::GOAL_REACHED}, {"c", msg::GoalState::GOAL_ACTIVE}}));
  std::vector<GoalAccount::End> many;
  for (std::size_t i = 0; i < GoalAccount::kEnds + 2; ++i)
    many.push_back({std::to_string(i), msg::GoalState::GOAL_REACHED});
  desk_.owe_ends(many);
  EXPECT_EQ(desk_.account(now_).ends, std::vector(many.begin() + 2, many.end())) << "the last";
}

TEST_F(Desk, AGoalWhoseNameIsTooLongToBeRememberedIsRejected) {
  desk_.receive(goal(std::string(GoalAccount::kLongestName + 1, 'x')), now_);
  EXPECT_FALSE(ask_and_accept());
  ASSERT_EQ(told().back().second, msg::GoalState::GOAL_REJECTED);
  EXPECT_EQ(statuses_.back().reason(), "the names of a goal and of its client must have at most 255 bytes");
  send_and_accept(goal(std::string(GoalAccount::kLongestName, 'x')));
}

}  // namespace
}  // namespace hecaton::services
