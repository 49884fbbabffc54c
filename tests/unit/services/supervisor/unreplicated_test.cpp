#include "services/supervisor/replication/unreplicated.hpp"

#include <gtest/gtest.h>

namespace hecaton::services {
namespace {

Orders arm_order(const char* arm, msg::Mode mode) {
  Orders orders;
  orders.arms[arm] = mode;
  return orders;
}

const Orders kStopLeft = arm_order("left", msg::Mode::MODE_STOP);

TEST(Orders, BeyondReturnsStricterOrders) {
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

TEST(UnreplicatedOrders, AreNoneOnceAcknowledged) {
  UnreplicatedOrders unreplicated;
  unreplicated.become_leader();
  unreplicated.published({}, 1);
  unreplicated.given({"left"});
  unreplicated.published(kStopLeft, 2);
  unreplicated.published(kStopLeft, 3);
  EXPECT_FALSE(unreplicated.acknowledged(1));
  EXPECT_EQ(unreplicated.unacknowledged(kStopLeft), kStopLeft);
  EXPECT_TRUE(unreplicated.acknowledged(2));
  EXPECT_FALSE(unreplicated.acknowledged(3)) << "no change";
  EXPECT_TRUE(unreplicated.unacknowledged(kStopLeft).empty());
  unreplicated.step_down(kStopLeft);
  EXPECT_TRUE(unreplicated.pending().empty());
}

TEST(UnreplicatedOrders, ArePendingUntilTheLeaderPublishesThem) {
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
  EXPECT_EQ(unreplicated.pending(), orders) << "hold is weaker than stop";
  EXPECT_FALSE(unreplicated.remove_published(kStopLeft));
  EXPECT_TRUE(unreplicated.pending().arms.empty());
  EXPECT_TRUE(unreplicated.remove_published(orders));
  EXPECT_FALSE(unreplicated.remove_published(orders)) << "nothing is pending";
}

TEST(UnreplicatedOrders, ContainLowerSpeedsUntilTheLeaderPublishesThem) {
  UnreplicatedOrders unreplicated;
  unreplicated.become_leader();
  unreplicated.published({}, 1);
  unreplicated.acknowledged(1);
  Orders orders;
  orders.speed = 0.3;
  orders.speeds = {{"left", 0.1}};
  unreplicated.given({});
  unreplicated.published(orders, 2);
  EXPECT_EQ(unreplicated.unacknowledged(orders), orders);
  unreplicated.step_down(orders);
  Orders known;
  known.speed = 0.2;
  known.speeds = {{"left", 0.5}};
  EXPECT_FALSE(unreplicated.remove_published(known));
  EXPECT_EQ(unreplicated.pending().speed, 1.0) << "the leader's speed is lower";
  EXPECT_EQ(unreplicated.pending().speeds, orders.speeds);
  EXPECT_TRUE(unreplicated.remove_published(orders));
}

TEST(UnreplicatedOrders, NeedANewAcknowledgementWhenGivenAgain) {
  UnreplicatedOrders unreplicated;
  unreplicated.become_leader();
  unreplicated.published(kStopLeft, 1);
  unreplicated.acknowledged(1);
  unreplicated.given({"left"});
  unreplicated.acknowledged(1);
  EXPECT_EQ(unreplicated.unacknowledged(kStopLeft), kStopLeft)
      << "people may have resumed it on the other side of a partition";
  unreplicated.published(kStopLeft, 2);
  unreplicated.acknowledged(1);
  EXPECT_EQ(unreplicated.unacknowledged(kStopLeft), kStopLeft);
  unreplicated.acknowledged(2);
  EXPECT_TRUE(unreplicated.unacknowledged(kStopLeft).empty());
}

TEST(UnreplicatedOrders, NeedANewAcknowledgementInANewTerm) {
  UnreplicatedOrders unreplicated(kStopLeft);
  EXPECT_EQ(unreplicated.pending(), kStopLeft) << "from the checkpoint";
  unreplicated.become_leader();
  EXPECT_TRUE(unreplicated.pending().empty());
  unreplicated.acknowledged(7);
  EXPECT_EQ(unreplicated.unacknowledged(kStopLeft), kStopLeft);
}

TEST(UnreplicatedOrders, AreNotPendingAfterResume) {
  UnreplicatedOrders unreplicated;
  unreplicated.become_leader();
  unreplicated.given({"left"});
  unreplicated.published(kStopLeft, 1);
  unreplicated.published({}, 2);
  unreplicated.step_down({});
  EXPECT_TRUE(unreplicated.pending().empty());
}

using namespace std::chrono_literals;
using Replies = std::vector<std::string>;

TEST(DeferredReplies, WaitUntilTheStandbyAcknowledgesTheOrder) {
  DeferredReplies<std::string> deferred;
  deferred.add("hold", 7, 0s);
  deferred.add("stop", 9, 0s);
  EXPECT_EQ(deferred.take(6, 1ms), Replies{});
  EXPECT_EQ(deferred.take(7, 2ms), Replies{"hold"});
  EXPECT_EQ(deferred.take(7, 3ms), Replies{}) << "each is returned once";
  EXPECT_EQ(deferred.take(12, 4ms), Replies{"stop"});
}

TEST(DeferredReplies, AreDueAtOnceWithoutAStandby) {
  DeferredReplies<std::string> deferred;
  deferred.add("hold", 7, 0s);
  EXPECT_EQ(deferred.take(std::nullopt, 0s), Replies{"hold"});
}

TEST(DeferredReplies, AreDueAfterTheTimeoutWithADeafStandby) {
  DeferredReplies<std::string> deferred;
  deferred.add("hold", 7, 1s);
  EXPECT_EQ(deferred.take(0, 1s + DeferredReplies<std::string>::kTimeout - 1ns), Replies{});
  EXPECT_EQ(deferred.take(0, 1s + DeferredReplies<std::string>::kTimeout), Replies{"hold"});
}

TEST(DeferredReplies, AreClearedWhenTheSupervisorStepsDown) {
  DeferredReplies<std::string> deferred;
  deferred.add("hold", 7, 0s);
  deferred.clear();
  EXPECT_EQ(deferred.take(std::nullopt, 1h), Replies{});
}

}  // namespace
}  // namespace hecaton::services
