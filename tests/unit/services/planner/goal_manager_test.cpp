#include "services/planner/goal_manager.hpp"

#include <gtest/gtest.h>

#include "services/runtime/cause.hpp"

namespace hecaton::services {
namespace {

using namespace std::chrono_literals;
using Told = std::vector<std::pair<std::string, msg::GoalState>>;

class GoalManagerTest : public testing::Test {
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
  static GoalAnswer yes(const msg::Goal& goal) { return {.goal = goal, .q_goal = planner::JointVector::Zero(1)}; }
  static GoalAnswer no(const msg::Goal& goal) { return {.goal = goal, .refusal = cause("in collision")}; }
  static msg::Cause cause(const std::string& text) {
    return make_cause(msg::CauseKind::CAUSE_GOAL_IN_COLLISION, "pallet", text);
  }
  /// The arm's planner is to forget its goal.
  bool takes_cancellation() {
    const auto change = goals_.take_change();
    return change && !change->q_goal;
  }

  bool ask_and_accept() {
    const auto question = goals_.next_question();
    return question && goals_.answer(yes(*question), now_);
  }
  void send_and_accept(const msg::Goal& goal) {
    goals_.receive(goal, now_);
    ASSERT_TRUE(ask_and_accept());
  }
  Told told() {
    Told list;
    for (const auto& status : statuses_ = goals_.take_statuses()) list.emplace_back(status.goal(), status.state());
    return list;
  }
  static Progress in(msg::GoalState state, const msg::Cause& why = {}) {
    Progress progress;
    progress.state = state;
    progress.cause = why;
    return progress;
  }

