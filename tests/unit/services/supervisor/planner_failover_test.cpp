#include "services/supervisor/failover/planner_failover.hpp"

#include <set>

#include <gtest/gtest.h>

namespace hecaton::services {
namespace {

using namespace std::chrono_literals;

/// A leader of term 2 over one arm with planners p and q, and one without a standby.
class SuccessionTest : public ::testing::Test {
 protected:
  SuccessionTest() { EXPECT_TRUE(leadership_.decide(1s, 0ms)); }

  bool decide() {
    return failover_.decide(
        [this](const std::string&, const std::string& planner) {
          return PlannerHealth{out_.contains(planner), ready_.contains(planner)};
        },
        leadership_);
  }
  [[nodiscard]] ArmLease mandate() const { return failover_.lease("arm1"); }

  Leadership leadership_{{}, 0, 0ms, {0, 2}};
  PlannerFailover failover_{{{"arm1", {"p", "q"}}}};
  std::set<std::string> out_, ready_;
};

TEST_F(SuccessionTest, TheFirstIsInChargeAtTheBeginning) {
  EXPECT_EQ(mandate(), ArmLease());
  EXPECT_TRUE(decide());
  EXPECT_EQ(mandate(), (ArmLease{"p", 4}));
  EXPECT_FALSE(decide()) << "nothing is to change";
  EXPECT_EQ(failover_.lease("arm2"), ArmLease());
}

TEST_F(SuccessionTest, WhoIsOutIsReplacedByWhoIsReadyUnderANewTerm) {
  EXPECT_TRUE(decide());
  out_ = {"p"};
  EXPECT_FALSE(decide()) << "nobody is ready";
  ready_ = {"q"};
  EXPECT_TRUE(decide());
  EXPECT_EQ(mandate(), (ArmLease{"q", 6}));
  // The roles are exchanged: who comes back stands by.
  out_ = {};
  ready_ = {"p"};
  EXPECT_FALSE(decide());
  out_ = {"q"};
  EXPECT_TRUE(decide());
  EXPECT_EQ(mandate(), (ArmLease{"p", 8}));
}

TEST_F(SuccessionTest, WhatAnotherLeaderGrantedStays) {
  failover_.hear("arm1", {"q", 7});
  EXPECT_FALSE(decide());
  EXPECT_EQ(mandate(), (ArmLease{"q", 7}));
  out_ = {"q"};
  ready_ = {"p"};
  EXPECT_TRUE(decide());
  EXPECT_EQ(mandate(), (ArmLease{"p", 8})) << "above what it heard";
  failover_.hear("arm1", {"q", 7});
  EXPECT_EQ(mandate(), (ArmLease{"p", 8})) << "old news";
}

TEST_F(SuccessionTest, TheDriverKnowsBetterWhoHasATerm) {
  EXPECT_TRUE(decide());
  failover_.hear_driver("arm1", {"q", 4});
  EXPECT_EQ(mandate(), (ArmLease{"q", 4})) << "our memory was lost, and the term given before";
  failover_.hear_driver("arm1", {"p", 2});
  EXPECT_EQ(mandate(), (ArmLease{"q", 4}));
  EXPECT_FALSE(decide());
}

TEST_F(SuccessionTest, AStrangerInChargeIsReplaced) {
  failover_.hear_driver("arm1", {"somebody", 9});
  EXPECT_TRUE(decide());
  EXPECT_EQ(mandate(), (ArmLease{"p", 10}));
}

// In charge for long, heard 10 ms ago, its last command accepted 10 ms ago.
PlannerObservations at_work() {
  PlannerObservations signs;
  signs.silence = 10ms;
  signs.in_charge = 10s;
  signs.uncommanded = 10ms;
  return signs;
}

TEST(Fitness, WhoWorksIsLeftInCharge) {
  EXPECT_FALSE(health_of(at_work(), {}).out);
  EXPECT_FALSE(health_of({}, {}).out) << "not heard yet";
  PlannerObservations standby;
  standby.silence = 10ms;
  EXPECT_FALSE(health_of(standby, {}).ready);
  standby.stands_by = true;
  EXPECT_TRUE(health_of(standby, {}).ready);
  standby.silence.reset();
  EXPECT_FALSE(health_of(standby, {}).ready) << "it was restarted, and has said nothing yet";
}

TEST(Fitness, WhoDiedOrHangsIsOut) {
  PlannerObservations signs = at_work();
  signs.ended = true;
  EXPECT_TRUE(health_of(signs, {}).out);
  signs = at_work();
  signs.silence = signs.uncommanded = 20ms;
  EXPECT_TRUE(health_of(signs, {}).out);
  signs.uncommanded.reset();
  EXPECT_TRUE(health_of(signs, {}).out) << "the driver is silent, too";
}

TEST(Fitness, LostHeartbeatsAloneReplaceNobody) {
  PlannerObservations signs = at_work();
  signs.silence = 1s;
  EXPECT_FALSE(health_of(signs, {}).out) << "its commands arrive";
}

TEST(Fitness, WhomTheDriverDoesNotHearIsOut) {
  PlannerObservations signs = at_work();
  signs.uncommanded = 100ms;
  EXPECT_TRUE(health_of(signs, {}).out);
  signs.in_charge = 50ms;
  EXPECT_FALSE(health_of(signs, {}).out) << "it has just been put in charge";
}

TEST(Fitness, WhoIsSilentIsNotReady) {
  PlannerObservations signs;
  signs.stands_by = true;
  signs.silence = 20ms;
  signs.uncommanded = 1ms;
  EXPECT_FALSE(health_of(signs, {}).ready) << "those commands are not its own";
}

}  // namespace
}  // namespace hecaton::services
