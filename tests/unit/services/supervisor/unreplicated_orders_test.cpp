#include <gtest/gtest.h>

#include "services/supervisor/replication/unreplicated.hpp"

namespace hecaton::services {
namespace {

Orders arm_order(const char* arm, msg::Mode mode) {
  Orders orders;
  orders.arms[arm] = mode;
  return orders;
}

const Orders kStopLeft = arm_order("left", msg::Mode::MODE_STOP);

TEST(Orders, BeyondWhatIsKnown) {
  Orders orders = kStopLeft;
  orders.arms["right"] = msg::Mode::MODE_HOLD;
  orders.cell = msg::Mode::MODE_HOLD;
  EXPECT_EQ(beyond(orders, {}), orders);
  EXPECT_TRUE(beyond(orders, orders).empty());
  Orders known = arm_order("left", msg::Mode::MODE_HOLD);
  known.arms["right"] = msg::Mode::MODE_STOP;
  known.cell = msg::Mode::MODE_STOP;
  EXPECT_EQ(beyond(orders, known), kStopLeft) << "a stop is more than a hold";
}

TEST(UnreplicatedOrders, OfWhatTheOtherHeardNothingIsLeft) {
  UnreplicatedOrders unreplicated;
  unreplicated.become_leader();
  unreplicated.published({}, 1);
  unreplicated.given({"left"});
  unreplicated.published(kStopLeft, 2);
  unreplicated.published(kStopLeft, 3);
  EXPECT_FALSE(unreplicated.acknowledged(1));
  EXPECT_EQ(unreplicated.unacknowledged(kStopLeft), kStopLeft);
  EXPECT_TRUE(unreplicated.acknowledged(2));
  EXPECT_FALSE(unreplicated.acknowledged(3)) << "no news";
  EXPECT_TRUE(unreplicated.unacknowledged(kStopLeft).empty());
  unreplicated.step_down(kStopLeft);
  EXPECT_TRUE(unreplicated.pending().empty());
}

TEST(UnreplicatedOrders, WhatNobodyHeardIsLeftUntilWhoLeadsHasIt) {
  UnreplicatedOrders unreplicated;
  unreplicated.become_leader();
  unreplicated.published({}, 1);
  unreplicated.acknowledged(1);
  Orders orders = kStopLeft;
  orders.cell = msg::Mode::MODE_HOLD;
  unreplicated.given({"left"});
  unreplicated.given({});
  unreplicated.published(orders, 2);
  unreplicated.step_down(orders);
  EXPECT_EQ(unreplicated.pending(), orders);
  EXPECT_FALSE(unreplicated.remove_published(arm_order("left", msg::Mode::MODE_HOLD)));
  EXPECT_EQ(unreplicated.pending(), orders) << "a hold is no stop";
  EXPECT_FALSE(unreplicated.remove_published(kStopLeft));
  EXPECT_TRUE(unreplicated.pending().arms.empty());
  EXPECT_TRUE(unreplicated.remove_published(orders));
  EXPECT_FALSE(unreplicated.remove_published(orders)) << "nothing was left any more";
}

TEST(UnreplicatedOrders, GivenOnceMoreAnOrderMustBeHeardOnceMore) {
  UnreplicatedOrders unreplicated;
  unreplicated.become_leader();
  unreplicated.published(kStopLeft, 1);
  unreplicated.acknowledged(1);
  unreplicated.given({"left"});
  unreplicated.acknowledged(1);
  EXPECT_EQ(unreplicated.unacknowledged(kStopLeft), kStopLeft) << "people may have resumed it on the other side of a partition";
  unreplicated.published(kStopLeft, 2);
  unreplicated.acknowledged(1);
  EXPECT_EQ(unreplicated.unacknowledged(kStopLeft), kStopLeft);
  unreplicated.acknowledged(2);
  EXPECT_TRUE(unreplicated.unacknowledged(kStopLeft).empty());
}

TEST(UnreplicatedOrders, OfANewTermNothingIsKnownToHaveBeenHeard) {
  UnreplicatedOrders unreplicated(kStopLeft);
  EXPECT_EQ(unreplicated.pending(), kStopLeft) << "by an earlier life";
  unreplicated.become_leader();
  EXPECT_TRUE(unreplicated.pending().empty());
  unreplicated.acknowledged(7);
  EXPECT_EQ(unreplicated.unacknowledged(kStopLeft), kStopLeft);
}

TEST(UnreplicatedOrders, WhatWasResumedIsNotLeft) {
  UnreplicatedOrders unreplicated;
  unreplicated.become_leader();
  unreplicated.given({"left"});
  unreplicated.published(kStopLeft, 1);
  unreplicated.published({}, 2);
  unreplicated.step_down({});
  EXPECT_TRUE(unreplicated.pending().empty());
}

}  // namespace
}  // namespace hecaton::services
