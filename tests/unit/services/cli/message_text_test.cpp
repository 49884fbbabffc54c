#include "services/cli/message_text.hpp"

#include <gtest/gtest.h>

#include "services/runtime/cause.hpp"

namespace hecaton::services::cli {
namespace {

msg::GoalStatus blocked() {
  msg::GoalStatus goal;
  goal.state(msg::GoalState::GOAL_BLOCKED);
  goal.reason("no way for now");
  goal.has_binding(true);
  goal.binding_own("arm2/forearm");
  goal.binding_other("pallet");
  goal.binding_distance(0.018);
  goal.trying("draws another subspace");
  return goal;
}

TEST(GoalText, TellsWhyAndWhatIsTried) {
  EXPECT_EQ(goal_text(blocked()), "blocked: no way for now (arm2/forearm – pallet, 18 mm); draws another subspace");
}

TEST(GoalText, TellsWhatBindsWithoutReason) {
  msg::GoalStatus goal = blocked();
  goal.reason("");
  goal.trying("");
  EXPECT_EQ(goal_text(goal), "blocked: arm2/forearm – pallet, 18 mm");
}

TEST(GoalText, TellsSinceWhen) {
  msg::GoalStatus goal = blocked();
  goal.held_for(3.2);
  EXPECT_EQ(goal_text(goal),
            "blocked: no way for now (arm2/forearm – pallet, 18 mm), for 3.20 s; draws another subspace");
}

TEST(GoalText, TriesNothingAnyMoreAtTheEnd) {
  msg::GoalStatus goal = blocked();
  goal.state(msg::GoalState::GOAL_TIMED_OUT);
  EXPECT_EQ(goal_text(goal), "timed_out: no way for now (arm2/forearm – pallet, 18 mm)");
  goal.state(msg::GoalState::GOAL_REACHED);
  EXPECT_EQ(goal_text(goal), "reached");
}

TEST(WaitingText, PrefersTheSupervisorsReason) {
  msg::ArmStatus arm;
  EXPECT_EQ(waiting_text(arm), "");
  arm.has_goal(true);
  arm.goal(blocked());
  EXPECT_EQ(waiting_text(arm), "no way for now (arm2/forearm – pallet, 18 mm); draws another subspace");
  arm.waiting_for(make_cause(msg::CauseKind::CAUSE_HOLD_ORDERED, {}, "the cell is on hold"));
  EXPECT_EQ(waiting_text(arm), "the cell is on hold");
}

TEST(IsFinal, EndsWithAllButThreeStates) {
  for (const msg::GoalState state :
       {msg::GoalState::GOAL_ACCEPTED, msg::GoalState::GOAL_ACTIVE, msg::GoalState::GOAL_BLOCKED}) {
    EXPECT_FALSE(is_final(state)) << text(state);
  }
  for (const msg::GoalState state :
       {msg::GoalState::GOAL_REACHED, msg::GoalState::GOAL_REJECTED, msg::GoalState::GOAL_CANCELLED,
        msg::GoalState::GOAL_REPLACED, msg::GoalState::GOAL_TIMED_OUT}) {
    EXPECT_TRUE(is_final(state)) << text(state);
  }
}

TEST(RefereeText, CountsContacts) {
  msg::RefereeReport report;
  EXPECT_EQ(referee_text(report, Palette(false)), "0 contacts, nothing judged yet");
  report.contacts(1);
  report.judged(true);
  report.smallest().distance(-0.002);
  report.smallest().a("a/x");
  report.smallest().b("crate");
  EXPECT_EQ(referee_text(report, Palette(false)), "1 contact, smallest separation -2.0 mm (a/x – crate)");
}

TEST(FaultDuration, EndsWhenItIsCleared) {
  msg::Fault fault;
  fault.since_ns(1'000'000'000);
  fault.stamp_ns(3'000'000'000);
  EXPECT_DOUBLE_EQ(fault_duration(fault), 2.0);
  fault.cleared(true);
  fault.cleared_ns(1'500'000'000);
  EXPECT_DOUBLE_EQ(fault_duration(fault), 0.5);
}

}  // namespace
}  // namespace hecaton::services::cli
