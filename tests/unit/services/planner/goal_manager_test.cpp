#include "services/planner/goal_manager.hpp"

#include <gtest/gtest.h>

#include "services/messages/convert.hpp"
#include "services/runtime/cause.hpp"

namespace hecaton::services {
namespace {

using namespace std::chrono_literals;
using Statuses = std::vector<std::pair<std::string, msg::GoalState>>;

msg::GoalStatus status_of_the_other(const std::string& goal, msg::GoalState state) {
  msg::GoalStatus status;
  status.arm("arm1");
  status.goal(goal);
  status.state(state);
  status.elapsed(2.0);
  status.q_goal({0.5});
  return status;
}

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
  msg::Goal cancellation(const std::string& name) {
    msg::Goal message = goal(name);
    message.cancel(true);
    return message;
  }
  static GoalAnswer yes(const msg::Goal& goal) { return {.goal = goal, .q_goal = planner::JointVector::Zero(1)}; }
  static GoalAnswer no(const msg::Goal& goal) { return {.goal = goal, .rejection = cause("in collision")}; }
  static msg::Cause cause(const std::string& text) {
    return make_cause(msg::CauseKind::CAUSE_GOAL_IN_COLLISION, "pallet", text);
  }
  /// The planner has to drop its goal.
  bool takes_cancellation() {
    const auto change = goals_.take_change();
    return change && !change->q_goal;
  }

