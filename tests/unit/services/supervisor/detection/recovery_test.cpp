/// Faults whose recovery waits for a person.

#include <gtest/gtest.h>

#include "tests/unit/services/supervisor/detection/virtual_cell.hpp"

namespace hecaton::services::testing {
namespace {

using Names = std::vector<std::string>;

DetectionLimits limits(std::set<msg::CauseKind> waits) {
  DetectionLimits limits = cell_limits();
  limits.waits_for_resume = std::move(waits);
  return limits;
}

class Recovery : public ::testing::Test, protected VirtualCell {
 protected:
  explicit Recovery(std::set<msg::CauseKind> waits = {msg::CauseKind::CAUSE_PROCESS_DIED,
                                                      msg::CauseKind::CAUSE_HOST_LOST, msg::CauseKind::CAUSE_CONTACT})
      : VirtualCell(cell_nodes(), limits(std::move(waits))) {
    run_for(200ms);
  }
  void die_and_return(const std::string& node) {
    kill(node, 9);
    run_for(50ms);
    start(node);
    run_for(500ms);
    EXPECT_TRUE(detector.faults().open().empty()) << "it has returned";
  }
};

TEST_F(Recovery, WaitsForResumeAfterADeath) {
  die_and_return("planner/arm2");
  EXPECT_EQ(held(), Names{"arm2"});
  EXPECT_EQ(detector.mode().cause_of("arm2").text(),
            "on hold until resumed: planner/arm2: process 107 was ended by signal 9 (Killed)");
  EXPECT_TRUE(is_none(detector.mode().resume({"arm2"})));
  run_for(50ms);
  EXPECT_EQ(held(), Names{});
}

TEST_F(Recovery, IsAutomaticByDefault) {
  hung.insert("planner/arm2");
  run_for(100ms);
  EXPECT_EQ(held(), Names{"arm2"});
  hung.clear();
  run_for(500ms);
  EXPECT_EQ(held(), Names{});
}

TEST_F(Recovery, NeedsNoSecondResumeAfterTheFault) {
  kill("planner/arm2", 9);
  run_for(50ms);
  EXPECT_TRUE(is_none(detector.mode().resume({"arm2"})));
  run_for(50ms);
  EXPECT_EQ(held(), Names{"arm2"}) << "the fault itself still holds it";
  start("planner/arm2");
  run_for(500ms);
  EXPECT_EQ(held(), Names{});
}

TEST_F(Recovery, OfALostHostAppliesToItsArms) {
  for (const char* node : {"agent/h2", "driver/arm3", "planner/arm3"}) hung.insert(node);
  run_for(1s);
  hung.clear();
  run_for(5s);
  EXPECT_TRUE(detector.faults().open().empty());
  EXPECT_EQ(held(), Names{"arm3"});
  EXPECT_TRUE(is_none(detector.mode().resume({})));
  EXPECT_EQ(held(), Names{});
}

TEST_F(Recovery, OfTheWorldAppliesToTheCell) {
  die_and_return("world");
  EXPECT_EQ(detector.mode().decide().mode(), msg::Mode::MODE_HOLD);
  EXPECT_TRUE(is_none(detector.mode().resume({})));
  EXPECT_EQ(detector.mode().decide().mode(), msg::Mode::MODE_RUN);
}

TEST_F(Recovery, OfAContactAppliesToTheCell) {
  detector.contacts(0, "", "");
  run_for(50ms);
  detector.contacts(1, "arm1/wrist", "arm1/wrist touched pallet");
  run_for(50ms);
  ASSERT_EQ(detector.faults().cleared().size(), 1U);
  EXPECT_EQ(detector.faults().cleared().front().description, "arm1/wrist touched pallet");
  EXPECT_EQ(detector.faults().cleared().front().severity, msg::Severity::SEVERITY_CRITICAL);
  EXPECT_EQ(detector.mode().decide().mode(), msg::Mode::MODE_HOLD);
  EXPECT_EQ(causes_text(detector.mode().decide()), "hold until resumed: arm1/wrist touched pallet");
  EXPECT_TRUE(is_none(detector.mode().resume({})));
  detector.contacts(1, "arm1/wrist", "arm1/wrist touched pallet");
  run_for(50ms);
  EXPECT_EQ(detector.mode().decide().mode(), msg::Mode::MODE_RUN) << "one contact, one fault";
}

TEST_F(Recovery, IgnoresAContactThatWasPublishedBefore) {
  FaultHistory history;
  history.cleared.push_back(
      {1, 1, msg::CauseKind::CAUSE_CONTACT, msg::Severity::SEVERITY_CRITICAL, "a", "a touched b", 1ms, {}, 1ms});
  detector.faults().restore(history);
  detector.contacts(3, "a", "a touched b");
  run_for(50ms);
  EXPECT_EQ(detector.mode().decide().mode(), msg::Mode::MODE_RUN);
}

struct RecoveryOfTheHung : Recovery {
  RecoveryOfTheHung() : Recovery({msg::CauseKind::CAUSE_NODE_SILENT, msg::CauseKind::CAUSE_PROCESS_DIED}) {}
};

TEST_F(RecoveryOfTheHung, NeedsNoSecondResumeForABetterExplanation) {
  hung.insert("planner/arm2");
  run_for(100ms);
  EXPECT_TRUE(is_none(detector.mode().resume({"arm2"})));
  kill("planner/arm2", 9);
  run_for(50ms);
  EXPECT_EQ(detector.faults().open("planner/arm2")->kind, msg::CauseKind::CAUSE_PROCESS_DIED);
  start("planner/arm2");
  run_for(500ms);
  EXPECT_EQ(held(), Names{});
}

// The previous leader led until shortly before and published nothing: its faults and orders are empty.
class Failover : public Recovery {
 protected:
  void take_over(Time since, FaultHistory told = {}) {
    detector.mode().restore({});
    detector.faults().restore(std::move(told));
    detector.judge_again(since);
    detector.judge(now);
  }
};

TEST_F(Failover, ReportsADeathThatTheLeaderDidNotPublish) {
  run_for(100ms);
  const Time spoke = now;
  run_for(50ms);
  const Time died = now;
  die_and_return("planner/arm2");
  take_over(spoke);
  const auto* fault = detector.faults().open("planner/arm2");
  ASSERT_NE(fault, nullptr);
  EXPECT_EQ(fault->description, "planner/arm2: process 107 was ended by signal 9 (Killed)");
  EXPECT_LE(fault->since - died, 10ms);
  EXPECT_EQ(held(), Names{"arm2"});
  turn();
  EXPECT_TRUE(detector.faults().open().empty()) << "it has returned";
  EXPECT_EQ(held(), Names{"arm2"}) << "until resumed";
  EXPECT_TRUE(is_none(detector.mode().resume({"arm2"})));
  run_for(50ms);
  EXPECT_EQ(held(), Names{});
}

TEST_F(Failover, ReportsAContactThatTheLeaderDidNotPublish) {
  detector.contacts(0, "", "");
  run_for(50ms);
  const Time spoke = now;
  detector.contacts(1, "arm1/wrist", "arm1/wrist touched pallet");
  run_for(300ms);
  take_over(spoke);
  ASSERT_EQ(detector.faults().cleared().size(), 1U);
  EXPECT_LE(detector.faults().cleared().front().since - spoke, 10ms);
  EXPECT_EQ(detector.mode().decide().mode(), msg::Mode::MODE_HOLD);
}

TEST_F(Failover, ReportsNoPublishedFaultAgain) {
  detector.contacts(0, "", "");
  run_for(50ms);
  const Time before = now;
  detector.contacts(1, "arm1/wrist", "arm1/wrist touched pallet");
  die_and_return("planner/arm2");
  const FaultHistory told = detector.faults().history();
  ASSERT_EQ(told.cleared.size(), 2U);
  take_over(before, told);
  EXPECT_EQ(detector.faults().history(), told) << "the leader published it";
  EXPECT_EQ(held(), Names{}) << "and a person resumed";
  take_over(now + 1ms);
  EXPECT_TRUE(detector.faults().cleared().empty()) << "the leader observed it before it fell silent";
}

TEST_F(Recovery, IsWaitedForAfterARestart) {
  die_and_return("planner/arm2");
  CellModeState next({"arm1", "arm2", "arm3"});
  next.restore(detector.mode().orders(), detector.mode().causes());
  EXPECT_EQ(next.cause_of("arm2").text(), detector.mode().cause_of("arm2").text());
  next.restore(detector.mode().orders());
  EXPECT_EQ(next.cause_of("arm2").text(), detector.mode().cause_of("arm2").text())
      << "orders of another leader for faults that it observed, too";
}

}  // namespace
}  // namespace hecaton::services::testing
