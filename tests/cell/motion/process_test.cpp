// Services as programs: signals, exit codes, heartbeats.
#include "tests/cell/motion/motion_cell.hpp"

namespace hecaton::test {
namespace {

using MotionProcess = MotionCell;

TEST_F(MotionProcess, EndsOnSigtermWithExitCodeZero) {
  start_all();
  for (ChildProcess& process : processes_) {
    process.signal(SIGTERM);
    const Exit exit = process.wait(10s);
    ASSERT_TRUE(exit.ended);
    EXPECT_EQ(exit.signal, 0);
    EXPECT_EQ(exit.code, 0);
  }
}

TEST_F(MotionProcess, EndsOnSigtermDuringItsStart) {
  for (const bool interrupt : {false, true}) {
    start_world();
    start_driver();
    start_planner();
    for (ChildProcess& process : processes_) {
      // Any instant after main() has begun: the log's first line is written before the loop.
      ASSERT_TRUE(await([&] { return !process.standard_error().empty() || process.wait(0ms).ended; }));
      process.signal(interrupt ? SIGINT : SIGTERM);
      EXPECT_EQ(process.wait(10s).code, 0);
    }
    processes_.clear();
  }
}

TEST_F(MotionProcess, PublishesItsIdentityAndStateInHeartbeats) {
  start_all();
  ASSERT_TRUE(await([&] {
    return alive_.contains("planner/arm1") && alive_["planner/arm1"].state() == msg::NodeState::NODE_RUNNING &&
           alive_["planner/arm1"].tick_p99_us() > 0.0 && alive_.contains("driver/arm1") && alive_.contains("world");
  }));
  const msg::Heartbeat& planner = alive_["planner/arm1"];
  EXPECT_EQ(planner.kind(), msg::NodeKind::NODE_PLANNER);
  EXPECT_EQ(planner.subject(), "arm1");
  EXPECT_EQ(planner.host(), "localhost");
  EXPECT_EQ(planner.term(), 1U);
  EXPECT_GE(planner.tick_max_us(), planner.tick_p99_us());
  EXPECT_GE(planner.tick_p99_us(), planner.tick_p50_us());
  EXPECT_GT(planner.rss_bytes(), 0U);
  EXPECT_EQ(alive_["driver/arm1"].kind(), msg::NodeKind::NODE_DRIVER);
  EXPECT_EQ(alive_["world"].kind(), msg::NodeKind::NODE_WORLD);
  const auto ticks = planner.ticks();
  ASSERT_TRUE(await([&] { return alive_["planner/arm1"].ticks() > ticks; }));
}

// More often than a planner or the world looks at it would only cost; what others decide on does not wait.
TEST_F(MotionProcess, PublishesTheArmsStateOnceAPeriodAndChangesAtOnce) {
  start_all();
  history_.clear();
  send(joint_goal("go", kReady));
  ASSERT_TRUE(await([&] { return is("go", msg::GoalState::GOAL_REACHED); }));
  set_mode(msg::Mode::MODE_STOP, 1, "test");
  ASSERT_TRUE(await([&] { return arm()->mode() != msg::ArmMode::ARM_RUNNING; }));
  ASSERT_GT(history_.size(), 20U);
  bool changed = false;
  for (std::size_t i = 1; i < history_.size(); ++i) {
    const msg::ArmState& before = history_[i - 1];
    const msg::ArmState& state = history_[i];
    const bool same = before.mode() == state.mode() && before.cause().kind() == state.cause().kind() &&
                      before.planner() == state.planner() && before.newest_term() == state.newest_term();
    changed = changed || !same;
    if (same && state.sequence_number() == before.sequence_number() + 1) {
      EXPECT_GE(state.stamp_ns() - before.stamp_ns(), 8'000'000) << "of a period of 10 ms";
    }
  }
  EXPECT_TRUE(changed);
}

TEST_F(MotionProcess, ReportsBadInputInOneSentenceWithExitCodeThree) {
  const std::vector<std::vector<std::string>> bad{
      {"no_such_cell.yaml", "--arm", "arm1"}, {path_, "--arm", "arm9"}, {path_, "--arm", "arm1", "--log-file", "/"}};
  for (const auto& arguments : bad) {
    for (const char* program : {"hecaton-planner", "hecaton-arm-driver"}) {
      ChildProcess process(program, arguments);
      EXPECT_EQ(process.wait(30s).code, 3) << program;
      const std::string said = process.standard_error();
      EXPECT_EQ(std::count(said.begin(), said.end(), '\n'), 1) << said;
    }
  }
  ChildProcess unknown("hecaton-planner", {path_, "--arm", "arm9"});
  EXPECT_EQ(unknown.wait(30s).code, 3);
  EXPECT_EQ(unknown.standard_error(), "hecaton-planner: " + path_ + ": --arm arm9 must be one of arm1\n");
}

TEST_F(MotionProcess, DistinguishesWrongUsageFromABadValue) {
  for (const auto& arguments :
       std::vector<std::vector<std::string>>{{}, {path_}, {path_, "--arm", "arm1", "--nonsense"}}) {
    ChildProcess process("hecaton-planner", arguments);
    EXPECT_EQ(process.wait(30s).code, 2);
  }
  ChildProcess far("hecaton-planner", {path_, "--arm", "arm1", "--domain", "200"});
  EXPECT_EQ(far.wait(30s).code, 3);
  ChildProcess help("hecaton-world", {"--help"});
  EXPECT_EQ(help.wait(30s).code, 0);
  EXPECT_NE(help.standard_output().find("CELL"), std::string::npos);
}

}  // namespace
}  // namespace hecaton::test
