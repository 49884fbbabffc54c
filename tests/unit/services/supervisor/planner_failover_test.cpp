#include "services/supervisor/failover/planner_failover.hpp"

#include <set>

#include <gtest/gtest.h>

namespace hecaton::services {
namespace {

using namespace std::chrono_literals;

/// A leader of term 2 over one arm with planners p and q, and one without a standby.
class PlannerFailoverTest : public ::testing::Test {
 protected:
  PlannerFailoverTest() { EXPECT_TRUE(leadership_.decide(1s, 0ms)); }

  bool decide() {
    return failover_.decide(
        [this](const std::string&, const std::string& planner) {
          return PlannerHealth{out_.contains(planner), ready_.contains(planner)};
        },
        leadership_);
  }
  [[nodiscard]] ArmLease lease() const { return failover_.lease("arm1"); }

  Leadership leadership_{{}, 0, 0ms, {0, 2}};
  PlannerFailover failover_{{{"arm1", {"p", "q"}}}};
  std::set<std::string> out_, ready_;
};

TEST_F(PlannerFailoverTest, TheFirstIsInChargeAtTheBeginning) {
  EXPECT_EQ(lease(), ArmLease());
  EXPECT_TRUE(decide());
  EXPECT_EQ(lease(), (ArmLease{"p", 4}));
  EXPECT_FALSE(decide()) << "nothing is to change";
  EXPECT_EQ(failover_.lease("arm2"), ArmLease());
}

TEST_F(PlannerFailoverTest, WhoIsOutIsReplacedByWhoIsReadyUnderANewTerm) {
  EXPECT_TRUE(decide());
  out_ = {"p"};
  EXPECT_FALSE(decide()) << "nobody is ready";
  ready_ = {"q"};
  EXPECT_TRUE(decide());
  EXPECT_EQ(lease(), (ArmLease{"q", 6}));
  // The roles are exchanged: who comes back stands by.
  out_ = {};
  ready_ = {"p"};
  EXPECT_FALSE(decide());
  out_ = {"q"};
  EXPECT_TRUE(decide());
  EXPECT_EQ(lease(), (ArmLease{"p", 8}));
}

TEST_F(PlannerFailoverTest, WhatAnotherLeaderGrantedStays) {
  failover_.update("arm1", {"q", 7});
  EXPECT_FALSE(decide());
  EXPECT_EQ(lease(), (ArmLease{"q", 7}));
  out_ = {"q"};
  ready_ = {"p"};
  EXPECT_TRUE(decide());
  EXPECT_EQ(lease(), (ArmLease{"p", 8})) << "above what it heard";
  failover_.update("arm1", {"q", 7});
  EXPECT_EQ(lease(), (ArmLease{"p", 8})) << "old news";
}

TEST_F(PlannerFailoverTest, TheDriverKnowsBetterWhoHasATerm) {
  EXPECT_TRUE(decide());
  failover_.update_from_driver("arm1", {"q", 4});
  EXPECT_EQ(lease(), (ArmLease{"q", 4})) << "our memory was lost, and the term given before";
  failover_.update_from_driver("arm1", {"p", 2});
  EXPECT_EQ(lease(), (ArmLease{"q", 4}));
  EXPECT_FALSE(decide());
}

TEST_F(PlannerFailoverTest, AStrangerInChargeIsReplaced) {
  failover_.update_from_driver("arm1", {"somebody", 9});
  EXPECT_TRUE(decide());
  EXPECT_EQ(lease(), (ArmLease{"p", 10}));
}

// In charge for long, heard 10 ms ago, its last command accepted 10 ms ago.
PlannerObservations at_work() {
  PlannerObservations observed;
  observed.silence = 10ms;
  observed.time_in_charge = 10s;
  observed.command_silence = 10ms;
  return observed;
}

TEST(PlannerHealth, WhoWorksIsLeftInCharge) {
  EXPECT_FALSE(health_of(at_work(), {}).failed);
  EXPECT_FALSE(health_of({}, {}).failed) << "not heard yet";
  PlannerObservations standby;
  standby.silence = 10ms;
  EXPECT_FALSE(health_of(standby, {}).ready);
  standby.stands_by = true;
  EXPECT_TRUE(health_of(standby, {}).ready);
  standby.silence.reset();
  EXPECT_FALSE(health_of(standby, {}).ready) << "it was restarted, and has said nothing yet";
}

TEST(PlannerHealth, WhoDiedOrHangsIsOut) {
  PlannerObservations observed = at_work();
  observed.ended = true;
  EXPECT_TRUE(health_of(observed, {}).failed);
  observed = at_work();
  observed.silence = observed.command_silence = 20ms;
  EXPECT_TRUE(health_of(observed, {}).failed);
  observed.command_silence.reset();
  EXPECT_TRUE(health_of(observed, {}).failed) << "the driver is silent, too";
}

TEST(PlannerHealth, LostHeartbeatsAloneReplaceNobody) {
  PlannerObservations observed = at_work();
  observed.silence = 1s;
  EXPECT_FALSE(health_of(observed, {}).failed) << "its commands arrive";
}

TEST(PlannerHealth, WhomTheDriverDoesNotHearIsOut) {
  PlannerObservations observed = at_work();
  observed.command_silence = 100ms;
  EXPECT_TRUE(health_of(observed, {}).failed);
  observed.time_in_charge = 50ms;
  EXPECT_FALSE(health_of(observed, {}).failed) << "it has just been put in charge";
}

TEST(PlannerHealth, WhoIsSilentIsNotReady) {
  PlannerObservations observed;
  observed.stands_by = true;
  observed.silence = 20ms;
  observed.command_silence = 1ms;
  EXPECT_FALSE(health_of(observed, {}).ready) << "those commands are not its own";
}

}  // namespace
}  // namespace hecaton::services
