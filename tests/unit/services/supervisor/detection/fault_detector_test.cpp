#include "services/supervisor/detection/fault_detector.hpp"

#include <gtest/gtest.h>

#include "services/supervisor/detection/standing_arms.hpp"
#include "tests/unit/services/supervisor/detection/virtual_cell.hpp"

namespace hecaton::services::testing {
namespace {

TEST_F(FaultDetectorTest, RunsAHealthyCell) {
  run_for(10s);
  EXPECT_TRUE(detector.faults().open().empty());
  EXPECT_TRUE(detector.faults().cleared().empty());
  EXPECT_EQ(detector.mode().decide(), msg::CellMode{});
  for (const auto& node : detector.nodes()) EXPECT_TRUE(detector.alive(node.name)) << node.name;
}

TEST_F(FaultDetectorTest, ReportsADeathAtOnceAndHoldsTheArm) {
  kill("planner/arm2", 9);
  detector.judge(now);
  const FaultRecord fault = the_fault();
  EXPECT_EQ(fault.kind, msg::CauseKind::CAUSE_PROCESS_DIED);
  EXPECT_EQ(fault.subject, "planner/arm2");
  EXPECT_EQ(fault.description, "planner/arm2: process 107 was ended by signal 9 (Killed)");
  ASSERT_TRUE(fault.detection_latency_bound) << "it was heard";
  EXPECT_LE(*fault.detection_latency_bound, 10ms) << "a heartbeat period";
  EXPECT_EQ(held(), Names{"arm2"});
  EXPECT_EQ(detector.mode().cause_of("arm2").text(), "held: " + fault.description);
  EXPECT_FALSE(detector.alive("planner/arm2"));
}

TEST_F(FaultDetectorTest, ReportsAFailedNodeWithItsOwnText) {
  kill("world", 9);
  detector.judge(now);
  start("world");
  mute.insert("world");
  turn();
  detector.heard(
      "world", {pids["world"], now, 0, make_cause(msg::CauseKind::CAUSE_NODE_FAILED, "world", "cannot be recovered")});
  detector.judge(now);
  EXPECT_EQ(the_fault().kind, msg::CauseKind::CAUSE_NODE_FAILED);
  EXPECT_EQ(the_fault().description, "world: cannot be recovered");
  EXPECT_EQ(detector.mode().decide().mode(), msg::Mode::MODE_HOLD);
  EXPECT_EQ(causes_text(detector.mode().decide()), "world: cannot be recovered");
  mute.clear();
  run_for(200ms);
  EXPECT_TRUE(detector.faults().open().empty()) << "its heartbeats report no failure any more";
  EXPECT_EQ(detector.mode().decide().mode(), msg::Mode::MODE_RUN);
}

TEST_F(FaultDetectorTest, TakesTheFailureOfANodeOnlyFromItsOwnParticipant) {
  const msg::Cause failed = make_cause(msg::CauseKind::CAUSE_NODE_FAILED, "world", "cannot be recovered");
  for (int i = 0; i < 20; ++i) {
    detector.heard("world", {pids["world"], now, 0, failed, {}, false});
    turn();
    EXPECT_TRUE(detector.faults().open().empty());
  }
  mute.insert("world");
  detector.heard("world", {pids["world"], now, 0, failed});
  detector.heard("world", {pids["world"], now, 0, std::nullopt, {}, false});
  detector.judge(now);
  EXPECT_EQ(the_fault().kind, msg::CauseKind::CAUSE_NODE_FAILED) << "nor does another one end it";
}

TEST_F(FaultDetectorTest, ReportsAFailedNodeWithoutText) {
  mute.insert("world");
  turn(10ms);
  detector.heard("world", {pids["world"], now, 0, msg::Cause()});
  detector.judge(now);
  EXPECT_EQ(the_fault().kind, msg::CauseKind::CAUSE_NODE_FAILED);
  EXPECT_EQ(the_fault().description, "world: it reports that it cannot do its work");
  EXPECT_EQ(detector.mode().decide().mode(), msg::Mode::MODE_HOLD);
}

TEST_F(FaultDetectorTest, ReportsAFailedDeviceAsAFaultOfItsArm) {
  detector.device_heard("arm3", make_cause(msg::CauseKind::CAUSE_ARM_FAILED, "arm3", "joint 2: following error"));
  turn();
  EXPECT_EQ(the_fault().kind, msg::CauseKind::CAUSE_ARM_FAILED);
  EXPECT_EQ(the_fault().subject, "arm3");
  EXPECT_EQ(the_fault().description, "arm arm3: its device reports a failure: joint 2: following error");
  EXPECT_EQ(held(), Names{"arm3"});
  kill("driver/arm3", 9);
  turn();
  EXPECT_EQ(detector.faults().open().size(), 2U) << "beside the death of its driver";
  start("driver/arm3");
  run_for(500ms);
  EXPECT_EQ(the_fault().kind, msg::CauseKind::CAUSE_ARM_FAILED) << "until the driver reports that it works";
  detector.device_heard("arm3", std::nullopt);
  turn();
  EXPECT_TRUE(detector.faults().open().empty());
  EXPECT_TRUE(held().empty());
}

TEST_F(FaultDetectorTest, ReportsEachStopOfADeviceAsAFaultOfItsKind) {
  for (const msg::CauseKind kind : kDeviceFaults) {
    detector.device_heard("arm3", make_cause(kind, "arm3", "look at the arm"));
    turn();
    EXPECT_EQ(the_fault().kind, kind) << "the one before is cleared";
    EXPECT_EQ(held(), Names{"arm3"});
  }
  detector.device_heard("arm3", std::nullopt);
  turn();
  EXPECT_TRUE(held().empty());
}

msg::Refusal refusal(const std::string& sender, msg::CauseKind kind = msg::CauseKind::CAUSE_INPUT_REFUSED) {
  msg::Refusal message;
  message.cause(make_cause(kind, sender, "q[2] = nan must be from -1e+06 to 1e+06"));
  message.topic("ArmCommand");
  message.sender("010f0102");
  message.address("10.0.0.9");
  message.count(12);
  return message;
}

TEST_F(FaultDetectorTest, ReportsWhatNodesRefuseAndHoldsNoArm) {
  detector.refusal_heard("driver/arm1", refusal("intruder"));
  run_for(1s);
  EXPECT_EQ(the_fault().kind, msg::CauseKind::CAUSE_INPUT_REFUSED);
  EXPECT_EQ(the_fault().subject, "intruder");
  EXPECT_EQ(the_fault().description,
            "driver/arm1 refuses ArmCommand of intruder: q[2] = nan must be from -1e+06 to 1e+06 (GUID 010f0102, "
            "address 10.0.0.9, 12 times)");
  EXPECT_TRUE(held().empty());
  run_for(5s);
  EXPECT_TRUE(detector.faults().open().empty()) << "no node has reported it for five seconds";
}

TEST_F(FaultDetectorTest, BoundsTheFaultsOfRefusedSenders) {
  for (int i = 0; i < 1000; ++i) detector.refusal_heard("driver/arm1", refusal("forged" + std::to_string(i)));
  detector.refusal_heard("driver/arm1", refusal("x", msg::CauseKind::CAUSE_CONTACT));
  turn();
  EXPECT_EQ(detector.faults().open().size(), 16U);
}

TEST_F(FaultDetectorTest, ReportsKeysBeforeTheyExpire) {
  using std::chrono::days;
  const std::chrono::system_clock::time_point begin = std::chrono::sys_days(std::chrono::year(2027) / 1 / 31);
  const auto key = fault_key(msg::CauseKind::CAUSE_CERTIFICATE_EXPIRES, "h2");
  const auto report = [&](Time left) {
    for (const std::string node : {"agent/h2", "driver/arm3"}) keys[node] = {begin, 400 * days(1)};
    keys["planner/arm3"] = {begin, left};
    run_for(20ms);
  };
  report(days(30));
  EXPECT_TRUE(detector.faults().open().empty());
  report(days(30) - 1s);
  EXPECT_EQ(the_fault().kind, msg::CauseKind::CAUSE_CERTIFICATE_EXPIRES);
  EXPECT_EQ(the_fault().severity, msg::Severity::SEVERITY_WARNING);
  EXPECT_EQ(the_fault().subject, "h2");
  EXPECT_EQ(the_fault().description,
            "host h2: its keys expire on 2027-01-31; make new ones with `hecaton keystore renew`, and restart its "
            "services");
  EXPECT_TRUE(held().empty()) << "its processes go on with them";
  detector.adopt(key, the_fault(), now);
  report(1s);
  EXPECT_EQ(detector.faults().open().size(), 1U);
  report(0s);
  EXPECT_EQ(the_fault().severity, msg::Severity::SEVERITY_ERROR);
  EXPECT_NE(the_fault().description.find("have expired on 2027-01-31"), std::string::npos);
  EXPECT_TRUE(held().empty());
  report(days(365));
  EXPECT_TRUE(detector.faults().open().empty());
}

TEST_F(FaultDetectorTest, ReportsAnArmThatStandsWithoutReason) {
  detector.arm_stands("arm2", "arm arm2 should move, but stands");
  run_for(100ms);
  EXPECT_EQ(the_fault().kind, msg::CauseKind::CAUSE_ARM_STANDS);
  EXPECT_EQ(the_fault().subject, "arm2");
  EXPECT_TRUE(held().empty()) << "a hold would hide the reason";
  detector.arm_stands("arm2", std::nullopt);
  turn();
  EXPECT_TRUE(detector.faults().open().empty());
}

TEST_F(FaultDetectorTest, TakesBackAnEndThatHeartbeatsContradict) {
  detector.process_exited("driver/arm2", {pids["driver/arm2"], 0, 9});
  turn();
  EXPECT_EQ(held(), Names{"arm2"});
  run_for(2s);
  EXPECT_TRUE(detector.faults().open().empty()) << "its heartbeats go on: the report is wrong or forged";
  EXPECT_TRUE(held().empty());
  EXPECT_TRUE(detector.alive("driver/arm2"));
}

TEST(StandingArms, ReportAfterASecond) {
  StandingArms arms;
  EXPECT_TRUE(arms.due(1s));
  EXPECT_FALSE(arms.due(1050ms));
  EXPECT_EQ(arms.update("arm1", "nothing holds the arm", 10s), std::nullopt);
  EXPECT_EQ(arms.update("arm1", "nothing holds the arm", 10900ms), std::nullopt);
  EXPECT_EQ(arms.update("arm1", "nothing holds the arm", 11s),
            "arm arm1 should move, but stands for more than 1 s: nothing holds the arm");
  EXPECT_EQ(arms.update("arm1", std::nullopt, 12s), std::nullopt);
  EXPECT_EQ(arms.update("arm1", "nothing holds the arm", 13s), std::nullopt);
}

TEST_F(FaultDetectorTest, ReportsALongDeathAsOneFault) {
  kill("driver/arm1", 11);
  run_for(5s);
  EXPECT_EQ(the_fault().kind, msg::CauseKind::CAUSE_PROCESS_DIED);
  EXPECT_TRUE(detector.faults().cleared().empty());
}

TEST_F(FaultDetectorTest, ReleasesTheArmOnceTheRestartedNodeIsSteady) {
  kill("driver/arm1", 9);
  run_for(50ms);
  start("driver/arm1");
  run_for(90ms);
  EXPECT_EQ(held(), Names{"arm1"});
  run_for(50ms);
  EXPECT_TRUE(held().empty());
  ASSERT_EQ(detector.faults().cleared().size(), 1U);
  EXPECT_EQ(detector.faults().cleared().front().kind, msg::CauseKind::CAUSE_PROCESS_DIED);
}

TEST_F(FaultDetectorTest, DetectsARestartWithoutAnAgentByHeartbeats) {
  kill("planner/arm1", 9);
  run_for(50ms);
  start("planner/arm1", false);
  run_for(200ms);
  EXPECT_TRUE(detector.faults().open().empty());
}

TEST_F(FaultDetectorTest, IgnoresALateHeartbeatOfADeadProcess) {
  kill("planner/arm1", 9);
  detector.heard("planner/arm1", {pids["planner/arm1"], now});
  detector.judge(now);
  EXPECT_EQ(the_fault().kind, msg::CauseKind::CAUSE_PROCESS_DIED);
  run_for(5s);
  EXPECT_EQ(the_fault().kind, msg::CauseKind::CAUSE_PROCESS_DIED);
}

// Other arms go round a lost arm, as soon as the driver is known to have ended.
TEST_F(FaultDetectorTest, CountsADriverAsEndedInSpiteOfItsLateHeartbeat) {
  kill("driver/arm1", 9);
  detector.heard("driver/arm1", {pids["driver/arm1"], now});
  EXPECT_EQ(detector.loss_of_driver("arm1"), DriverLoss::kEnded);
  run_for(5s);
  EXPECT_EQ(detector.loss_of_driver("arm1"), DriverLoss::kEnded);
}

// A recorder or a view is no part of the control of an arm.
TEST_F(FaultDetectorTest, ReportsTheFailureOfAHelperAndHoldsNoArm) {
  msg::Cause full;
  full.text("the disk is full");
  detector.heard("recorder", {900, now, 1, full});
  turn();
  EXPECT_EQ(the_fault().kind, msg::CauseKind::CAUSE_NODE_FAILED);
  EXPECT_EQ(the_fault().severity, msg::Severity::SEVERITY_WARNING);
  EXPECT_EQ(the_fault().description, "recorder: the disk is full");
  EXPECT_TRUE(held().empty());
  run_for(1s);
  detector.heard("recorder", {900, now, 2, std::nullopt});
  EXPECT_TRUE(detector.faults().open().empty());

  detector.heard("recorder", {900, now, 3, full});
  detector.process_exited("recorder", {900, 0, 0, true});
  EXPECT_TRUE(detector.faults().open().empty()) << "it was ordered to end";
}

TEST_F(FaultDetectorTest, ReportsAHelperThatEndsAgainAndAgainUntilOneIsHeard) {
  const Time begun = now;
  for (int pid = 900; pid < 903; ++pid) {
    detector.process_started("ros2", pid);
    detector.process_exited("ros2", {pid, 3, 0, false});
    run_for(1s);
    EXPECT_EQ(the_fault().kind, msg::CauseKind::CAUSE_PROCESS_DIED);
    EXPECT_EQ(the_fault().severity, msg::Severity::SEVERITY_WARNING);
    EXPECT_EQ(the_fault().description, "ros2: process 900 ended with exit code 3") << "one fault, from the first end";
    EXPECT_GE(the_fault().since, begun);
    EXPECT_TRUE(held().empty());
  }
  detector.heard("ros2", {902, now, 1, std::nullopt});
  EXPECT_EQ(detector.faults().open().size(), 1U) << "a late heartbeat of the process that has ended";
  detector.process_started("ros2", 903);
  run_for(1s);
  EXPECT_EQ(detector.faults().open().size(), 1U) << "its successor has not worked yet";
  detector.heard("ros2", {903, now, 1, std::nullopt});
  EXPECT_TRUE(detector.faults().open().empty());
}

TEST_F(FaultDetectorTest, LeavesThePastEndOfAHelperToTheSupervisorThatSawIt) {
  detector.process_exited("ros2", {900, 3, 0, false}, false);
  turn();
  EXPECT_TRUE(detector.faults().open().empty());
}

TEST_F(FaultDetectorTest, BoundsTheHelpersWhoseFailuresAreFaults) {
  for (int i = 0; i < 1000; ++i) detector.heard("helper" + std::to_string(i), {i + 1000, now, 1, msg::Cause()});
  EXPECT_EQ(detector.faults().open().size(), 16U);
}

TEST_F(FaultDetectorTest, IgnoresALateExitOfAPredecessor) {
  detector.process_exited("planner/arm1", {99, -1, 9, false});
  run_for(100ms);
  EXPECT_TRUE(detector.faults().open().empty());
  EXPECT_TRUE(detector.faults().cleared().empty());
}

// A supervisor that did not run for a moment receives both at once.
TEST_F(FaultDetectorTest, ReportsADeathWhoseSuccessorIsHeardInTheSameTurn) {
  detector.process_exited("planner/arm1", {pids["planner/arm1"], -1, 9, false});
  detector.process_started("planner/arm1", ++pids["planner/arm1"]);
  detector.heard("planner/arm1", {pids["planner/arm1"], now});
  detector.judge(now);
  EXPECT_EQ(the_fault().kind, msg::CauseKind::CAUSE_PROCESS_DIED);
  run_for(5s);
  EXPECT_TRUE(detector.faults().open().empty());
  ASSERT_EQ(detector.faults().cleared().size(), 1U);
  EXPECT_EQ(detector.faults().cleared().front().kind, msg::CauseKind::CAUSE_PROCESS_DIED);
}

// The agent was not heard when the process ended. When it is heard again, the successor's heartbeats arrive first.
TEST_F(FaultDetectorTest, ReportsALateDeathOnceAndHoldsNoArm) {
  const std::int64_t killed = pids["planner/arm1"];
  pids["planner/arm1"] += 1000;
  run_for(1s);
  ASSERT_TRUE(detector.alive("planner/arm1"));
  ASSERT_TRUE(detector.faults().cleared().empty());
  ProcessExit exit{killed, -1, 9, false};
  exit.at = now - 3s;
  detector.process_exited("planner/arm1", exit);
  detector.process_started("planner/arm1", pids["planner/arm1"]);
  detector.judge(now);
  ASSERT_EQ(detector.faults().cleared().size(), 1U);
  const FaultRecord& told = detector.faults().cleared().front();
  EXPECT_EQ(told.kind, msg::CauseKind::CAUSE_PROCESS_DIED);
  EXPECT_EQ(told.since, now - 3s);
  EXPECT_TRUE(arms_on(detector.mode().decide(), msg::Mode::MODE_HOLD).empty());
  detector.process_exited("planner/arm1", exit);
  run_for(1s);
  EXPECT_EQ(detector.faults().cleared().size(), 1U) << "one fault";
  EXPECT_TRUE(detector.faults().open().empty());
}

TEST_F(FaultDetectorTest, DoesNotRepeatFaultsOfItsPredecessor) {
  kill("driver/arm1", 9);
  detector.judge(now);
  start("driver/arm1");
  run_for(1s);
  FaultDetector successor(cell_nodes(), {"arm1", "arm2", "arm3"}, cell_limits(), now);
  successor.faults().restore(detector.faults().history());
  const std::int64_t killed = pids["driver/arm1"] - 1000;
  successor.process_exited("driver/arm1", {killed, -1, 9, false});
  successor.process_started("driver/arm1", pids["driver/arm1"]);
  successor.heard("driver/arm1", {pids["driver/arm1"], now});
  successor.judge(now);
  EXPECT_TRUE(successor.faults().open().empty());
  EXPECT_EQ(successor.faults().cleared().size(), 1U);
  // Unreported exits are reported.
  successor.process_exited("driver/arm2", {pids["driver/arm2"], -1, 9, false});
  successor.process_started("driver/arm2", pids["driver/arm2"] + 1000);
  successor.judge(now);
  EXPECT_EQ(successor.faults().open().size(), 1U);
}

TEST_F(FaultDetectorTest, ReportsAnOldUnreportedDeathAndHoldsNoArm) {
  ProcessExit exit{pids["driver/arm1"] - 50, -1, 9, false};
  exit.at = now - 30s;
  FaultDetector late(cell_nodes(), {"arm1", "arm2", "arm3"}, cell_limits(), now);
  late.process_exited("driver/arm1", exit);
  late.process_started("driver/arm1", pids["driver/arm1"]);
  // Its successor is heard for long enough to be alive.
  for (int k = 0; k < 40; ++k) {
    late.advance(now + 5ms * k);
    late.heard("driver/arm1", {pids["driver/arm1"], now + 5ms * k});
    late.stream_heard("driver/arm1", now + 5ms * k);
  }
  late.judge(now + 200ms);
  ASSERT_EQ(late.faults().cleared().size(), 1U) << "cleared at once";
  EXPECT_EQ(late.faults().cleared().front().since, now - 30s);
  EXPECT_TRUE(arms_on(late.mode().decide(), msg::Mode::MODE_HOLD).empty());
}

TEST_F(FaultDetectorTest, ReportsOnlyLastingFaultsOfThePastWithoutACheckpoint) {
  FaultDetector newcomer(cell_nodes(), {"arm1", "arm2", "arm3"}, cell_limits(), now);
  newcomer.process_exited("driver/arm1", {99, -1, 9, false}, false);
  newcomer.process_started("driver/arm1", pids["driver/arm1"]);
  newcomer.process_exited("driver/arm2", {pids["driver/arm2"], -1, 9, false}, false);
  newcomer.judge(now);
  const auto open = newcomer.faults().open();
  ASSERT_EQ(open.size(), 1U);
  EXPECT_EQ(open.front().subject, "driver/arm2") << "it has no successor";
}

TEST_F(FaultDetectorTest, IgnoresAnOrderedEnd) {
  dead.insert("planner/arm1");
  detector.process_exited("planner/arm1", {pids["planner/arm1"], 0, 0, true});
  run_for(5s);
  EXPECT_TRUE(detector.faults().open().empty());
  EXPECT_EQ(detector.awaited("planner/arm1").text(), "planner/arm1 was ordered to end");
}

TEST_F(FaultDetectorTest, ReportsAHangAsNodeSilentUntilItEnds) {
  hung.insert("planner/arm3");
  run_for(35ms);
  const FaultRecord fault = the_fault();
  EXPECT_EQ(fault.kind, msg::CauseKind::CAUSE_NODE_SILENT);
  EXPECT_EQ(fault.severity, msg::Severity::SEVERITY_WARNING);
  EXPECT_EQ(fault.subject, "planner/arm3");
  EXPECT_EQ(held(), Names{"arm3"});
  run_for(200ms);
  EXPECT_EQ(the_fault().severity, msg::Severity::SEVERITY_ERROR);
  hung.clear();
  run_for(150ms);
  EXPECT_TRUE(detector.faults().open().empty());
  EXPECT_TRUE(held().empty());
}

TEST_F(FaultDetectorTest, ReportsAHungDriverAsOneFault) {
  hung.insert("driver/arm1");
  run_for(5s);
  EXPECT_EQ(the_fault().kind, msg::CauseKind::CAUSE_NODE_SILENT);
  EXPECT_TRUE(detector.faults().cleared().empty());
}

TEST_F(FaultDetectorTest, ReportsADriverWithoutStatesAsDriverSilent) {
  mute.insert("driver/arm1");
  run_for(60ms);
  const FaultRecord fault = the_fault();
  EXPECT_EQ(fault.kind, msg::CauseKind::CAUSE_DRIVER_SILENT);
  EXPECT_EQ(fault.subject, "arm1");
  EXPECT_EQ(held(), Names{"arm1"});
  mute.clear();
  run_for(150ms);
  EXPECT_TRUE(detector.faults().open().empty());
}

TEST_F(FaultDetectorTest, CorrectsASilentStreamToADeath) {
  mute.insert("driver/arm1");
  run_for(100ms);
  hung.insert("driver/arm1");
  run_for(100ms);
  kill("driver/arm1", 6);
  run_for(100ms);
  EXPECT_EQ(the_fault().kind, msg::CauseKind::CAUSE_PROCESS_DIED);
  EXPECT_EQ(the_fault().number, 1U);
}

TEST_F(FaultDetectorTest, HoldsTheCellForASilentWorld) {
  mute.insert("world");
  run_for(100ms);
  EXPECT_EQ(the_fault().kind, msg::CauseKind::CAUSE_WORLD_SILENT);
  EXPECT_EQ(detector.mode().decide().mode(), msg::Mode::MODE_HOLD);
  mute.clear();
  hung.insert("world");
  run_for(100ms);
  EXPECT_EQ(detector.mode().decide().mode(), msg::Mode::MODE_HOLD);
  hung.clear();
  run_for(200ms);
  EXPECT_EQ(detector.mode().decide().mode(), msg::Mode::MODE_RUN);
}

TEST_F(FaultDetectorTest, LosesAnArmWithItsDriversProcessUntilASuccessorIsHeard) {
  EXPECT_EQ(detector.loss_of_driver("arm1"), DriverLoss::kNone);
  kill("planner/arm1", 9);
  turn();
  EXPECT_EQ(detector.loss_of_driver("arm1"), DriverLoss::kNone) << "its driver sends states";
  kill("driver/arm1", 9);
  turn();
  EXPECT_EQ(detector.loss_of_driver("arm1"), DriverLoss::kEnded);
  EXPECT_EQ(detector.loss_of_driver("arm2"), DriverLoss::kNone);
  start("driver/arm1");
  turn(10ms);
  EXPECT_EQ(detector.loss_of_driver("arm1"), DriverLoss::kNone);
  hung.insert("driver/arm2");
  run_for(200ms);
  EXPECT_EQ(detector.loss_of_driver("arm2"), DriverLoss::kNone) << "a hanging driver may continue at any moment";
}

TEST_F(FaultDetectorTest, ReportsAllSimultaneousFaults) {
  kill("planner/arm1", 9);
  hung.insert("driver/arm2");
  mute.insert("driver/arm3");
  run_for(100ms);
  std::map<std::string, msg::CauseKind> kinds;
  for (const FaultRecord& fault : detector.faults().open()) kinds[fault.subject] = fault.kind;
  const std::map<std::string, msg::CauseKind> expected{{"planner/arm1", msg::CauseKind::CAUSE_PROCESS_DIED},
                                                       {"driver/arm2", msg::CauseKind::CAUSE_NODE_SILENT},
                                                       {"arm3", msg::CauseKind::CAUSE_DRIVER_SILENT}};
  EXPECT_EQ(kinds, expected);
  EXPECT_EQ(held(), (Names{"arm1", "arm2", "arm3"}));
}

TEST_F(FaultDetectorTest, ReportsFlappingAsOneFault) {
  for (int i = 0; i < 40; ++i) {
    hung.insert("planner/arm1");
    run_for(40ms);
    hung.clear();
    run_for(40ms);
    EXPECT_EQ(held(), Names{"arm1"});
  }
  EXPECT_EQ(the_fault().number, 1U);
  EXPECT_TRUE(detector.faults().cleared().empty());
}

TEST_F(FaultDetectorTest, ReportsNoFaultForOwnStalls) {
  for (int i = 0; i < 20; ++i) {
    now += 126ms;  // nothing arrived while the whole machine stood still
    detector.advance(now);
    detector.judge(now);
    run_for(100ms);
  }
  EXPECT_TRUE(detector.faults().open().empty());
  EXPECT_TRUE(detector.faults().cleared().empty());
}

TEST_F(FaultDetectorTest, DetectsAHangDuringAnOwnStallAfterwards) {
  hung.insert("planner/arm1");
  now += 126ms;
  detector.advance(now);
  detector.judge(now);
  EXPECT_TRUE(detector.faults().open().empty());
  run_for(40ms);
  EXPECT_EQ(the_fault().subject, "planner/arm1");
}

TEST(FaultDetectorStart, ReportsMissingNodesAfterTheGrace) {
  VirtualCell cell;
  for (const auto& node : cell.detector.nodes()) cell.dead.insert(node.name);
  for (const auto* node : {"agent/h1", "agent/h2", "world"}) cell.dead.erase(node);
  cell.run_for(990ms);
  EXPECT_TRUE(cell.detector.faults().open().empty());
  EXPECT_EQ(cell.detector.mode().decide(), msg::CellMode{});
  EXPECT_EQ(cell.detector.awaited("planner/arm1").text(), "planner/arm1 has not appeared yet");
  for (const auto& node : cell.detector.nodes()) {
    if (node.name != "planner/arm1") cell.dead.erase(node.name);
  }
  cell.run_for(20ms);
  const auto open = cell.detector.faults().open();
  ASSERT_EQ(open.size(), 1U);
  EXPECT_EQ(open.front().kind, msg::CauseKind::CAUSE_NODE_MISSING);
  EXPECT_EQ(open.front().description, "planner/arm1 did not appear within 1000 ms");
  cell.dead.clear();
  cell.run_for(200ms);
  EXPECT_TRUE(cell.detector.faults().open().empty());
}

TEST(FaultDetectorStandby, HoldsAnArmForThePlannerInChargeOnly) {
  const std::vector<ExpectedNode> nodes{{"agent/h1", msg::NodeKind::NODE_AGENT, "", "h1"},
                                        {"planner/arm1", msg::NodeKind::NODE_PLANNER, "arm1", "h1"},
                                        {"planner/arm1@h2", msg::NodeKind::NODE_PLANNER, "arm1", "h2"},
                                        {"supervisor@h2", msg::NodeKind::NODE_SUPERVISOR, "", "h2"}};
  FaultDetector detector(nodes, {"arm1"}, cell_limits(), 0ms);
  detector.advance(5ms);
  for (const ExpectedNode& node : nodes) detector.heard(node.name, {1, 5ms});
  detector.put_in_charge("arm1", "planner/arm1");
  detector.judge(5ms);
  EXPECT_FALSE(detector.ended("planner/arm1"));
  detector.process_exited("planner/arm1", {1, -1, 9, false});
  detector.process_exited("supervisor@h2", {1, -1, 9, false});
  EXPECT_TRUE(detector.ended("planner/arm1"));
  detector.judge(5ms);
  EXPECT_EQ(detector.mode().mode_of("arm1"), msg::Mode::MODE_HOLD);
  detector.put_in_charge("arm1", "planner/arm1@h2");
  detector.judge(5ms);
  EXPECT_EQ(detector.mode().mode_of("arm1"), msg::Mode::MODE_RUN)
      << "neither its standby nor a supervisor holds an arm";
  EXPECT_NE(detector.faults().open("planner/arm1"), nullptr);
  EXPECT_NE(detector.faults().open("supervisor@h2"), nullptr);
  detector.advance(10ms);
  detector.advance(15ms);
  EXPECT_EQ(detector.silence("planner/arm1@h2"), 10ms);
  EXPECT_EQ(detector.silence("planner/arm1@h3"), std::nullopt);
}

// Faults that another supervisor published on its side of a partition: here all nodes are healthy.
TEST_F(FaultDetectorTest, ClearsAdoptedFaultsWhoseCauseHasEnded) {
  FaultRecord theirs{
      9,  4, msg::CauseKind::CAUSE_NODE_SILENT, msg::Severity::SEVERITY_ERROR, "planner/arm1", "silent", now - 1s,
      {}, {}};
  detector.adopt("planner/arm1", theirs, now);
  theirs.number = 5;
  theirs.subject = "supervisor";
  detector.adopt("supervisor", theirs, now);
  EXPECT_EQ(the_fault().subject, "planner/arm1") << "it does not judge its own node";
  turn();
  EXPECT_TRUE(detector.faults().open().empty());
  ASSERT_EQ(detector.faults().cleared().size(), 2U);
  EXPECT_EQ(detector.faults().cleared().front().number, 4U);
  EXPECT_EQ(detector.faults().cleared().front().cleared_at, now);
}

TEST_F(FaultDetectorTest, KeepsAdoptedFaultsWhileTheirCauseLasts) {
  hung.insert("planner/arm1");
  run_for(100ms);
  const FaultRecord ours = the_fault();
  FaultRecord theirs = ours;
  theirs.opening_term = 9;
  detector.faults().clear("planner/arm1", now);
  detector.adopt("planner/arm1", theirs, now);
  run_for(100ms);
  EXPECT_EQ(the_fault().opening_term, 9U) << "no second one for the same cause";
  hung.clear();
  run_for(200ms);
  EXPECT_TRUE(detector.faults().open().empty());
}

TEST_F(FaultDetectorTest, ReportsTwoProcessesOfOneNode) {
  const auto beat_of_another = [&](int beats) {
    for (int i = 0; i < beats; ++i) {
      turn(10ms);  // first one process sends a heartbeat, then the other
      detector.heard("planner/arm1", {7, now});
      detector.judge(now);
    }
  };
  beat_of_another(2);
  EXPECT_TRUE(detector.faults().open().empty()) << "they may be late samples";
  beat_of_another(10);
  EXPECT_EQ(the_fault().kind, msg::CauseKind::CAUSE_DUPLICATE_NODE);
  EXPECT_EQ(the_fault().subject, "planner/arm1");
  EXPECT_EQ(the_fault().description, "planner/arm1: processes 7 and " + std::to_string(pids["planner/arm1"]) +
                                         " are this node at one time: end one of them");
  EXPECT_TRUE(held().empty());
  run_for(2s);
  EXPECT_TRUE(detector.faults().open().empty());
  kill("planner/arm1", 9);
  start("planner/arm1");
  run_for(2s);
  EXPECT_EQ(detector.faults().cleared().size(), 2U) << "a successor is no duplicate";
}

}  // namespace
}  // namespace hecaton::services::testing
