// What makes a planner stand by and take over, without a network.

#include <gtest/gtest.h>

#include "services/planner/duty.hpp"
#include "services/planner/unsaid_statuses.hpp"

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

TEST(Unsaid, IsWhatThePlannerInChargeDidNotLiveToTell) {
  UnsaidStatuses unsaid;
  unsaid.keep({status("a", msg::GOAL_ACTIVE), status("a", msg::GOAL_REACHED), status("b", msg::GOAL_REJECTED)});
  unsaid.heard(status("a", msg::GOAL_ACTIVE));
  unsaid.heard(status("b", msg::GOAL_REJECTED));
  const auto left = unsaid.take();
  ASSERT_EQ(left.size(), 1U);
  EXPECT_EQ(left[0].goal(), "a");
  EXPECT_EQ(left[0].state(), msg::GOAL_REACHED);
  EXPECT_TRUE(unsaid.take().empty());
}

TEST(Unsaid, IsNothingThatWasToldBeforeItWasKnownHere) {
  UnsaidStatuses unsaid;
  unsaid.heard(status("a", msg::GOAL_REACHED));
  unsaid.keep({status("a", msg::GOAL_REACHED)});
  EXPECT_TRUE(unsaid.take().empty());
}

}  // namespace
}  // namespace hecaton::services
