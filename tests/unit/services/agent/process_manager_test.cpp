// The process manager with real processes: its services are the programs sleep, true, false and sh.

#include "services/agent/process_manager.hpp"

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "tests/support/temporary_folder.hpp"

namespace hecaton::services {
namespace {

using namespace std::chrono_literals;
using Kind = ProcessEvent::Kind;

constexpr auto kPatience = 60s;
constexpr auto kTurn = 5ms;  // an agent turns at least this often

PlannedService service(const std::string& name, const std::string& program, const std::vector<std::string>& arguments) {
  return {name, name, "here", program, arguments};
}

TEST(RestartPolicy, DoublesTheDelayFrom100MillisecondsTo5Seconds) {
  RestartPolicy policy({});
  for (const auto expected : {100ms, 200ms, 400ms, 800ms, 1600ms, 3200ms, 5000ms, 5000ms, 5000ms, 5000ms}) {
    EXPECT_EQ(policy.delay_after(50ms), expected);
  }
  EXPECT_EQ(policy.delay_after(50ms), std::nullopt);
}

TEST(RestartPolicy, BeginsWithTheFirstDelayAfterALongUptime) {
  RestartPolicy policy({});
  for (int i = 0; i < 9; ++i) static_cast<void>(policy.delay_after(50ms));
  EXPECT_EQ(policy.delay_after(10s), 100ms);
  EXPECT_EQ(policy.delay_after(50ms), 200ms);
}

TEST(RestartPolicy, ReturnsNoDelayWithoutAttempts) {
  RestartLimits limits;
  limits.attempts = 0;
  RestartPolicy policy(limits);
  EXPECT_EQ(policy.delay_after(1h), std::nullopt);
}

class ProcessManagerTest : public ::testing::Test {
 protected:
  static ProcessManagerOptions options(int attempts) {
    ProcessManagerOptions manager{"/bin", {}, {}};
    manager.restart.first = 1ms;
    manager.restart.longest = 4ms;
    manager.restart.attempts = attempts;
    manager.restart.retry = 0ms;
    return manager;
  }
  /// Turns until `count` events of `kind` have happened.
  void turn_until(ProcessManager& manager, Kind kind, long count) {
    turn_until(manager, [&] {
      return std::count_if(events_.begin(), events_.end(), [&](const ProcessEvent& i) { return i.kind == kind; }) >=
             count;
    });
  }
  template <typename Condition>
  void turn_until(ProcessManager& manager, const Condition& condition) {
    const auto until = ProcessManager::Clock::now() + kPatience;
    while (!condition()) {
      ASSERT_LT(ProcessManager::Clock::now(), until);
      const auto news = manager.turn(ProcessManager::Clock::now());
      events_.insert(events_.end(), news.begin(), news.end());
      if (!news.empty()) continue;
      std::vector<pollfd> descriptors;
      manager.append_descriptors(descriptors);
      const auto next = manager.next_start().value_or(until);
      const auto wait = std::min(next, ProcessManager::Clock::now() + kTurn) - ProcessManager::Clock::now();
      const auto left =
          std::chrono::ceil<std::chrono::milliseconds>(std::max(wait, ProcessManager::Clock::duration::zero()));
      poll(descriptors.data(), descriptors.size(), static_cast<int>(left.count()));
    }
  }
  std::vector<Kind> kinds() {
    std::vector<Kind> all;
    for (const ProcessEvent& event : events_) all.push_back(event.kind);
    return all;
  }
  std::vector<ProcessEvent> events_;
};

TEST_F(ProcessManagerTest, StartsAndEndsAllServices) {
  ProcessManager manager({service("a", "sleep", {"600"}), service("b", "sleep", {"600"})}, options(3));
  turn_until(manager, Kind::kStarted, 2);
  EXPECT_FALSE(manager.all_ended());
  manager.terminate_all();
  turn_until(manager, Kind::kExited, 2);
  EXPECT_TRUE(manager.all_ended());
  EXPECT_FALSE(manager.next_start());
  for (const ProcessEvent& event : events_) {
    if (event.kind != Kind::kExited) continue;
    EXPECT_TRUE(event.wanted);
    EXPECT_EQ(event.end.signal_number, SIGTERM);
    EXPECT_GT(event.pid, 0);
  }
}

// A shell that sends one heartbeat and then stops itself, like a loop that hangs.
TEST_F(ProcessManagerTest, KillsAndRestartsAHangingProcess) {
  ProcessManagerOptions watching = options(3);
  watching.watchdog = 100ms;
  ProcessManager manager({service("a", "sh", {"-c", "echo >&3; kill -STOP $$"})}, watching);
  turn_until(manager, Kind::kStarted, 2);
  EXPECT_EQ(kinds(), (std::vector<Kind>{Kind::kStarted, Kind::kKilled, Kind::kExited, Kind::kStarted}));
  EXPECT_TRUE(events_[1].reason.starts_with("its loop was silent for ")) << events_[1].reason;
  EXPECT_EQ(events_[2].end.signal_number, SIGKILL);
  EXPECT_EQ(events_[2].killed, KillReason::kHung);
  EXPECT_EQ(events_[2].reason, events_[1].reason) << "the exit has the same reason";
}

// tail keeps all that it reads of a pipe without lines, and waits for its end.
TEST_F(ProcessManagerTest, KillsAndRestartsAProcessThatUsesTooMuchMemory) {
  const test::TemporaryFolder folder;
  const std::string pipe = folder.path("pipe");
  const std::string keep = "mkfifo " + pipe +
                           " 2>/dev/null; (head -c 100000000 /dev/zero; exec tail -f /dev/null --pid=$$) > " + pipe +
                           " & exec tail -n 1 " + pipe;
  ProcessManagerOptions weighing = options(3);
  weighing.memory_limit = 50'000'000;
  ProcessManager manager({service("a", "sh", {"-c", keep}), service("b", "sleep", {"600"})}, weighing);
  const auto of_a = [&](Kind kind) {
    return std::find_if(events_.begin(), events_.end(),
                        [&](const auto& one) { return one.service->name == "a" && one.kind == kind; });
  };
  turn_until(manager, Kind::kStarted, 3);
  ASSERT_NE(of_a(Kind::kKilled), events_.end());
  const std::string& reason = of_a(Kind::kKilled)->reason;
  EXPECT_NE(reason.find("more than supervision.memory_limit = 50 MB"), std::string::npos) << reason;
  const auto exit = of_a(Kind::kExited);
  ASSERT_NE(exit, events_.end());
  EXPECT_EQ(exit->end.signal_number, SIGKILL);
  EXPECT_EQ(exit->reason, reason);
  EXPECT_EQ(exit->killed, KillReason::kTooLarge);
  EXPECT_TRUE(std::none_of(events_.begin(), events_.end(), [](const auto& one) {
    return one.service->name == "b" && one.kind != Kind::kStarted;
  })) << "it dies alone";
}

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
TEST_F(ProcessManagerTest, BoundsWhatAProcessAllocatesBetweenTwoLooks) {
  const test::TemporaryFolder folder;
  ProcessManagerOptions weighing = options(1);
  weighing.logs = folder.path();
  weighing.memory_limit = 300'000'000;
  ProcessManager manager({service("a", "sh", {"-c", "ulimit -d"})}, weighing);
  turn_until(manager, Kind::kExited, 1);
  std::ifstream log(folder.path() / "a.log");
  std::uint64_t kilobytes = 0;
  log >> kilobytes;
  EXPECT_EQ(kilobytes, 1'300'000'000U / 1024);
}
#endif

// A start may take longer than the watchdog, for example because of large meshes.
TEST_F(ProcessManagerTest, AppliesTheStartLimitBeforeTheFirstHeartbeat) {
  ProcessManagerOptions watching = options(3);
  watching.watchdog = 10ms;
  watching.start_limit = kPatience;
  ProcessManager manager({service("a", "sh", {"-c", "sleep 0.3; exit 5"})}, watching);
  turn_until(manager, Kind::kExited, 1);
  EXPECT_EQ(kinds(), (std::vector<Kind>{Kind::kStarted, Kind::kExited}));
  EXPECT_EQ(events_[1].end.exit_code, 5);
}

// The time of a hanging start is no uptime.
TEST_F(ProcessManagerTest, GivesUpAProcessWhoseLoopNeverBegins) {
  ProcessManagerOptions watching = options(1);
  watching.watchdog = 1s;
  watching.start_limit = 200ms;
  watching.restart.steady = 1ms;
  ProcessManager manager({service("a", "sh", {"-c", "exec sleep 600"})}, watching);
  turn_until(manager, Kind::kGivenUp, 1);
  EXPECT_EQ(kinds(), (std::vector<Kind>{Kind::kStarted, Kind::kKilled, Kind::kExited, Kind::kStarted, Kind::kKilled,
                                        Kind::kExited, Kind::kGivenUp}));
  EXPECT_TRUE(events_[1].reason.starts_with("its loop did not begin within ")) << events_[1].reason;
  EXPECT_EQ(events_[2].end.signal_number, SIGKILL);
}

TEST_F(ProcessManagerTest, RestartsAKilledProcess) {
  ProcessManager manager({service("a", "sleep", {"600"})}, options(3));
  turn_until(manager, Kind::kStarted, 1);
  const pid_t pid = events_[0].pid;
  kill(pid, SIGKILL);
  turn_until(manager, Kind::kStarted, 2);
  EXPECT_EQ(kinds(), (std::vector<Kind>{Kind::kStarted, Kind::kExited, Kind::kStarted}));
  EXPECT_EQ(events_[1].pid, pid);
  EXPECT_EQ(events_[1].end.signal_number, SIGKILL);
  EXPECT_EQ(events_[1].reason, "") << "the manager did not kill it";
  EXPECT_FALSE(events_[1].wanted);
  EXPECT_EQ(events_[1].restarts, 0U);
  EXPECT_EQ(events_[2].restarts, 1U);
  EXPECT_NE(events_[2].pid, pid);
}

TEST_F(ProcessManagerTest, GivesUpAfterAllAttemptsAndReportsIt) {
  ProcessManager manager({service("a", "false", {}), service("b", "sleep", {"600"})}, options(3));
  turn_until(manager, Kind::kGivenUp, 1);
  const auto of_a = [](const ProcessEvent& event) { return event.service->name == "a"; };
  EXPECT_EQ(std::count_if(events_.begin(), events_.end(), of_a), 4 + 4 + 1);  // starts, exits, given up
  EXPECT_EQ(manager.problem(), "a was given up after 3 restarts in a row");
  EXPECT_FALSE(manager.next_start());
  EXPECT_FALSE(manager.all_ended());  // b still runs
}

TEST_F(ProcessManagerTest, RetriesAGivenUpProcessAndCounts) {
  ProcessManagerOptions trying = options(2);
  trying.restart.retry = 1ms;
  ProcessManager manager({service("a", "false", {})}, trying);
  turn_until(manager, Kind::kGivenUp, 1);
  EXPECT_EQ(manager.problem(), "a was given up after 2 restarts in a row, and is tried again every 0 s");
  EXPECT_TRUE(manager.next_start());
  turn_until(manager, Kind::kGivenUp, 3);
  EXPECT_TRUE(manager.problem().ends_with(" (2 times so far)")) << manager.problem();
}

// The missing file exists after two retries.
TEST_F(ProcessManagerTest, ClearsTheProblemAfterALongUptime) {
  const test::TemporaryFolder folder;
  ProcessManagerOptions trying = options(1);
  trying.restart.retry = 1ms;
  trying.restart.steady = 20ms;
  ProcessManager manager({service("a", "sh", {"-c", "test -e " + folder.path("part") + " && exec sleep 600"})}, trying);
  turn_until(manager, Kind::kGivenUp, 2);
  folder.write("part", "here");
  turn_until(manager, [&] { return manager.problem().empty(); });
  EXPECT_FALSE(manager.all_ended());
}

TEST_F(ProcessManagerTest, ReportsAnExitAsFinalWithoutRestarts) {
  ProcessManager manager({service("a", "true", {})}, options(0));
  turn_until(manager, Kind::kGivenUp, 1);
  EXPECT_EQ(kinds(), (std::vector<Kind>{Kind::kStarted, Kind::kExited, Kind::kGivenUp}));
  EXPECT_EQ(events_[1].end.exit_code, 0);
  EXPECT_EQ(manager.problem(), "a ended and is not restarted");
}

TEST_F(ProcessManagerTest, GivesUpAProgramThatCannotBeStarted) {
  ProcessManager manager({service("a", "no-such-program", {})}, options(2));
  turn_until(manager, Kind::kGivenUp, 1);
  EXPECT_EQ(kinds(), (std::vector<Kind>{Kind::kNotStarted, Kind::kNotStarted, Kind::kNotStarted, Kind::kGivenUp}));
  EXPECT_EQ(events_[0].reason, "/bin/no-such-program cannot be started: No such file or directory");
  EXPECT_EQ(
      manager.problem(),
      "a was given up after 2 restarts in a row: /bin/no-such-program cannot be started: No such file or directory");
}

TEST_F(ProcessManagerTest, KillsAProcessThatIgnoresTermination) {
  ProcessManager manager({service("a", "sh", {"-c", "trap '' TERM; exec sleep 600"})}, options(3));
  turn_until(manager, Kind::kStarted, 1);
  manager.terminate_all();
  manager.kill_all();
  turn_until(manager, Kind::kExited, 1);
  EXPECT_TRUE(events_.back().wanted);
  EXPECT_TRUE(manager.all_ended());
}

}  // namespace
}  // namespace hecaton::services
