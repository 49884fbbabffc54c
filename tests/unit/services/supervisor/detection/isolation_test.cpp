// Detection of isolation: of the supervisor's own host (deaf or mute) and of other hosts that are deaf.

#include <algorithm>

#include <gtest/gtest.h>

#include "tests/unit/services/supervisor/detection/virtual_cell.hpp"

namespace hecaton::services::testing {
namespace {

/// The supervisor runs alone on a third host.
class Isolation : public ::testing::Test, protected VirtualCell {
 protected:
  explicit Isolation(const DetectionLimits& limits = cell_limits())
      : VirtualCell(nodes_of_three_hosts(), limits, "h3") {
    run_for(500ms);
  }
  void cut_off() {
    mute_host("h3");
    deafen_host("h3");
    cut.erase({"h3", "h3"});
  }
  void mute_own() {
    mute_host("h3");
    cut.erase({"h3", "h3"});
  }
  msg::CauseKind kind_of_first() { return detector.faults().open().front().kind; }
};

// The own link is more likely to have failed than all other links. The hosts return one after the other.
TEST_F(Isolation, ReportsOnlyItsOwnHostWhenItHearsNoOther) {
  cut_off();
  run_for(2s);
  ASSERT_EQ(faulty(), Names{"h3"});
  EXPECT_EQ(kind_of_first(), msg::CauseKind::CAUSE_HOST_ISOLATED);
  EXPECT_EQ(detector.mode().decide().mode(), msg::Mode::MODE_HOLD);
  cut.clear();
  fall_silent("h2");
  run_for(150ms);
  EXPECT_EQ(faulty(), Names{}) << "it has just returned";
  EXPECT_EQ(held(), Names{"arm3"});
  run_for(150ms);
  EXPECT_EQ(faulty(), Names{"h2"}) << "h1 has heard it and no longer does";
  hung.insert("driver/arm1");
  run_for(50ms);
  EXPECT_EQ(faulty(), Names{"h2"}) << "discovery may still match it";
  hung.erase("driver/arm1");
  run_for(1100ms);
  hung.insert("driver/arm1");
  run_for(50ms);
  EXPECT_EQ(faulty(), (Names{"h2", "driver/arm1"})) << "it had returned";
}

// Heartbeats have different phases and delays.
TEST_F(Isolation, ReportsNoHostThatFellSilentALittleEarlier) {
  std::size_t cleared = 0;  // faults of its own host
  for (const Time before : {Time(10ms), Time(20ms), Time(40ms)}) {
    cut_link("h2", "h3");
    run_for(before);
    cut_off();
    run_for(1s);
    EXPECT_EQ(faulty(), Names{"h3"}) << before.count();
    EXPECT_EQ(detector.faults().cleared().size(), cleared) << "none before";
    cut.clear();
    run_for(10s);
    cleared = detector.faults().cleared().size();
  }
}

TEST_F(Isolation, SingleHeartbeatsAreNoReturn) {
  cut_off();
  run_for(300ms);
  for (int i = 0; i < 5; ++i) {
    cut.erase({"h1", "h3"});
    run_for(10ms);
    cut_link("h1", "h3");
    run_for(i < 4 ? 140ms : 20s);
  }
  EXPECT_EQ(faulty(), Names{"h3"});
  EXPECT_TRUE(detector.faults().cleared().empty()) << "one long fault";
}

TEST_F(Isolation, ReportsTheLinkOfTheTwoHostsThatRemain) {
  fall_silent("h2");
  run_for(300ms);
  fall_silent("h1");
  run_for(300ms);
  EXPECT_EQ(faulty(), (Names{"h2", "h1<->h3"}));
}

TEST_F(Isolation, JudgesItsOwnAgentAfreshAfterItsReturn) {
  cut_off();
  run_for(200ms);
  cut.clear();
  run_for(200ms);
  ASSERT_EQ(faulty(), Names{});
  hung = {"agent/h3"};
  run_for(200ms);
  ASSERT_EQ(faulty(), Names{"agent/h3"});
  EXPECT_EQ(kind_of_first(), msg::CauseKind::CAUSE_NODE_SILENT);
}

TEST_F(Isolation, WaitsForStatesOfReturningDrivers) {
  cut_off();
  run_for(200ms);
  cut.clear();
  mute = {"driver/arm3", "world"};
  run_for(300ms);
  EXPECT_EQ(faulty(), Names{});
  EXPECT_EQ(held(), Names{"arm3"});
  EXPECT_EQ(detector.mode().decide().mode(), msg::Mode::MODE_HOLD);
  mute.clear();
  run_for(300ms);
  EXPECT_EQ(detector.mode().decide(), msg::CellMode{});
}

TEST_F(Isolation, HoldsTheArmOfANodeThatStaysAwayUntilItIsReported) {
  cut_off();
  run_for(1s);
  cut.clear();
  hung = {"driver/arm3"};
  for (const Time end = now + 6s; now < end; turn()) {
    const Names names = held();
    ASSERT_TRUE(std::count(names.begin(), names.end(), "arm3")) << "at " << now.count();
  }
  EXPECT_EQ(faulty(), Names{"driver/arm3"});
}

TEST_F(Isolation, JudgesReturnedNodesLikeAnyOther) {
  cut_off();
  run_for(1s);
  cut.clear();
  run_for(1300ms);
  hung = {"driver/arm3"};
  run_for(50ms);
  hung.clear();
  run_for(300ms);
  EXPECT_EQ(faulty(), Names{});
  hung = {"driver/arm3"};
  run_for(50ms);
  EXPECT_EQ(faulty(), Names{"driver/arm3"}) << "also if it hangs again soon";
}

TEST_F(Isolation, ReportsItsOwnMuteHostWithinALease) {
  mute_own();
  run_for(90ms);
  EXPECT_EQ(faulty(), Names{});
  run_for(50ms);
  ASSERT_EQ(faulty(), Names{"h3"});
  EXPECT_EQ(kind_of_first(), msg::CauseKind::CAUSE_HOST_ISOLATED);
  EXPECT_TRUE(held().empty()) << "all drivers are heard";
  cut.clear();
  run_for(150ms);
  EXPECT_EQ(faulty(), Names{});
}

// Peers drop a mute host, process by process, which prolongs the silence by 2.5 s.
TEST_F(Isolation, ReportsNoHostThatDroppedItsMuteHost) {
  mute_own();
  run_for(1400ms);
  for (const char* node : {"agent/h1", "planner/arm3", "world"}) {
    hung.insert(node);
    run_for(100ms);
  }
  fall_silent("h1");
  run_for(300ms);
  EXPECT_EQ(faulty(), Names{"h3"});
  fall_silent("h2");
  run_for(300ms);
  cut.clear();
  hung = {"agent/h1", "planner/arm1"};
  run_for(1s);
  EXPECT_EQ(faulty(), Names{}) << "h2 has found it again, and h1 hears h2";
  hung.clear();
  run_for(6s);
  EXPECT_EQ(faulty(), Names{});
  ASSERT_EQ(detector.faults().cleared().size(), 1U);
  EXPECT_EQ(detector.mode().decide(), msg::CellMode{});
  fall_silent("h2");
  run_for(110ms);
  EXPECT_EQ(faulty(), Names{"h2"}) << "it had returned";
}

TEST_F(Isolation, ReportsDeathsOfIsolatedHosts) {
  mute_own();
  for (const ExpectedNode& node : detector.nodes()) {
    if (node.role != msg::NodeKind::NODE_AGENT && node.host != "h3") kill(node.name, 9);
  }
  run_for(1s);
  EXPECT_EQ(faulty().size(), 8U) << "seven, and its own host";
}

TEST_F(Isolation, ReportsNoIsolationForItsOwnHungAgent) {
  hung.insert("agent/h3");
  run_for(5s);
  EXPECT_EQ(faulty(), Names{"agent/h3"});
  hung.clear();
  run_for(1s);
  EXPECT_EQ(faulty(), Names{});
}

TEST_F(Isolation, ReportsADeafHostAndNoneOfItsNodes) {
  deafen_host("h2");
  cut.erase({"h2", "h2"});
  run_for(150ms);
  ASSERT_EQ(faulty(), Names{"h2"});
  EXPECT_EQ(kind_of_first(), msg::CauseKind::CAUSE_HOST_ISOLATED);
  EXPECT_TRUE(detector.is_isolated("planner/arm3"));
  hung.insert("planner/arm3");  // peers drop one process after the other
  run_for(100ms);
  EXPECT_EQ(faulty(), Names{"h2"});
  fall_silent("h2");
  run_for(1s);
  EXPECT_EQ(faulty(), Names{"h2"});
  cut.clear();
  hung.clear();
  run_for(200ms);
  EXPECT_EQ(faulty(), Names{});
  EXPECT_EQ(detector.faults().cleared().size(), 1U) << "one long fault";
}

TEST_F(Isolation, ReportsALostLinkToTheSupervisorWhenAnotherHostHearsTheSender) {
  cut_link("h2", "h3");
  run_for(180ms);
  ASSERT_EQ(faulty(), Names{"h2<->h3"});
  EXPECT_EQ(kind_of_first(), msg::CauseKind::CAUSE_LINK_LOST);
  EXPECT_EQ(held(), Names{"arm3"});
  EXPECT_EQ(detector.loss_of_driver("arm3"), DriverLoss::kNone) << "other hosts receive its states";
  cut.clear();
  hung.insert("planner/arm3");
  run_for(200ms);
  EXPECT_EQ(faulty(), Names{}) << "discovery may still match it";
  EXPECT_EQ(held(), Names{"arm3"});
}

TEST_F(Isolation, ReportsALostLinkFromTheSupervisorWhenAnotherHostHearsIt) {
  cut_link("h3", "h2");
  run_for(180ms);
  EXPECT_EQ(faulty(), Names{"h2<->h3"});
  EXPECT_TRUE(held().empty());
}

TEST_F(Isolation, ReportsALostLinkBetweenOtherHostsAsAWarning) {
  cut_link("h1", "h2");
  run_for(200ms);
  ASSERT_EQ(faulty(), Names{"h1<->h2"});
  EXPECT_EQ(detector.faults().open().front().severity, msg::Severity::SEVERITY_WARNING);
  EXPECT_TRUE(held().empty());
  cut.clear();
  run_for(200ms);
  EXPECT_EQ(faulty(), Names{});
}

struct IsolationOnASharedMachine : Isolation {
  IsolationOnASharedMachine() : Isolation(patient_limits()) { run_for(2s); }
};

TEST_F(IsolationOnASharedMachine, ReportsADeafHostThatOneNewProcessHears) {
  cut_off();
  run_for(2s);
  detector.heard("planner/arm3", {pids["planner/arm3"], now});
  run_for(2s);
  EXPECT_EQ(faulty(), Names{"h3"});
  EXPECT_TRUE(detector.faults().cleared().empty());
  cut.clear();
  run_for(500ms);
  EXPECT_EQ(faulty(), Names{});
  EXPECT_EQ(detector.mode().decide(), msg::CellMode{});
}

// A mute of 1.54 s is too short for most processes to drop this host, but one does just then.
TEST_F(IsolationOnASharedMachine, ReportsNoAgentThatDropsTheHostAsTheMuteEnds) {
  mute_own();
  run_for(1540ms);
  EXPECT_EQ(faulty(), Names{"h3"});
  cut.clear();
  run_for(50ms);
  hung.insert("agent/h2");
  run_for(4300ms);
  EXPECT_EQ(faulty(), Names{});
  hung.clear();
  run_for(10s);
  EXPECT_EQ(faulty(), Names{});
  EXPECT_EQ(detector.faults().cleared().size(), 1U);
  fall_silent("h2");
  run_for(1100ms);
  EXPECT_EQ(faulty(), Names{"h2"}) << "it had returned";
}

struct IsolationThatWaits : Isolation {
  static DetectionLimits limits() {
    DetectionLimits limits = cell_limits();
    limits.waits_for_resume.insert(msg::CauseKind::CAUSE_HOST_LOST);
    return limits;
  }
  IsolationThatWaits() : Isolation(limits()) {}
};

TEST_F(IsolationThatWaits, HoldsUnheardArmsUntilResume) {
  cut_off();
  run_for(200ms);
  cut.clear();
  run_for(500ms);
  EXPECT_EQ(faulty(), Names{});
  EXPECT_NE(detector.mode().decide(), msg::CellMode{});
}

TEST_F(IsolationThatWaits, HoldsTheArmOfADeafHostUntilResumeOnceItIsSilent) {
  deafen_host("h2");
  cut.erase({"h2", "h2"});
  run_for(150ms);
  ASSERT_EQ(faulty(), Names{"h2"});
  EXPECT_TRUE(held().empty()) << "its nodes are heard";
  fall_silent("h2");  // h2 has dropped its peers
  run_for(1s);
  EXPECT_EQ(detector.mode().orders().arms,
            (std::map<std::string, msg::Mode, std::less<>>{{"arm3", msg::Mode::MODE_HOLD}}));
  cut.clear();
  hung.clear();
  run_for(10s);
  EXPECT_EQ(faulty(), Names{});
  EXPECT_EQ(held(), Names{"arm3"}) << "until resumed";
}

TEST_F(IsolationThatWaits, NeedsOneResumeForTheArmOfADeafHost) {
  deafen_host("h2");
  cut.erase({"h2", "h2"});
  run_for(150ms);
  fall_silent("h2");
  run_for(1s);
  EXPECT_TRUE(is_none(detector.mode().resume({"arm3"})));
  run_for(100ms);
  EXPECT_TRUE(detector.mode().orders().empty());
  EXPECT_EQ(held(), Names{"arm3"}) << "the fault itself still holds it";
}

}  // namespace
}  // namespace hecaton::services::testing
