// Whole hosts that fall silent and return, as CellWatch judges them.

#include <gtest/gtest.h>

#include "tests/unit/services/supervisor/cell_watch_fixture.hpp"

namespace hecaton::services::testing {
namespace {

TEST_F(CellWatchTest, LostHostIsOneFaultAndHoldsItsArms) {
  for (const auto* node : {"agent/h2", "driver/arm3", "planner/arm3"}) hung.insert(node);
  run_for(60ms);
  EXPECT_EQ(held(), Names{"arm3"}) << "who is not heard may hear us, and had better not move";
  EXPECT_EQ(watch.mode().cause_of("arm3").text(), "held: nothing is heard of host h2");
  run_for(30ms);
  EXPECT_TRUE(watch.faults().open().empty());  // it cannot be told yet who of them is at fault
  run_for(40ms);
  const FaultRecord fault = the_fault();
  EXPECT_EQ(fault.kind, msg::CauseKind::CAUSE_HOST_LOST);
  EXPECT_EQ(fault.severity, msg::Severity::SEVERITY_ERROR);
  EXPECT_EQ(fault.subject, "h2");
  EXPECT_EQ(held(), Names{"arm3"});
  hung.clear();
  run_for(150ms);
  EXPECT_TRUE(watch.faults().open().empty());
  EXPECT_TRUE(held().empty());
  EXPECT_EQ(watch.faults().over().size(), 1U);
}

// Were it not for the majority, each half of a cell that is cut in two would work around the other, which goes on.
TEST(CellWatchHosts, AnArmIsLostWithItsHostWhileMostHostsAreHeard) {
  for (const bool third_host_is_heard : {true, false}) {
    std::vector<ExpectedNode> nodes = cell_nodes();
    nodes.push_back({"agent/h3", msg::NodeKind::NODE_AGENT, {}, "h3"});
    VirtualCell cell(nodes);
    cell.run_for(200ms);
    for (const auto* node : {"agent/h2", "driver/arm3", "planner/arm3"}) cell.hung.insert(node);
    if (!third_host_is_heard) cell.hung.insert("agent/h3");
    cell.run_for(60ms);
    EXPECT_EQ(cell.watch.loss_of("arm3"), Loss::kNone) << "it may be a stall";
    cell.run_for(140ms);
    EXPECT_EQ(cell.watch.loss_of("arm3"), third_host_is_heard ? Loss::kHostSilent : Loss::kNone);
    EXPECT_EQ(cell.watch.loss_of("arm1"), Loss::kNone);
    cell.hung.clear();
    cell.run_for(10ms);
    EXPECT_EQ(cell.watch.loss_of("arm3"), Loss::kNone);
  }
}

// Nobody can know which of the two is cut off.
TEST(CellWatchHosts, OfTwoHostsTheOtherIsLost) {
  VirtualCell cell(cell_nodes(), cell_limits(), "h1");
  cell.run_for(200ms);
  for (const auto* node : {"agent/h2", "driver/arm3", "planner/arm3"}) cell.hung.insert(node);
  cell.run_for(200ms);
  ASSERT_EQ(cell.watch.faults().open().size(), 1U);
  EXPECT_EQ(cell.watch.faults().open().front().subject, "h2");
}

TEST_F(CellWatchTest, NodeHeardForAMomentIsNotAccusedWhileItsHostIsLost) {
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
  EXPECT_TRUE(watch.faults().open().empty());
  EXPECT_EQ(watch.faults().over().size(), 1U);
}

// Chaos cut a host off for 0.24 s where a node may be silent for 0.25 s.
TEST(CellWatchHosts, NodesReturnOneAfterTheOtherAlsoFromASilenceThatANodeMayKeep) {
  WatchLimits limits = cell_limits();
  limits.node.silence = limits.arm_stream = limits.world_stream = 250ms;
  limits.node.lost = limits.host_lease = 1s;
  VirtualCell cell(cell_nodes(), limits);
  cell.run_for(200ms);
  cell.hung.insert("planner/arm3");  // it beats before the others
  cell.run_for(20ms);
  for (const auto* node : {"agent/h2", "driver/arm3"}) cell.hung.insert(node);
  cell.run_for(235ms);
  cell.hung = {"planner/arm3"};
  cell.run_for(20ms);
  EXPECT_TRUE(cell.watch.faults().open().empty());
  cell.run_for(150ms);
  ASSERT_EQ(cell.watch.faults().open().size(), 1U) << "who stays away is a fault";
  EXPECT_EQ(cell.watch.faults().open().front().subject, "planner/arm3");
}

// Chaos let nothing leave the host of a supervisor that stood by, and then killed who led: of the other hosts, which
// had dropped the one and not met it anew, it heard one in part.
TEST_F(CellWatchTest, ASuccessorPutsDownToItselfWhatItsPredecessorDidNotTell) {
  for (const auto* node : {"agent/h2", "driver/arm3"}) hung.insert(node);  // not to others
  run_for(200ms);
  watch.faults().recall({});
  watch.succeed("supervisor@h2", 20ms);
  run_for(400ms);
  EXPECT_TRUE(watch.faults().open().empty());
  EXPECT_EQ(watch.mode().cause_of("arm3").text(), "held: driver/arm3 is not back yet");
  hung = {"planner/arm3"};  // the reunion takes away who was heard
  run_for(900ms);
  EXPECT_TRUE(watch.faults().open().empty());
  hung.clear();
  run_for(1100ms);
  EXPECT_TRUE(held().empty());
  hung = {"driver/arm3"};
  run_for(30ms);
  EXPECT_EQ(the_fault().subject, "driver/arm3") << "all are met: a hang is a hang";
}

// A deaf leader excuses everybody, and its silence about them says nothing.
TEST(CellWatchHosts, ASuccessorDoesNotGoByAPredecessorThatWasCutOff) {
  std::vector<ExpectedNode> nodes = cell_nodes();
  nodes.push_back({"agent/h3", msg::NodeKind::NODE_AGENT, {}, "h3"});
  nodes.push_back({"supervisor@h3", msg::NodeKind::NODE_SUPERVISOR, {}, "h3"});
  VirtualCell cell(nodes, cell_limits(), "h1");
  cell.run_for(200ms);
  for (const auto* node : {"agent/h2", "driver/arm3", "planner/arm3"}) cell.hung.insert(node);
  cell.run_for(200ms);
  FaultHistory told;
  told.open["agent/h3"] = {1,  1, msg::CauseKind::CAUSE_HOST_LOST, msg::Severity::SEVERITY_ERROR, "h3", "cut off", 0ms,
                           {}, {}};
  cell.watch.faults().recall(told);
  cell.watch.succeed("supervisor@h3", 20ms);
  cell.run_for(10ms);
  ASSERT_EQ(cell.watch.faults().open().size(), 1U);
  EXPECT_EQ(cell.watch.faults().open().front().subject, "h2");
}

TEST_F(CellWatchTest, ASuccessorTellsWhoDoesNotReturn) {
  for (const auto* node : {"agent/h2", "driver/arm3", "planner/arm3"}) hung.insert(node);
  run_for(200ms);
  watch.faults().recall({});
  watch.succeed("supervisor@h2", 20ms);
  run_for(5s);
  EXPECT_TRUE(watch.faults().open().empty());
  run_for(50ms);
  EXPECT_EQ(the_fault().kind, msg::CauseKind::CAUSE_HOST_LOST);
}

TEST_F(CellWatchTest, WhatFellSilentWithAPredecessorOrWasToldByItIsToldAtOnce) {
  for (const auto* node : {"agent/h2", "driver/arm3", "planner/arm3"}) hung.insert(node);
  run_for(200ms);
  const FaultHistory told = watch.faults().history();
  watch.succeed("supervisor@h2", 20ms);
  run_for(10ms);
  EXPECT_EQ(the_fault().kind, msg::CauseKind::CAUSE_HOST_LOST) << "told by it";
  EXPECT_EQ(watch.faults().history(), told);
  watch.faults().recall({});
  watch.succeed("supervisor@h2", 200ms);
  run_for(10ms);
  EXPECT_EQ(the_fault().kind, msg::CauseKind::CAUSE_HOST_LOST) << "it was silent itself";
}

TEST_F(CellWatchTest, LostAgentAloneHoldsNothing) {
  hung.insert("agent/h2");
  run_for(200ms);
  EXPECT_EQ(the_fault().kind, msg::CauseKind::CAUSE_HOST_LOST);
  EXPECT_EQ(the_fault().severity, msg::Severity::SEVERITY_WARNING);
  EXPECT_EQ(watch.mode().decide(), msg::CellMode{});
}

TEST_F(CellWatchTest, NodeThatStaysAwayWhenItsHostReturnsIsAFaultOfItsOwn) {
  for (const auto* node : {"agent/h2", "driver/arm3", "planner/arm3"}) hung.insert(node);
  run_for(200ms);
  hung = {"driver/arm3"};
  run_for(5s);
  EXPECT_TRUE(watch.faults().open().empty()) << "the network may need as long";
  run_for(200ms);
  EXPECT_EQ(the_fault().kind, msg::CauseKind::CAUSE_NODE_SILENT);
  EXPECT_EQ(the_fault().subject, "driver/arm3");
}

TEST_F(CellWatchTest, NodeThatHangsOnceItHasReturnedWithItsHostIsAFaultLikeAnyOther) {
  for (const auto* node : {"agent/h2", "driver/arm3", "planner/arm3"}) hung.insert(node);
  run_for(200ms);
  hung = {"planner/arm3"};
  run_for(900ms);
  hung = {"planner/arm3", "driver/arm3"};
  run_for(50ms);
  hung.clear();
  run_for(200ms);
  EXPECT_EQ(watch.faults().over().size(), 1U) << "a reunion";
  run_for(900ms);
  hung = {"driver/arm3"};
  run_for(30ms);
  EXPECT_EQ(the_fault().kind, msg::CauseKind::CAUSE_NODE_SILENT);
  EXPECT_EQ(the_fault().subject, "driver/arm3");
}

TEST(CellWatchStart, HostThatNeverAppearsIsOneFault) {
  VirtualCell cell;
  cell.dead = {"agent/h2", "driver/arm3", "planner/arm3"};
  cell.run_for(2s);
  const auto open = cell.watch.faults().open();
  ASSERT_EQ(open.size(), 1U);
  EXPECT_EQ(open.front().subject, "agent/h2");
  EXPECT_EQ(arms_on(cell.watch.mode().decide(), msg::Mode::MODE_HOLD), Names{"arm3"});
}

}  // namespace
}  // namespace hecaton::services::testing
