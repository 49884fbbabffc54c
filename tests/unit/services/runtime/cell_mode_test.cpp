#include "services/runtime/cell_mode.hpp"

#include <chrono>

#include <gtest/gtest.h>

#include "services/runtime/orders.hpp"

namespace hecaton::services {
namespace {

msg::CellMode mode(msg::Mode kind, std::uint64_t term) {
  msg::CellMode message;
  message.mode(kind);
  message.term(term);
  return message;
}

msg::ArmOrder arm_order(const std::string& arm, msg::Mode mode, const std::string& why) {
  msg::ArmOrder order;
  order.arm(arm);
  order.mode(mode);
  order.ordered(mode);
  const bool stop = mode == msg::Mode::MODE_STOP;
  order.cause(make_cause(stop ? msg::CauseKind::CAUSE_STOP_ORDERED : msg::CauseKind::CAUSE_HOLD_ORDERED, arm, why));
  return order;
}

TEST(CellModeView, BeforeAnyIsHeardNothingMoves) {
  const CellModeView view;
  EXPECT_EQ(view.order("arm1"), msg::Mode::MODE_HOLD);
  EXPECT_EQ(view.why("arm1").kind(), msg::CauseKind::CAUSE_MODE_UNKNOWN);
  EXPECT_EQ(view.why("arm1").text(), "no cell mode received yet");
  EXPECT_EQ(view.term(), 0U);
}

TEST(CellModeView, TheStricterOfCellAndArmCounts) {
  CellModeView view;
  msg::CellMode message = mode(msg::Mode::MODE_RUN, 1);
  message.arms(
      {arm_order("arm2", msg::Mode::MODE_HOLD, {}), arm_order("arm3", msg::Mode::MODE_STOP, "stop by operator")});
  ASSERT_TRUE(view.apply(message));
  EXPECT_EQ(view.order("arm1"), msg::Mode::MODE_RUN);
  EXPECT_EQ(view.order("arm2"), msg::Mode::MODE_HOLD);
  EXPECT_EQ(view.order("arm3"), msg::Mode::MODE_STOP);
  message.mode(msg::Mode::MODE_HOLD);
  message.cause(make_cause(msg::CauseKind::CAUSE_HOLD_ORDERED, {}, "door"));
  view.apply(message);
  EXPECT_EQ(view.order("arm1"), msg::Mode::MODE_HOLD);
  EXPECT_EQ(view.order("arm3"), msg::Mode::MODE_STOP);
  EXPECT_EQ(view.why("arm1"), make_cause(msg::CauseKind::CAUSE_HOLD_ORDERED, {}, "the cell is held: door"));
  EXPECT_EQ(view.why("arm3"),
            make_cause(msg::CauseKind::CAUSE_STOP_ORDERED, "arm3", "the arm is stopped: stop by operator"));
}

TEST(CellModeView, TheLowerSpeedOfCellAndArmCountsAndRemainsInSilence) {
  CellModeView view;
  EXPECT_EQ(view.speed("arm1"), kSlowestSpeed) << "before any order";
  msg::CellMode message = mode(msg::Mode::MODE_RUN, 1);
  message.speed(0.5);
  msg::ArmSpeed own;
  own.arm("arm2");
  own.speed(0.3);
  message.speeds({own});
  ASSERT_TRUE(view.apply(message));
  EXPECT_EQ(view.speed("arm1"), 0.5);
  EXPECT_EQ(view.speed("arm2"), 0.3);
  view.forget_order();
  EXPECT_EQ(view.order("arm1"), msg::Mode::MODE_HOLD);
  EXPECT_EQ(view.speed("arm2"), 0.3) << "the last ordered value holds";
}

TEST(CellModeView, ANewLeaderDoesNotRaiseTheSpeedBeforeItKnowsTheOrder) {
  const bus::Clock::time_point start{};
  CellModeView view;
  msg::CellMode slow = mode(msg::Mode::MODE_RUN, 1);
  slow.speed(0.3);
  ASSERT_TRUE(view.apply(slow, start));
  ASSERT_TRUE(view.apply(mode(msg::Mode::MODE_RUN, 2), start));
  EXPECT_EQ(view.speed("arm1"), 0.3);
  slow.term(2);
  slow.speed(0.2);
  ASSERT_TRUE(view.apply(slow, start)) << "it has taken the order over";
  EXPECT_EQ(view.speed("arm1"), 0.2);
}

TEST(CellModeView, AnOlderTermIsIgnoredAndTheSameTermIsNot) {
  CellModeView view;
  ASSERT_TRUE(view.apply(mode(msg::Mode::MODE_STOP, 5)));
  EXPECT_FALSE(view.apply(mode(msg::Mode::MODE_RUN, 4)));
  EXPECT_EQ(view.order("arm1"), msg::Mode::MODE_STOP);
  EXPECT_EQ(view.term(), 5U);
  EXPECT_TRUE(view.apply(mode(msg::Mode::MODE_RUN, 5)));
  EXPECT_EQ(view.order("arm1"), msg::Mode::MODE_RUN);
}

TEST(CellModeView, ATermBelongsToTheParticipantThatPublishesIt) {
  const bus::Clock::time_point start{};
  bus::EndpointId leader;
  leader.bytes[0] = 1;
  bus::EndpointId forger;
  forger.bytes[0] = 2;
  CellModeView view;
  ASSERT_TRUE(view.apply(mode(msg::Mode::MODE_STOP, 5), start, leader));
  EXPECT_FALSE(view.apply(mode(msg::Mode::MODE_RUN, 5), start + CellModeView::kHold, forger));
  EXPECT_EQ(view.order("arm1"), msg::Mode::MODE_STOP);
  EXPECT_TRUE(view.apply(mode(msg::Mode::MODE_HOLD, 5), start + CellModeView::kHold, leader));
  EXPECT_TRUE(view.apply(mode(msg::Mode::MODE_RUN, 6), start + CellModeView::kHold, forger)) << "a greater term";
  EXPECT_TRUE(view.apply(mode(msg::Mode::MODE_RUN, 6), start + 3 * CellModeView::kHold, leader)) << "a successor";
}

TEST(CellModeView, AForgottenOrderIsHeardAgainWithinItsTermOnly) {
  CellModeView view;
  ASSERT_TRUE(view.apply(mode(msg::Mode::MODE_RUN, 5)));
  view.forget_order();
  EXPECT_EQ(view.order("arm1"), msg::Mode::MODE_HOLD);
  EXPECT_EQ(view.why("arm1").kind(), msg::CauseKind::CAUSE_MODE_UNKNOWN);
  EXPECT_EQ(view.why("arm1").text(), "no cell mode received since this process was stalled");
  EXPECT_FALSE(view.apply(mode(msg::Mode::MODE_RUN, 4)));
  EXPECT_EQ(view.why("arm1").kind(), msg::CauseKind::CAUSE_MODE_UNKNOWN);
  ASSERT_TRUE(view.apply(mode(msg::Mode::MODE_STOP, 5)));
  EXPECT_EQ(view.order("arm1"), msg::Mode::MODE_STOP);
}

// Of a healed partition, or of a supervisor that is started again without its memory.
TEST(CellModeView, AnOrderThatTheNextLeaderDoesNotKnowHoldsUntilItHadTimeToHearOfIt) {
  using namespace std::chrono_literals;
  const bus::Clock::time_point start{};
  msg::CellMode before = mode(msg::Mode::MODE_RUN, 5);
  before.node("supervisor");
  before.arms({arm_order("arm1", msg::Mode::MODE_STOP, "stop by operator"),
               arm_order("arm2", msg::Mode::MODE_HOLD, "door"),
               arm_order("arm3", msg::Mode::MODE_HOLD, "planner/arm3: dead")});
  before.arms().back().ordered(msg::Mode::MODE_RUN);  // held by a fault, as its leader saw it
  msg::CellMode next = mode(msg::Mode::MODE_RUN, 6);
  next.node("supervisor@beta");
  CellModeView view;
  ASSERT_TRUE(view.apply(before, start));
  ASSERT_TRUE(view.apply(next, start + 5s));
  EXPECT_EQ(view.order("arm1"), msg::Mode::MODE_STOP);
  EXPECT_EQ(view.order("arm2"), msg::Mode::MODE_HOLD);
  EXPECT_EQ(view.order("arm3"), msg::Mode::MODE_RUN);
  EXPECT_EQ(view.why("arm1").text(),
            "supervisor@beta leads now and does not know an order of supervisor yet: arm1: stop by operator; "
            "arm2: door; arm3: planner/arm3: dead");
  EXPECT_EQ(view.lease("arm1"), (ArmLease{"", 6}));
  ASSERT_TRUE(view.apply(next, start + 5s + CellModeView::kOrderHandover - 1ms));
  EXPECT_EQ(view.order("arm1"), msg::Mode::MODE_STOP);
  ASSERT_TRUE(view.apply(next, start + 5s + CellModeView::kOrderHandover));
  EXPECT_EQ(view.order("arm1"), msg::Mode::MODE_RUN);
  EXPECT_EQ(view.order("arm2"), msg::Mode::MODE_RUN);
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
  EXPECT_EQ(view.order("arm1"), msg::Mode::MODE_RUN);
}

TEST(CellModeView, AnArmIsCommandedByWhomTheGrantNamesOrUnderTheCellsTerm) {
  CellModeView view;
  EXPECT_EQ(view.lease("arm1"), ArmLease());
  msg::CellMode message = mode(msg::Mode::MODE_RUN, 3);
  msg::ArmLease& grant = message.leases().emplace_back();
  grant.arm("arm1");
  grant.planner("planner/arm1@beta");
  grant.term(8);
  ASSERT_TRUE(view.apply(message));
  EXPECT_EQ(view.lease("arm1"), (ArmLease{"planner/arm1@beta", 8}));
  EXPECT_EQ(view.lease("arm2"), (ArmLease{"", 3}));
}

}  // namespace
}  // namespace hecaton::services
