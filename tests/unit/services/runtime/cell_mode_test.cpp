#include "services/runtime/cell_mode.hpp"

#include <chrono>

#include <gtest/gtest.h>

namespace hecaton::services {
namespace {

msg::CellMode mode(msg::Mode kind, std::uint64_t term) {
  msg::CellMode message;
  message.mode(kind);
  message.term(term);
  return message;
}

TEST(CellModeView, BeforeAnyIsHeardNothingMoves) {
  const CellModeView view;
  EXPECT_EQ(view.order("arm1"), ArmOrder::kUnheard);
  EXPECT_EQ(view.why("arm1"), "no supervisor was heard yet");
  EXPECT_EQ(view.term(), 0U);
}

TEST(CellModeView, TheStricterOfCellAndArmCounts) {
  CellModeView view;
  msg::CellMode message = mode(msg::Mode::MODE_RUN, 1);
  message.held_arms({"arm2"});
  message.stopped_arms({"arm3"});
  ASSERT_TRUE(view.apply(message));
  EXPECT_EQ(view.order("arm1"), ArmOrder::kRun);
  EXPECT_EQ(view.order("arm2"), ArmOrder::kHold);
  EXPECT_EQ(view.order("arm3"), ArmOrder::kStop);
  message.mode(msg::Mode::MODE_HOLD);
  message.reason("door");
  view.apply(message);
  EXPECT_EQ(view.order("arm1"), ArmOrder::kHold);
  EXPECT_EQ(view.order("arm3"), ArmOrder::kStop);
  EXPECT_EQ(view.why("arm1"), "the cell is held: door");
  EXPECT_EQ(view.why("arm3"), "the arm is stopped: door");
}

TEST(CellModeView, AnOlderTermIsIgnoredAndTheSameTermIsNot) {
  CellModeView view;
  ASSERT_TRUE(view.apply(mode(msg::Mode::MODE_STOP, 5)));
  EXPECT_FALSE(view.apply(mode(msg::Mode::MODE_RUN, 4)));
  EXPECT_EQ(view.order("arm1"), ArmOrder::kStop);
  EXPECT_EQ(view.term(), 5U);
  EXPECT_TRUE(view.apply(mode(msg::Mode::MODE_RUN, 5)));
  EXPECT_EQ(view.order("arm1"), ArmOrder::kRun);
}

TEST(CellModeView, AForgottenOrderIsHeardAgainWithinItsTermOnly) {
  CellModeView view;
  ASSERT_TRUE(view.apply(mode(msg::Mode::MODE_RUN, 5)));
  view.forget_order();
  EXPECT_EQ(view.order("arm1"), ArmOrder::kUnheard);
  EXPECT_EQ(view.why("arm1"), "no supervisor was heard since this process was stopped and away");
  EXPECT_FALSE(view.apply(mode(msg::Mode::MODE_RUN, 4)));
  EXPECT_EQ(view.order("arm1"), ArmOrder::kUnheard);
  ASSERT_TRUE(view.apply(mode(msg::Mode::MODE_STOP, 5)));
  EXPECT_EQ(view.order("arm1"), ArmOrder::kStop);
}

// Of a healed partition, or of a supervisor that is started again without its memory.
TEST(CellModeView, AnOrderThatTheNextLeaderDoesNotKnowHoldsUntilItHadTimeToHearOfIt) {
  using namespace std::chrono_literals;
  const bus::Clock::time_point start{};
  msg::CellMode before = mode(msg::Mode::MODE_RUN, 5);
  before.node("supervisor");
  before.stopped_arms({"arm1"});
  before.arms_ordered_to_hold({"arm2"});
  before.held_arms({"arm2", "arm3"});  // the last one by a fault, as its leader saw it
  before.reason("arm1: stop by operator");
  msg::CellMode next = mode(msg::Mode::MODE_RUN, 6);
  next.node("supervisor@beta");
  CellModeView view;
  ASSERT_TRUE(view.apply(before, start));
  ASSERT_TRUE(view.apply(next, start + 5s));
  EXPECT_EQ(view.order("arm1"), ArmOrder::kStop);
  EXPECT_EQ(view.order("arm2"), ArmOrder::kHold);
  EXPECT_EQ(view.order("arm3"), ArmOrder::kRun);
  EXPECT_EQ(
      view.why("arm1"),
      "supervisor@beta has begun to lead and does not know of an order of supervisor yet: arm1: stop by operator");
  EXPECT_EQ(view.mandate("arm1"), (Mandate{"", 6}));
  ASSERT_TRUE(view.apply(next, start + 5s + CellModeView::kDoubt - 1ms));
  EXPECT_EQ(view.order("arm1"), ArmOrder::kStop);
  ASSERT_TRUE(view.apply(next, start + 5s + CellModeView::kDoubt));
  EXPECT_EQ(view.order("arm1"), ArmOrder::kRun);
  EXPECT_EQ(view.order("arm2"), ArmOrder::kRun);
}

TEST(CellModeView, WhatTheNextLeaderKnowsIsResumedAtOnce) {
  CellModeView view;
  msg::CellMode before = mode(msg::Mode::MODE_STOP, 5);
  before.ordered(msg::Mode::MODE_STOP);
  ASSERT_TRUE(view.apply(before));
  msg::CellMode next = before;
  next.term(6);
  ASSERT_TRUE(view.apply(next));
  ASSERT_TRUE(view.apply(mode(msg::Mode::MODE_RUN, 6)));
  EXPECT_EQ(view.order("arm1"), ArmOrder::kRun);
}

TEST(CellModeView, AnArmIsCommandedByWhomTheGrantNamesOrUnderTheCellsTerm) {
  CellModeView view;
  EXPECT_EQ(view.mandate("arm1"), Mandate());
  msg::CellMode message = mode(msg::Mode::MODE_RUN, 3);
  msg::Grant& grant = message.grants().emplace_back();
  grant.arm("arm1");
  grant.planner("planner/arm1@beta");
  grant.term(8);
  ASSERT_TRUE(view.apply(message));
  EXPECT_EQ(view.mandate("arm1"), (Mandate{"planner/arm1@beta", 8}));
  EXPECT_EQ(view.mandate("arm2"), (Mandate{"", 3}));
}

}  // namespace
}  // namespace hecaton::services
