/// The client library against a running cell of three arms.

#include <algorithm>
#include <atomic>
#include <cmath>
#include <future>
#include <limits>
#include <thread>

#include <hecaton/client.hpp>

#include "tests/cell/cli/live_cell.hpp"
#include "tests/support/signal_process.hpp"

namespace hecaton::test {
namespace {

class ClientTest : public LiveCell {
 protected:
  [[nodiscard]] Cell connect() const {
    ConnectOptions options;
    options.domain = domain_.number();
    return Cell::connect(options, kPatience);
  }
};

TEST_F(ClientTest, ReportsProgressAndOutcomeOfAGoal) {
  std::promise<Progress> first;
  std::atomic<int> calls = 0;
  const Cell cell = connect();
  const Goal goal = cell.arm("north").go_to("ready", {60s});
  goal.on_progress([&](const Progress& progress) {
    if (calls++ == 0) first.set_value(progress);
  });
  const Progress progress = first.get_future().get();
  EXPECT_EQ(progress.arm, "north");
  EXPECT_EQ(progress.goal, goal.id());
  const Outcome outcome = goal.wait(kPatience);
  EXPECT_EQ(outcome.kind, OutcomeKind::kReached) << outcome.text();
  EXPECT_TRUE(outcome);
  ASSERT_TRUE(outcome.progress);
  EXPECT_EQ(outcome.progress->q_goal.size(), 6U);
  goal.on_progress({});

  const ArmState state = cell.arm("north").state(kPatience);
  ASSERT_EQ(state.q.size(), 6U);
  for (std::size_t j = 0; j < state.q.size(); ++j) EXPECT_NEAR(state.q[j], outcome.progress->q_goal[j], 0.01);
  EXPECT_GE(state.age.count(), 0.0);
}

TEST_F(ClientTest, ReportsRejectedGoalsAndUnknownNames) {
  const Cell cell = connect();
  const Outcome outside = cell.arm("north").go_to({9.0, 0.0, 0.0, 0.0, 0.0, 0.0}).wait(kPatience);
  EXPECT_EQ(outside.kind, OutcomeKind::kRejected);
  EXPECT_TRUE(outside.cause());
  EXPECT_NE(outside.text().find("joint1"), std::string::npos) << outside.text();
  EXPECT_EQ(cell.arm("south").go_to("home").wait(100ms).kind, OutcomeKind::kUnanswered);
  EXPECT_THROW(static_cast<void>(cell.arm("south").state(100ms)), Unreachable);
  EXPECT_THROW(static_cast<void>(cell.world().remove("box", kPatience)), Rejected);
  const double nan = std::nan("");
  EXPECT_THROW(static_cast<void>(cell.arm("north").go_to({0.0, nan, 0.0, 0.0, 0.0, 0.0})), InvalidArgument);
  // No node accepts such messages, so that they are refused here.
  EXPECT_THROW(static_cast<void>(cell.arm("north").go_to({0.0, 1e9, 0.0, 0.0, 0.0, 0.0})), InvalidArgument);
  EXPECT_THROW(static_cast<void>(cell.arm("north").go_to(std::string(300, 'x'))), InvalidArgument);
  EXPECT_THROW(static_cast<void>(cell.world().remove(std::string(300, 'x'), kPatience)), InvalidArgument);
}

TEST_F(ClientTest, RefusesAnUnknownArmAsSoonAsTheNamesAreKnown) {
  const auto expect_refusal = [](const Cell& cell) {
    try {
      static_cast<void>(cell.arm("nort"));
      ADD_FAILURE();
    } catch (const InvalidArgument& error) {
      EXPECT_STREQ(error.what(), "'nort' is no arm of the cell; its arms are north, west, east");
    }
  };
  ConnectOptions options;
  options.domain = domain_.number();
  options.cell_file = cell_file();
  const Cell with_file = Cell::connect(options, kPatience);
  expect_refusal(with_file);
  EXPECT_EQ(with_file.arm("north").name(), "north");

  const Cell without_file = connect();
  EXPECT_TRUE(without_file.arms().empty());
  EXPECT_EQ(without_file.arm("nort").name(), "nort") << "only the supervisor has the names";
  static_cast<void>(without_file.status(kPatience));
  EXPECT_EQ(without_file.arms(), (std::vector<std::string>{"north", "west", "east"}));
  expect_refusal(without_file);
}

TEST_F(ClientTest, ReplacesEarlierGoalsAndCancels) {
  const Cell cell = connect();
  const Arm arm = cell.arm("east");
  arm.hold(kPatience);
  const Goal first = arm.go_to("ready");
  EXPECT_NE(first.wait(500ms).kind, OutcomeKind::kReached) << "the arm is held";
  const Goal second = arm.go_to("home");
  EXPECT_EQ(first.wait(kPatience).kind, OutcomeKind::kReplaced);
  second.cancel();
  EXPECT_EQ(second.wait(kPatience).kind, OutcomeKind::kCancelled);
  arm.resume(kPatience);
}

TEST_F(ClientTest, SetsTheSpeedOfTheCellAndOfArms) {
  const Cell cell = connect();
  cell.set_speed(0.5, kPatience);
  cell.arm("north").set_speed(0.3, kPatience);
  const CellStatus status = cell.status(kPatience);
  EXPECT_EQ(status.speed, 0.5);
  for (const ArmStatus& arm : status.arms) EXPECT_EQ(arm.speed, arm.name == "north" ? 0.3 : 0.5) << arm.name;
  EXPECT_TRUE(cell.arm("north").go_to("ready").wait(kPatience));
  for (const double bad : {0.0, 0.0099, 1.01, 30.0, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_THROW(cell.set_speed(bad, kPatience), InvalidArgument) << bad;
  }
  cell.set_speed(1.0, {"north"}, kPatience);
  cell.set_speed(1.0, kPatience);
  EXPECT_EQ(cell.status(kPatience).arms.front().speed, 1.0);
}

TEST_F(ClientTest, EndsAWaitWhenInterrupted) {
  const Cell cell = connect();
  const Arm unknown = cell.arm("unknown");  // before an order brings the names
  cell.hold(kPatience);
  const Goal goal = cell.arm("north").go_to("ready");
  std::stop_source stop;
  std::promise<void> waits;
  std::thread interrupter([&] {
    waits.get_future().wait();
    stop.request_stop();
  });
  waits.set_value();
  EXPECT_EQ(goal.wait({kForever, stop.get_token()}).kind, OutcomeKind::kInterrupted);
  interrupter.join();
  EXPECT_THROW(static_cast<void>(unknown.state({kForever, stop.get_token()})), Interrupted);
  goal.cancel();
  cell.resume(kPatience);
}

TEST_F(ClientTest, KeepsAGoalAfterItsClientEnded) {
  connect().arm("west").go_to("ready");
  const Cell cell = connect();
  std::optional<Progress> newest;
  EXPECT_TRUE(cell.wait_until(
      [&] {
        newest = cell.arm("west").goal();
        return newest && newest->state == GoalState::kReached;
      },
      kPatience));
}

// Each connection is a new participant of the same process, which the services must hear at once.
TEST_F(ClientTest, ConnectsManyTimesInOneProcess) {
  for (int i = 0; i < 12; ++i) {
    const Cell cell = connect();
    EXPECT_EQ(cell.status(kPatience).mode, CellMode::kRun) << i;
    const std::string name = "connection_" + std::to_string(i);
    cell.world().add(name, Sphere{0.05}, Pose{.position = {4.0, 4.0, 4.0}}, Static{}, kPatience);
    cell.world().remove(name, kPatience);
    EXPECT_EQ(cell.arm("north").state(kPatience).q.size(), 6U) << i;
  }
}

TEST_F(ClientTest, ReportsOrdersInTheStatus) {
  const Cell cell = connect();
  cell.stop(kPatience);
  EXPECT_EQ(cell.status(kPatience).mode, CellMode::kStop);
  cell.resume(kPatience);
  cell.hold({"north"}, kPatience);
  const CellStatus status = cell.status(kPatience);
  EXPECT_EQ(status.mode, CellMode::kRun);
  EXPECT_EQ(status.held_arms, std::vector<std::string>{"north"});
  ASSERT_EQ(status.arms.size(), 3U);
  EXPECT_EQ(status.arms[0].mode, CellMode::kHold);
  cell.resume({"north"}, kPatience);
}

TEST_F(ClientTest, CallsBackWhenAFaultBegins) {
  std::promise<Fault> received;
  std::atomic<bool> done = false;
  const Cell cell = connect();
  cell.on_fault([&](const Fault& fault) {
    if (fault.cause.subject == "planner/north" && !done.exchange(true)) received.set_value(fault);
  });
  ASSERT_TRUE(signal_process(processes().at("planner/north"), SIGKILL));
  const Fault fault = received.get_future().get();
  EXPECT_FALSE(fault.cause.text.empty());
  EXPECT_FALSE(fault.id.empty());
  cell.on_fault({});
}

TEST_F(ClientTest, RejectsAWaitInACallback) {
  std::promise<bool> threw;
  std::atomic<bool> done = false;
  const Cell cell = connect();
  const Goal goal = cell.arm("north").go_to("home", {60s});
  goal.on_progress([&](const Progress&) {
    if (done.exchange(true)) return;
    try {
      goal.wait(1s);
      threw.set_value(false);
    } catch (const std::logic_error&) {
      threw.set_value(true);
    }
  });
  EXPECT_TRUE(threw.get_future().get());
  goal.on_progress({});
}

/// The agent does not restart processes.
class WithoutSupervisor : public ClientTest {
 protected:
  void SetUp() override {
    up_ = std::make_unique<Process>(std::vector<std::string>{std::string(HECATON_BIN_DIR) + "/hecaton", "agent",
                                                             cell_file(), "--no-restart", "--domain", domain()});
    const Cell cell = connect();
    ASSERT_TRUE(cell.wait_until([&] { return cell.status(kPatience).mode == CellMode::kRun; }, kPatience));
    const pid_t supervisor = processes().at("supervisor");
    const Watched end(supervisor);
    ASSERT_TRUE(signal_process(supervisor, SIGKILL));
    ASSERT_TRUE(end.wait_for_end());
  }
  void TearDown() override { up_.reset(); }
};

TEST_F(WithoutSupervisor, EditsObstaclesByTheWorldService) {
  const Cell cell = connect();
  EXPECT_THROW(static_cast<void>(cell.status(200ms)), Unreachable);
  const World world = cell.world();
  const Receipt added = world.add("crate", Box{0.1, 0.1, 0.1}, Pose::xyz(0.0, 0.0, 2.5), Static{}, kPatience);
  const Receipt moved = world.move("crate", Pose::xyz(0.1, 0.0, 2.5), kPatience);
  EXPECT_GE(moved.edition, added.edition);
  EXPECT_THROW(static_cast<void>(world.remove("nothing", kPatience)), Rejected);
  const auto is_moved = [&] {
    const auto obstacles = world.obstacles(kPatience);
    return std::any_of(obstacles.begin(), obstacles.end(), [](const ObstacleState& obstacle) {
      return obstacle.name == "crate" && std::abs(obstacle.pose.position.x - 0.1) < 1e-9;
    });
  };
  const auto limit = std::chrono::steady_clock::now() + kPatience;
  while (!is_moved()) ASSERT_LT(std::chrono::steady_clock::now(), limit);
  world.remove("crate", kPatience);

  const Ran ran = run({"obstacle", "add", "lid", "--sphere", "0.1", "--pose", "0 0 3 0 0 0"});
  EXPECT_EQ(ran.code, 0) << ran.err;
  EXPECT_EQ(run({"obstacle", "move", "lid", "--pose", "0 0 2.8 0 0 0"}).code, 0);
  EXPECT_EQ(run({"obstacle", "remove", "nothing"}).code, 3) << "a name that does not exist is bad input";
  EXPECT_EQ(run({"obstacle", "remove", "lid"}).code, 0);
}

}  // namespace
}  // namespace hecaton::test