  bool ask_and_accept() {
    const auto question = goals_.next_to_resolve();
    return question && goals_.answer(yes(*question), now_);
  }
  void send_and_accept(const msg::Goal& goal) {
    goals_.receive(goal, now_);
    ASSERT_TRUE(ask_and_accept());
  }
  Statuses statuses() {
    Statuses list;
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

TEST_F(GoalManagerTest, ReportsTheBlockedDuration) {
  send_and_accept(goal("a"));
  (void)statuses();
  const auto held_for = [this](bool obstructed, GoalManager::Clock::duration later) {
    now_ += later;
    Progress progress = in(msg::GoalState::GOAL_ACTIVE);
    progress.obstructed = obstructed;
    goals_.progress(progress, now_);
    (void)statuses();
    return statuses_.back().blocked_duration();
  };
  EXPECT_EQ(held_for(false, 1s), 0.0);
  EXPECT_EQ(held_for(true, 1s), 0.0);
  EXPECT_DOUBLE_EQ(held_for(true, 2s), 2.0);
  EXPECT_DOUBLE_EQ(held_for(false, 300ms), 2.3) << "a short free motion does not count";
  EXPECT_DOUBLE_EQ(held_for(true, 300ms), 2.6);
  EXPECT_DOUBLE_EQ(held_for(false, 300ms), 2.9);
  EXPECT_DOUBLE_EQ(held_for(false, 600ms), 0.0);
}

TEST_F(GoalManagerTest, ReportsAPriorityAtOnce) {
  send_and_accept(goal("a"));
  goals_.progress(in(msg::GoalState::GOAL_ACTIVE), now_);
  (void)statuses();
  now_ += 10ms;
  goals_.progress(in(msg::GoalState::GOAL_ACTIVE), now_);
  EXPECT_TRUE(statuses().empty());
  Progress asking = in(msg::GoalState::GOAL_ACTIVE);
  asking.priority = 3;
  goals_.progress(asking, now_);
  ASSERT_EQ(statuses().size(), 1U);
  EXPECT_EQ(statuses_.back().priority(), 3U);
}

TEST_F(GoalManagerTest, ReportsAcceptedActiveReached) {
  send_and_accept(goal("a"));
  EXPECT_EQ(statuses(), (Statuses{{"a", msg::GoalState::GOAL_ACCEPTED}}));
  now_ += 10ms;
  goals_.progress(in(msg::GoalState::GOAL_ACTIVE), now_);
  EXPECT_EQ(statuses(), (Statuses{{"a", msg::GoalState::GOAL_ACTIVE}}));
  now_ += 1990ms;
  goals_.progress(in(msg::GoalState::GOAL_REACHED), now_);
  EXPECT_EQ(statuses(), (Statuses{{"a", msg::GoalState::GOAL_REACHED}}));
  EXPECT_DOUBLE_EQ(statuses_[0].elapsed(), 2.0);
  EXPECT_FALSE(goals_.has_active());
  EXPECT_FALSE(takes_cancellation()) << "the arm keeps its place";
}

TEST_F(GoalManagerTest, ReportsChangesAtOnceAndProgressEvery100ms) {
  send_and_accept(goal("a"));
  goals_.progress(in(msg::GoalState::GOAL_ACTIVE), now_);
  (void)statuses();
  for (int k = 0; k < 9; ++k) goals_.progress(in(msg::GoalState::GOAL_ACTIVE), now_ += 10ms);
  EXPECT_EQ(statuses(), Statuses{});
  goals_.progress(in(msg::GoalState::GOAL_ACTIVE), now_ += 10ms);
  EXPECT_EQ(statuses(), (Statuses{{"a", msg::GoalState::GOAL_ACTIVE}}));
  goals_.progress(in(msg::GoalState::GOAL_BLOCKED, cause("pallet")), now_ += 10ms);
  ASSERT_EQ(statuses(), (Statuses{{"a", msg::GoalState::GOAL_BLOCKED}}));
  EXPECT_EQ(statuses_[0].cause().text(), "pallet");
  EXPECT_EQ(statuses_[0].sequence_number(), 4U);
}

TEST_F(GoalManagerTest, KeepsTheActiveGoalWhenAnotherIsRejected) {
  send_and_accept(goal("a"));
  (void)statuses();
  goals_.receive(goal("b"), now_);
  const auto question = goals_.next_to_resolve();
  ASSERT_TRUE(question);
  EXPECT_FALSE(goals_.answer(no(*question), now_));
  ASSERT_EQ(statuses(), (Statuses{{"b", msg::GoalState::GOAL_REJECTED}}));
  EXPECT_EQ(statuses_[0].cause().text(), "in collision");
  EXPECT_TRUE(goals_.has_active());
}

TEST_F(GoalManagerTest, ReplacesAGoalWithoutBraking) {
  send_and_accept(goal("a"));
  send_and_accept(goal("b"));
  EXPECT_EQ(statuses(), (Statuses{{"a", msg::GoalState::GOAL_ACCEPTED},
                                  {"a", msg::GoalState::GOAL_REPLACED},
                                  {"b", msg::GoalState::GOAL_ACCEPTED}}));
  EXPECT_FALSE(takes_cancellation());
}

TEST_F(GoalManagerTest, ResolvesOneGoalAtATimeInTheOrderOfArrival) {
  goals_.receive(goal("a"), now_);
  goals_.receive(goal("b"), now_);
  const auto first = goals_.next_to_resolve();
  ASSERT_TRUE(first);
  EXPECT_EQ(first->goal(), "a");
  EXPECT_FALSE(goals_.next_to_resolve());
  goals_.answer(yes(*first), now_);
  EXPECT_EQ(goals_.next_to_resolve()->goal(), "b");
}

TEST_F(GoalManagerTest, RejectsTheOldestGoalsAboveTheMostThatMayWait) {
  for (int i = 0; i < 1000; ++i) goals_.receive(goal("g" + std::to_string(i)), now_);
  const Statuses rejected = statuses();
  ASSERT_EQ(rejected.size(), 1000U - 64U);
  EXPECT_EQ(rejected.front().first, "g0");
  EXPECT_EQ(rejected.back().first, "g935");
  EXPECT_EQ(rejected.front().second, msg::GoalState::GOAL_REJECTED);
  EXPECT_EQ(statuses_.front().cause().text(), "64 later goals of this arm wait");
  EXPECT_EQ(goals_.next_to_resolve()->goal(), "g936");
  goals_.receive(goal("later"), now_);
  EXPECT_TRUE(statuses().empty()) << "it has a place";
}

TEST_F(GoalManagerTest, CancelsWaitingResolvingAndActiveGoals) {
  msg::Goal active = goal("active");
  msg::Goal asked = goal("asked");
  msg::Goal waiting = goal("waiting");
  send_and_accept(active);
  goals_.receive(asked, now_);
  goals_.receive(waiting, now_);
  ASSERT_TRUE(goals_.next_to_resolve());
  (void)statuses();
  for (msg::Goal* each : {&waiting, &asked, &active}) {
    each->cancel(true);
    goals_.receive(*each, now_);
  }
  EXPECT_EQ(statuses(),
            (Statuses{{"waiting", msg::GoalState::GOAL_CANCELLED}, {"active", msg::GoalState::GOAL_CANCELLED}}));
  EXPECT_TRUE(takes_cancellation()) << "the arm brakes and stays";
  EXPECT_FALSE(goals_.answer(yes(asked), now_));
  EXPECT_EQ(statuses(), (Statuses{{"asked", msg::GoalState::GOAL_CANCELLED}}));
  EXPECT_FALSE(goals_.has_active());
}

TEST_F(GoalManagerTest, ReportsAGoalOfWhichOnlyTheCancellationArrivesAsCancelled) {
  goals_.receive(cancellation("a"), now_);
  goals_.answer_unknown_cancellations(now_ + 900ms);
  EXPECT_EQ(statuses(), Statuses{}) << "the goal may still arrive";
  goals_.answer_unknown_cancellations(now_ + 1s);
  ASSERT_EQ(statuses(), (Statuses{{"a", msg::GoalState::GOAL_CANCELLED}}));
  EXPECT_EQ(statuses_[0].cause().kind(), msg::CauseKind::CAUSE_GOAL_CANCELLED);
  EXPECT_FALSE(goals_.take_change()) << "the arm has no goal less";
  goals_.receive(cancellation("a"), now_ + 2s);
  goals_.answer_unknown_cancellations(now_ + 9s);
  EXPECT_EQ(statuses(), Statuses{}) << "it is answered once";
}

TEST_F(GoalManagerTest, CancelsAGoalThatArrivesAfterItsCancellation) {
  goals_.receive(cancellation("a"), now_);
  goals_.receive(goal("a"), now_);
  EXPECT_EQ(statuses(), (Statuses{{"a", msg::GoalState::GOAL_CANCELLED}}));
  EXPECT_FALSE(goals_.next_to_resolve());
  goals_.answer_unknown_cancellations(now_ + 9s);
  EXPECT_EQ(statuses(), Statuses{});
}

// A status with CANCELLED would displace the one that tells how the goal ended.
TEST_F(GoalManagerTest, KeepsTheFinalStatusOfACancelledGoal) {
  send_and_accept(goal("reached"));
  goals_.progress(in(msg::GoalState::GOAL_REACHED), now_);
  goals_.receive(goal("rejected"), now_);
  (void)goals_.answer(no(goals_.next_to_resolve().value()), now_);
  (void)goals_.follow(status_of_the_other("of another planner", msg::GoalState::GOAL_REACHED), now_);
  for (std::size_t i = 0; i < 2 * GoalSnapshot::kResults; ++i) send_and_accept(goal("later" + std::to_string(i)));
  (void)statuses();
  for (const auto* name : {"reached", "rejected", "of another planner"}) goals_.receive(cancellation(name), now_);
  goals_.answer_unknown_cancellations(now_ + 9s);
  EXPECT_EQ(statuses(), Statuses{});
  EXPECT_TRUE(goals_.has_active());
}

TEST_F(GoalManagerTest, AnswersAnUnknownCancellationOnlyInCharge) {
  goals_.receive(cancellation("answered by the other"), now_);
  goals_.receive(cancellation("followed"), now_);
  goals_.receive(cancellation("unknown"), now_);
  for (int i = 0; i < 5; ++i) goals_.restart_waits(now_ += 1s);
  EXPECT_EQ(statuses(), Statuses{}) << "a standby";
  (void)goals_.follow(status_of_the_other("answered by the other", msg::GoalState::GOAL_CANCELLED), now_);
  ASSERT_TRUE(goals_.follow(status_of_the_other("followed", msg::GoalState::GOAL_ACTIVE), now_));
  (void)goals_.take_change();
  goals_.answer_unknown_cancellations(now_);
  EXPECT_EQ(statuses(), (Statuses{{"followed", msg::GoalState::GOAL_CANCELLED}})) << "the arm moved to it";
  EXPECT_TRUE(takes_cancellation());
  goals_.answer_unknown_cancellations(now_ + 1s);
  EXPECT_EQ(statuses(), (Statuses{{"unknown", msg::GoalState::GOAL_CANCELLED}}));
}

TEST_F(GoalManagerTest, AnswersManyUnknownCancellationsOneByOne) {
  constexpr int kMany = 3000;
  for (int i = 0; i < kMany; ++i) goals_.receive(cancellation(std::to_string(i)), now_);
  now_ += 1s;
  std::size_t answered = 0;
  for (int i = 0; i < 4 * kMany; ++i) {
    goals_.answer_unknown_cancellations(now_ += 10ms);
    const std::size_t count = statuses().size();
    EXPECT_LE(count, i % 2 == 0 ? 1U : 0U) << i;
    answered += count;
  }
  EXPECT_EQ(answered, GoalSnapshot::kHandled) << "those that it remembers";
}

TEST_F(GoalManagerTest, EndsAGoalAtItsTimeLimitWithTheCause) {
  send_and_accept(goal("a", 0.5));
  goals_.progress(in(msg::GoalState::GOAL_BLOCKED, cause("pallet in the way")), now_ + 500ms);
  EXPECT_TRUE(goals_.has_active());
  (void)statuses();
  goals_.progress(in(msg::GoalState::GOAL_BLOCKED, cause("pallet in the way")), now_ + 510ms);
  ASSERT_EQ(statuses(), (Statuses{{"a", msg::GoalState::GOAL_TIMED_OUT}}));
  EXPECT_EQ(statuses_[0].cause().kind(), msg::CauseKind::CAUSE_TIME_LIMIT);
  EXPECT_EQ(statuses_[0].cause().text(), "not reached within 0.5 s: pallet in the way");
  EXPECT_TRUE(takes_cancellation());
}

TEST_F(GoalManagerTest, RejectsGoalsThatWaitTooLong) {
  goals_.receive(goal("a"), now_);
  goals_.receive(goal("b"), now_ + 2s);
  goals_.reject_expired(now_ + 3s, 3s, cause("no world"));
  EXPECT_EQ(statuses(), Statuses{});
  goals_.reject_expired(now_ + 4s, 3s, cause("no world"));
  ASSERT_EQ(statuses(), (Statuses{{"a", msg::GoalState::GOAL_REJECTED}}));
  EXPECT_EQ(statuses_[0].cause().text(), "no world");
  EXPECT_EQ(goals_.next_to_resolve()->goal(), "b");
}

TEST_F(GoalManagerTest, RejectsAllGoalsAndIgnoresALateAnswer) {
  send_and_accept(goal("active"));
  for (const auto* name : {"asked", "waiting"}) goals_.receive(goal(name), now_);
  const auto question = goals_.next_to_resolve();
  ASSERT_TRUE(question);
  (void)statuses();
  goals_.reject_all(cause("the thread does not answer"));
  EXPECT_EQ(statuses(),
            (Statuses{{"asked", msg::GoalState::GOAL_REJECTED}, {"waiting", msg::GoalState::GOAL_REJECTED}}));
  EXPECT_EQ(statuses_[0].cause().text(), "the thread does not answer");
  EXPECT_TRUE(goals_.has_active());
  goals_.receive(goal("next"), now_);
  EXPECT_FALSE(goals_.next_to_resolve()) << "the first goal is still being resolved";
  goals_.reject_all(cause("the thread does not answer"));
  EXPECT_EQ(statuses(), (Statuses{{"next", msg::GoalState::GOAL_REJECTED}})) << "one status each";
  EXPECT_EQ(goals_.snapshot(now_).handled.size(), 4U) << "answered goals are in the snapshot";
  EXPECT_FALSE(goals_.answer(yes(*question), now_));
  EXPECT_TRUE(statuses().empty());
  send_and_accept(goal("after"));
  EXPECT_EQ(statuses().back(), (Statuses::value_type{"after", msg::GoalState::GOAL_ACCEPTED}));
}

TEST_F(GoalManagerTest, EndsAllGoalsWhenTheDeviceStops) {
  send_and_accept(goal("active"));
  goals_.receive(goal("waiting"), now_);
  (void)statuses();
  goals_.end_all(cause("protective stop"), now_);
  EXPECT_EQ(statuses(),
            (Statuses{{"active", msg::GoalState::GOAL_CANCELLED}, {"waiting", msg::GoalState::GOAL_REJECTED}}));
  EXPECT_EQ(statuses_[0].cause().text(), "protective stop");
  EXPECT_FALSE(goals_.has_active());
  goals_.end_all(cause("protective stop"), now_);
  EXPECT_TRUE(statuses().empty());
}

TEST_F(GoalManagerTest, ReportsACancelledGoalAsCancelledWhenAllAreRejected) {
  msg::Goal asked = goal("asked");
  goals_.receive(asked, now_);
  ASSERT_TRUE(goals_.next_to_resolve());
  asked.cancel(true);
  goals_.receive(asked, now_);
  goals_.reject_all(cause("the thread does not answer"));
  EXPECT_EQ(statuses(), (Statuses{{"asked", msg::GoalState::GOAL_CANCELLED}}));
  EXPECT_EQ(statuses_[0].cause().text(), "its client cancelled it");
}

TEST_F(GoalManagerTest, CountsWaitingFromTakingCharge) {
  goals_.receive(goal("a"), now_);
  goals_.restart_waits(now_ + 5s);
  goals_.reject_expired(now_ + 6s, 3s, cause("no driver"));
  EXPECT_EQ(statuses(), Statuses{});
  goals_.reject_expired(now_ + 9s, 3s, cause("no driver"));
  EXPECT_EQ(statuses(), (Statuses{{"a", msg::GoalState::GOAL_REJECTED}}));
}

TEST_F(GoalManagerTest, IgnoresRepetitionsAndGoalsOfOtherArms) {
  const msg::Goal once = goal("a");
  send_and_accept(once);
  goals_.receive(once, now_);
  msg::Goal other = goal("b");
  other.arm("arm2");
  goals_.receive(other, now_);
  EXPECT_FALSE(goals_.next_to_resolve());
}

/// What a goal of the tool needs for its final check.
planner::ToolGoal tool_goal() {
  return {.X_WT = world::pose_from_xyz_rpy({0.1, 0.2, 0.3}, {0.4, 0.5, 0.6}),
          .free_rotation = planner::FreeRotation::kYaw,
          .position_tolerance = 0.005};
}

TEST_F(GoalManagerTest, ReportsTheMeasuredErrorOfTheTool) {
  goals_.receive(goal("a"), now_);
  GoalAnswer accepted = yes(goals_.next_to_resolve().value());
  accepted.tool = tool_goal();
  accepted.note = "joint x becomes 3";
  ASSERT_TRUE(goals_.answer(accepted, now_));
  ASSERT_TRUE(goals_.tool());
  EXPECT_EQ(*goals_.tool(), tool_goal());
  (void)statuses();
  EXPECT_TRUE(statuses_[0].has_tool());
  EXPECT_EQ(statuses_[0].tool().free_rotation(), msg::FreeRotation::FREE_YAW);
  EXPECT_EQ(statuses_[0].note(), "joint x becomes 3");
  EXPECT_LT(statuses_[0].position_error(), 0.0) << "not measured yet";
  Progress progress = in(msg::GoalState::GOAL_REACHED);
  progress.tool_error = {0.001, 0.02};
  goals_.progress(progress, now_);
  (void)statuses();
  EXPECT_EQ(statuses_[0].position_error(), 0.001);
  EXPECT_EQ(statuses_[0].orientation_error(), 0.02);
}

TEST_F(GoalManagerTest, ReportsTheNearestOrientationOfARejectedGoal) {
  goals_.receive(goal("a"), now_);
  GoalAnswer answer = no(goals_.next_to_resolve().value());
  answer.nearest = planner::NearestOrientation{{}, tool_goal().X_WT, 0.8};
  EXPECT_FALSE(goals_.answer(answer, now_));
  EXPECT_EQ(statuses(), (Statuses{{"a", msg::GoalState::GOAL_REJECTED}}));
  EXPECT_TRUE(statuses_[0].has_nearest());
  EXPECT_EQ(statuses_[0].nearest_angle(), 0.8);
  EXPECT_EQ(statuses_[0].X_WT_nearest().position().y(), 0.2);
}

TEST_F(GoalManagerTest, FollowsTheGoalOfATool) {
  msg::GoalStatus status = status_of_the_other("a", msg::GoalState::GOAL_ACTIVE);
  ASSERT_TRUE(goals_.follow(status, now_));
  EXPECT_FALSE(goals_.tool());
  status = status_of_the_other("b", msg::GoalState::GOAL_ACTIVE);
  status.has_tool(true);
  status.tool(messages::to_message(tool_goal()));
  ASSERT_TRUE(goals_.follow(status, now_));
  ASSERT_TRUE(goals_.tool());
  EXPECT_TRUE(goals_.tool()->X_WT.isApprox(tool_goal().X_WT, 1e-12));
  EXPECT_EQ(goals_.tool()->position_tolerance, 0.005);
}

TEST_F(GoalManagerTest, FollowsAnUnknownGoal) {
  EXPECT_TRUE(goals_.follow(status_of_the_other("a", msg::GoalState::GOAL_ACTIVE), now_));
  EXPECT_EQ(goals_.q_goal()[0], 0.5);
  EXPECT_FALSE(goals_.follow(status_of_the_other("a", msg::GoalState::GOAL_ACTIVE), now_)) << "it is active already";
  EXPECT_TRUE(statuses().empty()) << "the planner in charge reports";
  goals_.progress(in(msg::GoalState::GOAL_REACHED), now_);
  EXPECT_EQ(statuses(), (Statuses{{"a", msg::GoalState::GOAL_REACHED}}));
  EXPECT_GT(statuses_[0].elapsed(), 1.9);
  EXPECT_FALSE(goals_.follow(status_of_the_other("a", msg::GoalState::GOAL_ACTIVE), now_)) << "it has ended here";
}

TEST_F(GoalManagerTest, RecognisesAFollowedGoalOfItsClient) {
  ASSERT_TRUE(goals_.follow(status_of_the_other("a", msg::GoalState::GOAL_ACTIVE), now_));
  goals_.receive(goal("a", 60.0), now_);
  EXPECT_FALSE(goals_.next_to_resolve());
  EXPECT_TRUE(goals_.has_active());
  EXPECT_TRUE(statuses().empty());
}

/// One joint to `q` within 4 s.
msg::Goal with_trajectory(msg::Goal goal, double q) {
  goal.kind(msg::GoalKind::GOAL_TRAJECTORY);
  goal.trajectory().time({0.0, 4.0});
  goal.trajectory().q({0.0, q});
  return goal;
}
GoalAnswer yes_to_trajectory(const msg::Goal& goal) {
  const auto trajectory = messages::from_message(goal.trajectory(), "trajectory", 1);
  return {.goal = goal,
          .q_goal = trajectory->end(),
          .trajectory = std::make_shared<const planner::TimedTrajectory>(*trajectory)};
}
/// The arm has come to `time`.
Progress on_trajectory(double time) {
  Progress progress;
  progress.trajectory = Progress::Trajectory{time, 0.5, planner::JointVector::Constant(1, 0.25)};
  return progress;
}

TEST_F(GoalManagerTest, ReportsTheTimeInATrajectoryAndWhereTheArmGoesNext) {
  goals_.receive(with_trajectory(goal("g"), 1.0), now_);
  ASSERT_TRUE(goals_.answer(yes_to_trajectory(*goals_.next_to_resolve()), now_));
  const auto change = goals_.take_change();
  ASSERT_TRUE(change && change->q_goal && change->trajectory);
  EXPECT_EQ(change->trajectory_time, 0.0);
  goals_.progress(on_trajectory(1.5), now_ + 1s);
  statuses();
  EXPECT_EQ(statuses_.back().trajectory_time(), 1.5);
  EXPECT_EQ(statuses_.back().trajectory_rate(), 0.5);
  EXPECT_EQ(statuses_.back().q_goal(), std::vector<double>{0.25});
  Progress reached = on_trajectory(4.0);
  reached.state = msg::GoalState::GOAL_REACHED;
  goals_.progress(reached, now_ + 5s);
  statuses();
  EXPECT_EQ(statuses_.back().q_goal(), std::vector<double>{1.0});
}

TEST_F(GoalManagerTest, EndsATrajectoryWhosePathIsLeft) {
  goals_.receive(with_trajectory(goal("g"), 1.0), now_);
  ASSERT_TRUE(goals_.answer(yes_to_trajectory(*goals_.next_to_resolve()), now_));
  (void)goals_.take_change();
  Progress progress = on_trajectory(1.5);
  progress.trajectory->left = make_cause(msg::CauseKind::CAUSE_PATH_TOLERANCE, "joint1", "joint1 is outside");
  goals_.progress(progress, now_ + 1s);
  EXPECT_EQ(statuses().back(), std::pair(std::string("g"), msg::GoalState::GOAL_CANCELLED));
  EXPECT_EQ(statuses_.back().cause().kind(), msg::CauseKind::CAUSE_PATH_TOLERANCE);
  EXPECT_TRUE(takes_cancellation());
}

/// Of another planner, whose arm follows a trajectory that this one has not received.
msg::GoalStatus on_trajectory_status() {
  msg::GoalStatus status;
  status.arm("arm1");
  status.goal("g");
  status.state(msg::GoalState::GOAL_ACTIVE);
  status.q_goal({0.25});
  status.trajectory_time(1.5);
  return status;
}

// It knows the goal from a status, and stands until it has the trajectory.
TEST_F(GoalManagerTest, AwaitsTheTrajectoryOfAFollowedGoal) {
  const msg::Goal sent = with_trajectory(goal("g"), 1.0);
  ASSERT_TRUE(goals_.follow(on_trajectory_status(), now_));
  EXPECT_TRUE(takes_cancellation());
  EXPECT_TRUE(goals_.awaits_trajectory());
  goals_.receive(sent, now_);
  EXPECT_FALSE(goals_.next_to_resolve()) << "another planner has accepted it";
  const auto change = goals_.take_change();
  ASSERT_TRUE(change && change->trajectory);
  EXPECT_EQ(change->trajectory_time, 1.5);
  EXPECT_EQ((*change->q_goal)[0], 1.0);
}

TEST_F(GoalManagerTest, CancelsAGoalWhoseTrajectoryDoesNotArrive) {
  ASSERT_TRUE(goals_.follow(on_trajectory_status(), now_));
  goals_.progress(in(msg::GoalState::GOAL_ACTIVE), now_);
  goals_.progress(in(msg::GoalState::GOAL_ACTIVE), now_ + 9s);
  EXPECT_EQ(statuses().back().second, msg::GoalState::GOAL_BLOCKED);
  goals_.progress(in(msg::GoalState::GOAL_ACTIVE), now_ + 11s);
  EXPECT_EQ(statuses().back().second, msg::GoalState::GOAL_CANCELLED);
  EXPECT_EQ(statuses_.back().cause().kind(), msg::CauseKind::CAUSE_GOAL_NOT_RESOLVED);
}

TEST_F(GoalManagerTest, EndsGoalsThatThePlannerInChargeEnded) {
  send_and_accept(goal("a"));
  static_cast<void>(statuses());
  EXPECT_FALSE(goals_.follow(status_of_the_other("a", msg::GoalState::GOAL_CANCELLED), now_));
  EXPECT_FALSE(goals_.has_active());
  EXPECT_TRUE(takes_cancellation());
  send_and_accept(goal("b"));
  EXPECT_FALSE(goals_.follow(status_of_the_other("a", msg::GoalState::GOAL_REACHED), now_));
  EXPECT_TRUE(goals_.has_active()) << "a status of another goal";
  EXPECT_FALSE(goals_.follow(status_of_the_other("b", msg::GoalState::GOAL_REACHED), now_));
  EXPECT_FALSE(takes_cancellation()) << "the arm keeps its place";
}

class Restarted : public GoalManagerTest {
 protected:
  /// A goal manager that resumes from the present snapshot.
  GoalManager successor(GoalManager::Clock::duration ago = 0s) {
    GoalManager other("arm1", "planner/arm1");
    resumed_ = other.resume(goals_.snapshot(now_), ago, now_ + ago);
    return other;
  }
  static Statuses statuses_of(GoalManager& other) {
    Statuses list;
    for (const auto& status : other.take_statuses()) list.emplace_back(status.goal(), status.state());
    return list;
  }
  bool resumed_ = false;
};

TEST_F(Restarted, ResumesAGoalWhoseStatusWasNotPublished) {
  const msg::Goal a = goal("a");
  send_and_accept(a);  // its status is not published
  GoalManager other = successor();
  EXPECT_TRUE(resumed_);
  ASSERT_TRUE(other.has_active());
  EXPECT_EQ(other.q_goal(), planner::JointVector::Zero(1));
  EXPECT_EQ(statuses_of(other), (Statuses{{"a", msg::GoalState::GOAL_ACTIVE}}));
  // The bus delivers the goal of its client to the restarted planner.
  other.receive(a, now_);
  EXPECT_FALSE(other.next_to_resolve());
  other.progress(in(msg::GoalState::GOAL_REACHED), now_);
  EXPECT_EQ(statuses_of(other), (Statuses{{"a", msg::GoalState::GOAL_REACHED}}));
}

TEST_F(Restarted, ChecksTheToolOfItsGoal) {
  goals_.receive(goal("a"), now_);
  GoalAnswer accepted = yes(goals_.next_to_resolve().value());
  accepted.tool = tool_goal();
  ASSERT_TRUE(goals_.answer(accepted, now_));
  GoalManager other = successor();
  ASSERT_TRUE(other.tool());
  EXPECT_EQ(*other.tool(), tool_goal());
}

TEST_F(Restarted, IgnoresAReplacedGoalOfItsClient) {
  const msg::Goal a = goal("a");
  send_and_accept(a);
  send_and_accept(goal("b"));
  GoalManager other = successor();
  EXPECT_EQ(statuses_of(other), (Statuses{{"a", msg::GoalState::GOAL_REPLACED}, {"b", msg::GoalState::GOAL_ACTIVE}}));
  other.receive(a, now_);
  EXPECT_FALSE(other.next_to_resolve());
}

TEST_F(Restarted, PublishesAResultAgain) {
  send_and_accept(goal("a"));
  msg::Goal withdrawn = goal("a");
  withdrawn.cancel(true);
  goals_.receive(withdrawn, now_);
  GoalManager other = successor();
  EXPECT_FALSE(resumed_);
  EXPECT_FALSE(other.has_active());
  EXPECT_EQ(statuses_of(other), (Statuses{{"a", msg::GoalState::GOAL_CANCELLED}}));
}

TEST_F(Restarted, AnswersAnUnknownCancellationAgain) {
  const msg::Goal unanswered = cancellation("a");
  goals_.receive(unanswered, now_);
  GoalManager other = successor();
  other.receive(unanswered, now_);
  other.answer_unknown_cancellations(now_ + 1s);
  EXPECT_EQ(statuses_of(other), (Statuses{{"a", msg::GoalState::GOAL_CANCELLED}}));
  GoalManager third("arm1", "planner/arm1");
  (void)third.resume(other.snapshot(now_), 0s, now_);
  third.receive(unanswered, now_);
  (void)third.take_statuses();
  third.answer_unknown_cancellations(now_ + 9s);
  EXPECT_EQ(statuses_of(third), Statuses{}) << "it is answered";
}

TEST_F(Restarted, ResolvesUnansweredGoalsAgain) {
  const msg::Goal asked = goal("asked");
  const msg::Goal waiting = goal("waiting");
  goals_.receive(asked, now_);
  goals_.receive(waiting, now_);
  ASSERT_TRUE(goals_.next_to_resolve());
  GoalManager other = successor();
  EXPECT_FALSE(resumed_);
  other.receive(asked, now_);
  other.receive(waiting, now_);
  const auto question = other.next_to_resolve();
  ASSERT_TRUE(question);
  EXPECT_EQ(question->goal(), "asked");
  (void)other.answer(yes(*question), now_);
  EXPECT_TRUE(other.next_to_resolve());
}

TEST_F(Restarted, CountsTheTimeLimitDuringTheRestart) {
  send_and_accept(goal("a", 5.0));
  now_ += 2s;
  GoalManager other = successor(2s);
  (void)statuses_of(other);
  other.progress(in(msg::GoalState::GOAL_ACTIVE), now_ + 2900ms);
  EXPECT_TRUE(other.has_active()) << "4.9 s after it was accepted";
  other.progress(in(msg::GoalState::GOAL_ACTIVE), now_ + 3100ms);
  EXPECT_FALSE(other.has_active());
  EXPECT_EQ(statuses_of(other).back().second, msg::GoalState::GOAL_TIMED_OUT);
}

TEST_F(Restarted, KeepsItsSnapshotOverTwoRestarts) {
  const msg::Goal a = goal("a");
  const msg::Goal b = goal("b");
  send_and_accept(a);
  send_and_accept(b);
  GoalManager other = successor();
  const GoalSnapshot first = goals_.snapshot(now_);
  EXPECT_TRUE(other.snapshot(now_) == first);
  EXPECT_EQ(first.handled.size(), 2U);
}

// A standby planner publishes only the results that the planner in charge has not published.
TEST_F(Restarted, PublishesOnlyUnpublishedResults) {
  for (const auto* name : {"a", "b", "c"}) send_and_accept(goal(name));
  goals_.keep_results({{"b", msg::GoalState::GOAL_REACHED}});
  GoalManager other = successor();
  EXPECT_EQ(statuses_of(other), (Statuses{{"b", msg::GoalState::GOAL_REACHED}, {"c", msg::GoalState::GOAL_ACTIVE}}));
  std::vector<GoalSnapshot::Result> many;
  for (std::size_t i = 0; i < GoalSnapshot::kResults + 2; ++i)
    many.push_back({std::to_string(i), msg::GoalState::GOAL_REACHED});
  goals_.keep_results(many);
  EXPECT_EQ(goals_.snapshot(now_).results, std::vector(many.begin() + 2, many.end())) << "the last";
}

TEST_F(GoalManagerTest, RejectsANameTooLongForTheCheckpoint) {
  goals_.receive(goal(std::string(GoalSnapshot::kLongestName + 1, 'x')), now_);
  EXPECT_FALSE(ask_and_accept());
  ASSERT_EQ(statuses().back().second, msg::GoalState::GOAL_REJECTED);
  EXPECT_EQ(statuses_.back().cause().text(), "the names of a goal and of its client must have at most 255 bytes");
  send_and_accept(goal(std::string(GoalSnapshot::kLongestName, 'x')));
}

}  // namespace
}  // namespace hecaton::services
