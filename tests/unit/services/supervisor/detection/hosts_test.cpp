// Detection of hosts that fall silent and return.

#include <gtest/gtest.h>

#include "tests/unit/services/supervisor/detection/virtual_cell.hpp"

namespace hecaton::services::testing {
namespace {

TEST_F(FaultDetectorTest, ReportsALostHostAsOneFaultAndHoldsItsArms) {
  for (const auto* node : {"agent/h2", "driver/arm3", "planner/arm3"}) hung.insert(node);
  run_for(60ms);
  EXPECT_EQ(held(), Names{"arm3"}) << "a driver that is not heard may hear its planner";
  EXPECT_EQ(detector.mode().cause_of("arm3").text(), "held: nothing is heard of host h2");
  run_for(30ms);
  EXPECT_TRUE(detector.faults().open().empty()) << "a node or the host may be at fault";
  run_for(40ms);
  const FaultRecord fault = the_fault();
  EXPECT_EQ(fault.kind, msg::CauseKind::CAUSE_HOST_LOST);
  EXPECT_EQ(fault.severity, msg::Severity::SEVERITY_ERROR);
  EXPECT_EQ(fault.subject, "h2");
  EXPECT_EQ(held(), Names{"arm3"});
  hung.clear();
  run_for(150ms);
  EXPECT_TRUE(detector.faults().open().empty());
  EXPECT_TRUE(held().empty());
  EXPECT_EQ(detector.faults().cleared().size(), 1U);
}

// Without a majority each half of a partitioned cell would plan around the other half, which continues.
TEST(Hosts, LosesArmsOfALostHostWhileMostHostsAreHeard) {
  for (const bool third_host_is_heard : {true, false}) {
    VirtualCell cell(nodes_of_three_hosts());
    cell.run_for(200ms);
    for (const auto* node : {"agent/h2", "driver/arm3", "planner/arm3"}) cell.hung.insert(node);
    if (!third_host_is_heard) cell.hung.insert("agent/h3");
    cell.run_for(60ms);
    EXPECT_EQ(cell.detector.loss_of_driver("arm3"), DriverLoss::kNone) << "it may be a stall";
    cell.run_for(140ms);
    EXPECT_EQ(cell.detector.loss_of_driver("arm3"), third_host_is_heard ? DriverLoss::kHostSilent : DriverLoss::kNone);
    EXPECT_EQ(cell.detector.loss_of_driver("arm1"), DriverLoss::kNone);
    cell.hung.clear();
    cell.run_for(10ms);
    EXPECT_EQ(cell.detector.loss_of_driver("arm3"), DriverLoss::kNone);
  }
}

TEST(Hosts, ReportsTheLinkAsLostBetweenTwoHosts) {
  VirtualCell cell(cell_nodes(), cell_limits(), "h1");
  cell.run_for(200ms);
  cell.fall_silent("h2");
  cell.run_for(110ms);
  EXPECT_EQ(cell.faulty(), Names{"h1<->h2"});
  EXPECT_EQ(cell.detector.faults().open().front().kind, msg::CauseKind::CAUSE_LINK_LOST);
  EXPECT_EQ(cell.held(), Names{"arm3"});
  cell.hung.clear();
  cell.run_for(300ms);
  EXPECT_EQ(cell.faulty(), Names{});
  EXPECT_EQ(cell.held(), Names{});
}

TEST_F(FaultDetectorTest, ReportsNoNodeOfALostHostThatIsHeardForAMoment) {
  const auto all = {"agent/h2", "driver/arm3", "planner/arm3"};
  for (const auto* node : all) hung.insert(node);
  run_for(150ms);
  hung.erase("driver/arm3");
  run_for(30ms);
  hung.insert("driver/arm3");
  run_for(400ms);
  EXPECT_EQ(the_fault().kind, msg::CauseKind::CAUSE_HOST_LOST);
  hung.clear();
  run_for(150ms);
  EXPECT_TRUE(detector.faults().open().empty());
  EXPECT_EQ(detector.faults().cleared().size(), 1U);
}

TEST(Hosts, ReportsOnlyNodesThatStayAwayWhenAHostReturns) {
  VirtualCell cell(cell_nodes(), patient_limits());
  cell.run_for(200ms);
  cell.hung.insert("planner/arm3");  // heard before the other nodes
  cell.run_for(20ms);
  for (const auto* node : {"agent/h2", "driver/arm3"}) cell.hung.insert(node);
  cell.run_for(235ms);
  cell.hung = {"planner/arm3"};
  cell.run_for(20ms);
  EXPECT_TRUE(cell.detector.faults().open().empty());
  cell.run_for(150ms);
  ASSERT_EQ(cell.detector.faults().open().size(), 1U) << "the node that stays away";
  EXPECT_EQ(cell.detector.faults().open().front().subject, "planner/arm3");
}

TEST_F(FaultDetectorTest, HoldsNoArmForASilentAgent) {
  hung.insert("agent/h2");
  run_for(200ms);
  EXPECT_EQ(the_fault().kind, msg::CauseKind::CAUSE_NODE_SILENT);
  EXPECT_EQ(the_fault().subject, "agent/h2");
  EXPECT_EQ(the_fault().severity, msg::Severity::SEVERITY_WARNING);
  EXPECT_EQ(detector.mode().decide(), msg::CellMode{});
  hung.clear();
  run_for(200ms);
  EXPECT_TRUE(detector.faults().open().empty());
}

TEST_F(FaultDetectorTest, ReportsANodeThatStaysAwayWhenItsHostReturns) {
  for (const auto* node : {"agent/h2", "driver/arm3", "planner/arm3"}) hung.insert(node);
  run_for(200ms);
  hung = {"driver/arm3"};
  run_for(5s);
  EXPECT_TRUE(detector.faults().open().empty()) << "the network may need as long";
  run_for(200ms);
  EXPECT_EQ(the_fault().kind, msg::CauseKind::CAUSE_NODE_SILENT);
  EXPECT_EQ(the_fault().subject, "driver/arm3");
}

TEST_F(FaultDetectorTest, ReportsANodeThatHangsAfterItsReturn) {
  for (const auto* node : {"agent/h2", "driver/arm3", "planner/arm3"}) hung.insert(node);
  run_for(200ms);
  hung = {"planner/arm3"};
  run_for(900ms);
  hung = {"planner/arm3", "driver/arm3"};
  run_for(50ms);
  hung.clear();
  run_for(200ms);
  EXPECT_EQ(detector.faults().cleared().size(), 1U) << "a return";
  run_for(900ms);
  hung = {"driver/arm3"};
  run_for(30ms);
  EXPECT_EQ(the_fault().kind, msg::CauseKind::CAUSE_NODE_SILENT);
  EXPECT_EQ(the_fault().subject, "driver/arm3");
}

TEST(FaultDetectorStart, ReportsAHostThatNeverAppearsAsOneFault) {
  VirtualCell cell;
  cell.dead = {"agent/h2", "driver/arm3", "planner/arm3"};
  cell.run_for(2s);
  const auto open = cell.detector.faults().open();
  ASSERT_EQ(open.size(), 1U);
  EXPECT_EQ(open.front().subject, "agent/h2");
  EXPECT_EQ(cell.held(), Names{"arm3"});
}

}  // namespace
}  // namespace hecaton::services::testing
