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
  UnreplicatedOrders legacy;
  legacy.begin_to_lead();
  legacy.published({}, 1);
  legacy.given({"left"});
  legacy.published(kStopLeft, 2);
  legacy.published(kStopLeft, 3);
  EXPECT_FALSE(legacy.heard(1));
  EXPECT_EQ(legacy.unheard(kStopLeft), kStopLeft);
  EXPECT_TRUE(legacy.heard(2));
  EXPECT_FALSE(legacy.heard(3)) << "no news";
  EXPECT_TRUE(legacy.unheard(kStopLeft).empty());
  legacy.stand_back(kStopLeft);
  EXPECT_TRUE(legacy.left().empty());
}

TEST(UnreplicatedOrders, WhatNobodyHeardIsLeftUntilWhoLeadsHasIt) {
  UnreplicatedOrders legacy;
  legacy.begin_to_lead();
  legacy.published({}, 1);
  legacy.heard(1);
  Orders orders = kStopLeft;
  orders.cell = msg::Mode::MODE_HOLD;
  legacy.given({"left"});
  legacy.given({});
  legacy.published(orders, 2);
  legacy.stand_back(orders);
  EXPECT_EQ(legacy.left(), orders);
  EXPECT_FALSE(legacy.strike_out(arm_order("left", msg::Mode::MODE_HOLD)));
  EXPECT_EQ(legacy.left(), orders) << "a hold is no stop";
  EXPECT_FALSE(legacy.strike_out(kStopLeft));
  EXPECT_TRUE(legacy.left().arms.empty());
  EXPECT_TRUE(legacy.strike_out(orders));
  EXPECT_FALSE(legacy.strike_out(orders)) << "nothing was left any more";
}

TEST(UnreplicatedOrders, GivenOnceMoreAnOrderMustBeHeardOnceMore) {
  UnreplicatedOrders legacy;
  legacy.begin_to_lead();
  legacy.published(kStopLeft, 1);
  legacy.heard(1);
  legacy.given({"left"});
  legacy.heard(1);
  EXPECT_EQ(legacy.unheard(kStopLeft), kStopLeft) << "people may have resumed it on the other side of a partition";
  legacy.published(kStopLeft, 2);
  legacy.heard(1);
  EXPECT_EQ(legacy.unheard(kStopLeft), kStopLeft);
  legacy.heard(2);
  EXPECT_TRUE(legacy.unheard(kStopLeft).empty());
}

TEST(UnreplicatedOrders, OfANewTermNothingIsKnownToHaveBeenHeard) {
  UnreplicatedOrders legacy(kStopLeft);
  EXPECT_EQ(legacy.left(), kStopLeft) << "by an earlier life";
  legacy.begin_to_lead();
  EXPECT_TRUE(legacy.left().empty());
  legacy.heard(7);
  EXPECT_EQ(legacy.unheard(kStopLeft), kStopLeft);
}

TEST(UnreplicatedOrders, WhatWasResumedIsNotLeft) {
  UnreplicatedOrders legacy;
  legacy.begin_to_lead();
  legacy.given({"left"});
  legacy.published(kStopLeft, 1);
  legacy.published({}, 2);
  legacy.stand_back({});
  EXPECT_TRUE(legacy.left().empty());
}

}  // namespace
}  // namespace hecaton::services
