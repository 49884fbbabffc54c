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

TEST_F(PlannerFailoverTest, GrantsTheFirstLeaseToTheFirstPlanner) {
  EXPECT_EQ(lease(), ArmLease());
  EXPECT_TRUE(decide());
  EXPECT_EQ(lease(), (ArmLease{"p", 4}));
  EXPECT_FALSE(decide()) << "no change";
  EXPECT_EQ(failover_.lease("arm2"), ArmLease());
}

TEST_F(PlannerFailoverTest, ReplacesAFailedPlannerByAReadyOneUnderANewTerm) {
  EXPECT_TRUE(decide());
  out_ = {"p"};
  EXPECT_FALSE(decide()) << "no planner is ready";
  ready_ = {"q"};
  EXPECT_TRUE(decide());
  EXPECT_EQ(lease(), (ArmLease{"q", 6}));
  // The roles are exchanged: the planner that returns stands by.
  out_ = {};
  ready_ = {"p"};
  EXPECT_FALSE(decide());
  out_ = {"q"};
  EXPECT_TRUE(decide());
  EXPECT_EQ(lease(), (ArmLease{"p", 8}));
}

TEST_F(PlannerFailoverTest, KeepsTheLeaseOfAnotherLeader) {
  failover_.update("arm1", {"q", 7});
  EXPECT_FALSE(decide());
  EXPECT_EQ(lease(), (ArmLease{"q", 7}));
  out_ = {"q"};
  ready_ = {"p"};
  EXPECT_TRUE(decide());
  EXPECT_EQ(lease(), (ArmLease{"p", 8})) << "above the observed term";
  failover_.update("arm1", {"q", 7});
  EXPECT_EQ(lease(), (ArmLease{"p", 8})) << "an older lease";
}

TEST_F(PlannerFailoverTest, AdoptsTheDriversPlannerForATerm) {
  EXPECT_TRUE(decide());
  failover_.update_from_driver("arm1", {"q", 4});
  EXPECT_EQ(lease(), (ArmLease{"q", 4})) << "the checkpoint was lost, and the term granted before";
  failover_.update_from_driver("arm1", {"p", 2});
  EXPECT_EQ(lease(), (ArmLease{"q", 4}));
  EXPECT_FALSE(decide());
}

TEST_F(PlannerFailoverTest, ReplacesAnUnknownPlanner) {
  failover_.update_from_driver("arm1", {"unknown", 9});
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

TEST(PlannerHealth, KeepsAWorkingPlannerHealthy) {
  EXPECT_FALSE(health_of(at_work(), {}).failed);
  EXPECT_FALSE(health_of({}, {}).failed) << "not heard yet";
  PlannerObservations standby;
  standby.silence = 10ms;
  EXPECT_FALSE(health_of(standby, {}).ready);
  standby.stands_by = true;
  EXPECT_TRUE(health_of(standby, {}).ready);
  standby.silence.reset();
  EXPECT_FALSE(health_of(standby, {}).ready) << "it was restarted and has sent no heartbeat yet";
}

TEST(PlannerHealth, FailsAPlannerThatDiedOrHangs) {
  PlannerObservations observed = at_work();
  observed.ended = true;
  EXPECT_TRUE(health_of(observed, {}).failed);
  observed = at_work();
  observed.silence = observed.command_silence = 20ms;
  EXPECT_TRUE(health_of(observed, {}).failed);
  observed.command_silence.reset();
  EXPECT_TRUE(health_of(observed, {}).failed) << "the driver is silent, too";
}

TEST(PlannerHealth, IgnoresLostHeartbeatsWhileCommandsArrive) {
  PlannerObservations observed = at_work();
  observed.silence = 1s;
  EXPECT_FALSE(health_of(observed, {}).failed) << "its commands arrive";
}

TEST(PlannerHealth, FailsAPlannerThatTheDriverDoesNotHear) {
  PlannerObservations observed = at_work();
  observed.command_silence = 100ms;
  EXPECT_TRUE(health_of(observed, {}).failed);
  observed.time_in_charge = 50ms;
  EXPECT_FALSE(health_of(observed, {}).failed) << "it has just been put in charge";
}

TEST(PlannerHealth, ASilentPlannerIsNotReady) {
  PlannerObservations observed;
  observed.stands_by = true;
  observed.silence = 20ms;
  observed.command_silence = 1ms;
  EXPECT_FALSE(health_of(observed, {}).ready) << "those commands are of another planner";
}

TEST(FailoverBackoff, DoublesWithEachReplacementUpToTheUpperLimit) {
  FailoverBackoff backoff(20ms, 100ms);
  EXPECT_EQ(backoff.at(100s), 20ms);
  backoff.replaced(100s);
  EXPECT_EQ(backoff.at(100s), 40ms);
  backoff.replaced(101s);
  EXPECT_EQ(backoff.at(101s), 80ms);
  backoff.replaced(102s);
  backoff.replaced(103s);
  EXPECT_EQ(backoff.at(103s), 100ms);
}

TEST(FailoverBackoff, IsHalvedAfterEachQuietPeriod) {
  FailoverBackoff backoff(20ms, 100ms);
  backoff.replaced(100s);
  backoff.replaced(100s);
  EXPECT_EQ(backoff.at(109s), 80ms);
  EXPECT_EQ(backoff.at(110s), 40ms);
  backoff.replaced(111s);
  EXPECT_EQ(backoff.at(111s), 80ms) << "twice the limit at that time";
  EXPECT_EQ(backoff.at(131s), 20ms);
  EXPECT_EQ(backoff.at(1000s), 20ms);
}

TEST(FailoverBackoff, IsNeverBelowTheFailoverTimeout) {
  FailoverBackoff backoff(150ms, 100ms);
  backoff.replaced(1s);
  EXPECT_EQ(backoff.at(1s), 150ms);
}

}  // namespace
}  // namespace hecaton::services