  GoalManager goals_{"arm1", "planner/arm1"};
  GoalManager::Clock::time_point now_{10s};
  std::uint64_t sent_ = 0;
  std::vector<msg::GoalStatus> statuses_;
};

TEST_F(GoalManagerTest, TellsHowLongAnArmHasBeenHeldBack) {
  send_and_accept(goal("a"));
  (void)told();
  const auto held_for = [this](bool held_back, GoalManager::Clock::duration later) {
    now_ += later;
    Progress progress = in(msg::GoalState::GOAL_ACTIVE);
    progress.held_back = held_back;
    goals_.progress(progress, now_);
    (void)told();
    return statuses_.back().blocked_duration();
  };
  EXPECT_EQ(held_for(false, 1s), 0.0);
  EXPECT_EQ(held_for(true, 1s), 0.0);
  EXPECT_DOUBLE_EQ(held_for(true, 2s), 2.0);
  EXPECT_DOUBLE_EQ(held_for(false, 300ms), 2.3) << "a moment of freedom does not count";
  EXPECT_DOUBLE_EQ(held_for(true, 300ms), 2.6);
  EXPECT_DOUBLE_EQ(held_for(false, 300ms), 2.9);
  EXPECT_DOUBLE_EQ(held_for(false, 600ms), 0.0);
}

TEST_F(GoalManagerTest, AClaimIsToldAtOnce) {
  send_and_accept(goal("a"));
  goals_.progress(in(msg::GoalState::GOAL_ACTIVE), now_);
  (void)told();
  now_ += 10ms;
  goals_.progress(in(msg::GoalState::GOAL_ACTIVE), now_);
  EXPECT_TRUE(told().empty());
  Progress asking = in(msg::GoalState::GOAL_ACTIVE);
  asking.priority = 3;
  goals_.progress(asking, now_);
  ASSERT_EQ(told().size(), 1U);
  EXPECT_EQ(statuses_.back().priority(), 3U);
}

TEST_F(GoalManagerTest, AcceptedActiveReached) {
  send_and_accept(goal("a"));
  EXPECT_EQ(told(), (Told{{"a", msg::GoalState::GOAL_ACCEPTED}}));
  now_ += 10ms;
  goals_.progress(in(msg::GoalState::GOAL_ACTIVE), now_);
  EXPECT_EQ(told(), (Told{{"a", msg::GoalState::GOAL_ACTIVE}}));
  now_ += 1990ms;
  goals_.progress(in(msg::GoalState::GOAL_REACHED), now_);
  EXPECT_EQ(told(), (Told{{"a", msg::GoalState::GOAL_REACHED}}));
  EXPECT_DOUBLE_EQ(statuses_[0].elapsed(), 2.0);
  EXPECT_FALSE(goals_.has_active());
  EXPECT_FALSE(takes_cancellation()) << "it keeps the place that it was sent to";
}

TEST_F(GoalManagerTest, TellsChangesAtOnceAndTheRestEvery100ms) {
  send_and_accept(goal("a"));
  goals_.progress(in(msg::GoalState::GOAL_ACTIVE), now_);
  (void)told();
  for (int k = 0; k < 9; ++k) goals_.progress(in(msg::GoalState::GOAL_ACTIVE), now_ += 10ms);
  EXPECT_EQ(told(), Told{});
  goals_.progress(in(msg::GoalState::GOAL_ACTIVE), now_ += 10ms);
  EXPECT_EQ(told(), (Told{{"a", msg::GoalState::GOAL_ACTIVE}}));
  goals_.progress(in(msg::GoalState::GOAL_BLOCKED, cause("pallet")), now_ += 10ms);
  ASSERT_EQ(told(), (Told{{"a", msg::GoalState::GOAL_BLOCKED}}));
  EXPECT_EQ(statuses_[0].cause().text(), "pallet");
  EXPECT_EQ(statuses_[0].sequence_number(), 4U);
}

TEST_F(GoalManagerTest, ARejectedGoalLeavesTheActiveOneAlone) {
  send_and_accept(goal("a"));
  (void)told();
  goals_.receive(goal("b"), now_);
  const auto question = goals_.next_question();
  ASSERT_TRUE(question);
  EXPECT_FALSE(goals_.answer(no(*question), now_));
  ASSERT_EQ(told(), (Told{{"b", msg::GoalState::GOAL_REJECTED}}));
  EXPECT_EQ(statuses_[0].cause().text(), "in collision");
  EXPECT_TRUE(goals_.has_active());
}

TEST_F(GoalManagerTest, ALaterGoalReplacesWithoutABrake) {
  send_and_accept(goal("a"));
  send_and_accept(goal("b"));
  EXPECT_EQ(told(), (Told{{"a", msg::GoalState::GOAL_ACCEPTED},
                          {"a", msg::GoalState::GOAL_REPLACED},
                          {"b", msg::GoalState::GOAL_ACCEPTED}}));
  EXPECT_FALSE(takes_cancellation());
}

TEST_F(GoalManagerTest, OneQuestionAtATimeInTheOrderOfArrival) {
  goals_.receive(goal("a"), now_);
  goals_.receive(goal("b"), now_);
  const auto first = goals_.next_question();
  ASSERT_TRUE(first);
  EXPECT_EQ(first->goal(), "a");
  EXPECT_FALSE(goals_.next_question());
  goals_.answer(yes(*first), now_);
  EXPECT_EQ(goals_.next_question()->goal(), "b");
}

TEST_F(GoalManagerTest, CancellingEndsAGoalWhereverItIs) {
  msg::Goal active = goal("active");
  msg::Goal asked = goal("asked");
  msg::Goal waiting = goal("waiting");
  send_and_accept(active);
  goals_.receive(asked, now_);
  goals_.receive(waiting, now_);
  ASSERT_TRUE(goals_.next_question());
  (void)told();
  for (msg::Goal* each : {&waiting, &asked, &active}) {
    each->cancel(true);
    goals_.receive(*each, now_);
  }
  EXPECT_EQ(told(), (Told{{"waiting", msg::GoalState::GOAL_CANCELLED}, {"active", msg::GoalState::GOAL_CANCELLED}}));
  EXPECT_TRUE(takes_cancellation()) << "the arm brakes and stays";
  EXPECT_FALSE(goals_.answer(yes(asked), now_));
  EXPECT_EQ(told(), (Told{{"asked", msg::GoalState::GOAL_CANCELLED}}));
  EXPECT_FALSE(goals_.has_active());
}

TEST_F(GoalManagerTest, TimeLimitEndsItWithTheReason) {
  send_and_accept(goal("a", 0.5));
  goals_.progress(in(msg::GoalState::GOAL_BLOCKED, cause("pallet in the way")), now_ + 500ms);
  EXPECT_TRUE(goals_.has_active());
  (void)told();
  goals_.progress(in(msg::GoalState::GOAL_BLOCKED, cause("pallet in the way")), now_ + 510ms);
  ASSERT_EQ(told(), (Told{{"a", msg::GoalState::GOAL_TIMED_OUT}}));
  EXPECT_EQ(statuses_[0].cause().kind(), msg::CauseKind::CAUSE_TIME_LIMIT);
  EXPECT_EQ(statuses_[0].cause().text(), "not reached within 0.5 s: pallet in the way");
  EXPECT_TRUE(takes_cancellation());
}

TEST_F(GoalManagerTest, WhatCannotBeJudgedInTimeIsRefused) {
  goals_.receive(goal("a"), now_);
  goals_.receive(goal("b"), now_ + 2s);
  goals_.refuse_waiting(now_ + 3s, 3s, cause("no world"));
  EXPECT_EQ(told(), Told{});
  goals_.refuse_waiting(now_ + 4s, 3s, cause("no world"));
  ASSERT_EQ(told(), (Told{{"a", msg::GoalState::GOAL_REJECTED}}));
  EXPECT_EQ(statuses_[0].cause().text(), "no world");
  EXPECT_EQ(goals_.next_question()->goal(), "b");
}

TEST_F(GoalManagerTest, WhenNobodyResolvesGoalsAllAreRefusedAndALateAnswerIsForNobody) {
  send_and_accept(goal("active"));
  for (const auto* name : {"asked", "waiting"}) goals_.receive(goal(name), now_);
  const auto question = goals_.next_question();
  ASSERT_TRUE(question);
  (void)told();
  goals_.refuse_all(cause("nobody answers"));
  EXPECT_EQ(told(), (Told{{"asked", msg::GoalState::GOAL_REJECTED}, {"waiting", msg::GoalState::GOAL_REJECTED}}));
  EXPECT_EQ(statuses_[0].cause().text(), "nobody answers");
  EXPECT_TRUE(goals_.has_active());
  goals_.receive(goal("next"), now_);
  EXPECT_FALSE(goals_.next_question()) << "nobody is there to be asked";
  goals_.refuse_all(cause("nobody answers"));
  EXPECT_EQ(told(), (Told{{"next", msg::GoalState::GOAL_REJECTED}})) << "each is told once";
  EXPECT_EQ(goals_.snapshot(now_).handled.size(), 4U) << "they are answered, for a successor, too";
  EXPECT_FALSE(goals_.answer(yes(*question), now_));
  EXPECT_TRUE(told().empty());
  send_and_accept(goal("after"));
  EXPECT_EQ(told().back(), (Told::value_type{"after", msg::GoalState::GOAL_ACCEPTED}));
}

TEST_F(GoalManagerTest, WhatIsCancelledWhileNobodyResolvesGoalsIsSaidToBe) {
  msg::Goal asked = goal("asked");
  goals_.receive(asked, now_);
  ASSERT_TRUE(goals_.next_question());
  asked.cancel(true);
  goals_.receive(asked, now_);
  goals_.refuse_all(cause("nobody answers"));
  EXPECT_EQ(told(), (Told{{"asked", msg::GoalState::GOAL_CANCELLED}}));
  EXPECT_EQ(statuses_[0].cause().text(), "its client gave it up");
}

TEST_F(GoalManagerTest, WaitingCountsFromWhenItIsInCharge) {
  goals_.receive(goal("a"), now_);
  goals_.wait_from(now_ + 5s);
  goals_.refuse_waiting(now_ + 6s, 3s, cause("no driver"));
  EXPECT_EQ(told(), Told{});
  goals_.refuse_waiting(now_ + 9s, 3s, cause("no driver"));
  EXPECT_EQ(told(), (Told{{"a", msg::GoalState::GOAL_REJECTED}}));
}

TEST_F(GoalManagerTest, RepetitionsAndOtherArmsGoalsAreIgnored) {
  const msg::Goal once = goal("a");
  send_and_accept(once);
  goals_.receive(once, now_);
  msg::Goal other = goal("b");
  other.arm("arm2");
  goals_.receive(other, now_);
  EXPECT_FALSE(goals_.next_question());
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

TEST_F(GoalManagerTest, FollowsAGoalThatItNeverHeardOf) {
  EXPECT_TRUE(goals_.follow(told_by_the_other("a", msg::GoalState::GOAL_ACTIVE), now_));
  EXPECT_EQ(goals_.q_goal()[0], 0.5);
  EXPECT_FALSE(goals_.follow(told_by_the_other("a", msg::GoalState::GOAL_ACTIVE), now_)) << "it is active already";
  EXPECT_TRUE(told().empty()) << "the other tells";
  goals_.progress(in(msg::GoalState::GOAL_REACHED), now_);
  EXPECT_EQ(told(), (Told{{"a", msg::GoalState::GOAL_REACHED}}));
  EXPECT_GT(statuses_[0].elapsed(), 1.9);
  EXPECT_FALSE(goals_.follow(told_by_the_other("a", msg::GoalState::GOAL_ACTIVE), now_)) << "it has ended here";
}

TEST_F(GoalManagerTest, AFollowedGoalIsTheSameWhenItsClientIsHeard) {
  ASSERT_TRUE(goals_.follow(told_by_the_other("a", msg::GoalState::GOAL_ACTIVE), now_));
  goals_.receive(goal("a", 60.0), now_);
  EXPECT_FALSE(goals_.next_question());
  EXPECT_TRUE(goals_.has_active());
  EXPECT_TRUE(told().empty());
}

TEST_F(GoalManagerTest, EndsWhatThePlannerInChargeHasEnded) {
  send_and_accept(goal("a"));
  static_cast<void>(told());
  EXPECT_FALSE(goals_.follow(told_by_the_other("a", msg::GoalState::GOAL_CANCELLED), now_));
  EXPECT_FALSE(goals_.has_active());
  EXPECT_TRUE(takes_cancellation());
  send_and_accept(goal("b"));
  EXPECT_FALSE(goals_.follow(told_by_the_other("a", msg::GoalState::GOAL_REACHED), now_));
  EXPECT_TRUE(goals_.has_active()) << "another goal's end";
  EXPECT_FALSE(goals_.follow(told_by_the_other("b", msg::GoalState::GOAL_REACHED), now_));
  EXPECT_FALSE(takes_cancellation()) << "the arm keeps the place that it was sent to";
}

class Restarted : public GoalManagerTest {
 protected:
  /// A desk that knows what ours would tell its successor now.
  GoalManager successor(GoalManager::Clock::duration ago = 0s) {
    GoalManager desk("arm1", "planner/arm1");
    resumed_ = desk.resume(goals_.snapshot(now_), ago, now_ + ago);
    return desk;
  }
  static Told told_by(GoalManager& desk) {
    Told list;
    for (const auto& status : desk.take_statuses()) list.emplace_back(status.goal(), status.state());
    return list;
  }
  bool resumed_ = false;
};

TEST_F(Restarted, GoesOnWithTheGoalThatWasAcceptedBeforeAnybodyWasTold) {
  const msg::Goal a = goal("a");
  send_and_accept(a);  // its status is not even taken
  GoalManager desk = successor();
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
  GoalManager desk = successor();
  EXPECT_EQ(told_by(desk), (Told{{"a", msg::GoalState::GOAL_REPLACED}, {"b", msg::GoalState::GOAL_ACTIVE}}));
  desk.receive(a, now_);
  EXPECT_FALSE(desk.next_question());
}

TEST_F(Restarted, AnEndIsToldOnceMoreAndNothingIsUnderWay) {
  send_and_accept(goal("a"));
  msg::Goal withdrawn = goal("a");
  withdrawn.cancel(true);
  goals_.receive(withdrawn, now_);
  GoalManager desk = successor();
  EXPECT_FALSE(resumed_);
  EXPECT_FALSE(desk.has_active());
  EXPECT_EQ(told_by(desk), (Told{{"a", msg::GoalState::GOAL_CANCELLED}}));
}

TEST_F(Restarted, WhatWasNotAnsweredIsAskedAgain) {
  const msg::Goal asked = goal("asked");
  const msg::Goal waiting = goal("waiting");
  goals_.receive(asked, now_);
  goals_.receive(waiting, now_);
  ASSERT_TRUE(goals_.next_question());
  GoalManager desk = successor();
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
  GoalManager desk = successor(2s);
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
  GoalManager desk = successor();
  const GoalSnapshot first = goals_.snapshot(now_);
  EXPECT_TRUE(desk.snapshot(now_) == first);
  EXPECT_EQ(first.handled.size(), 2U);
}

// Who stood by has told none of its ends but those that it still owes.
TEST_F(Restarted, TellsOnlyTheEndsThatItOwes) {
  for (const auto* name : {"a", "b", "c"}) send_and_accept(goal(name));
  goals_.owe_ends({{"b", msg::GoalState::GOAL_REACHED}});
  GoalManager desk = successor();
  EXPECT_EQ(told_by(desk), (Told{{"b", msg::GoalState::GOAL_REACHED}, {"c", msg::GoalState::GOAL_ACTIVE}}));
  std::vector<GoalSnapshot::End> many;
  for (std::size_t i = 0; i < GoalSnapshot::kEnds + 2; ++i)
    many.push_back({std::to_string(i), msg::GoalState::GOAL_REACHED});
  goals_.owe_ends(many);
  EXPECT_EQ(goals_.snapshot(now_).ends, std::vector(many.begin() + 2, many.end())) << "the last";
}

TEST_F(GoalManagerTest, AGoalWhoseNameIsTooLongToBeRememberedIsRejected) {
  goals_.receive(goal(std::string(GoalSnapshot::kLongestName + 1, 'x')), now_);
  EXPECT_FALSE(ask_and_accept());
  ASSERT_EQ(told().back().second, msg::GoalState::GOAL_REJECTED);
  EXPECT_EQ(statuses_.back().cause().text(), "the names of a goal and of its client must have at most 255 bytes");
  send_and_accept(goal(std::string(GoalSnapshot::kLongestName, 'x')));
}

}  // namespace
}  // namespace hecaton::services
