// The keeper with real processes: "services" are the machine's sleep, true and false.

#include "services/agent/keeper.hpp"

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

namespace hecaton::services {
namespace {

using namespace std::chrono_literals;
using Kind = Incident::Kind;

constexpr auto kPatience = 60s;
constexpr auto kTurn = 5ms;  // an agent turns this often, whatever happens

PlannedService service(const std::string& name, const std::string& program, const std::vector<std::string>& arguments) {
  return {name, name, "here", program, arguments};
}

class KeeperTest : public ::testing::Test {
 protected:
  static KeeperOptions options(int attempts) {
    KeeperOptions keeper{"/bin", {}, {}};
    keeper.restart.first = 1ms;
    keeper.restart.longest = 4ms;
    keeper.restart.attempts = attempts;
    keeper.restart.retry = 0ms;
    return keeper;
  }
  /// Turns until `count` incidents of `kind` have happened.
  void turn_until(Keeper& keeper, Kind kind, long count) {
    turn_until(keeper, [&] {
      return std::count_if(incidents_.begin(), incidents_.end(), [&](const Incident& i) { return i.kind == kind; }) >=
             count;
    });
  }
  template <typename Condition>
  void turn_until(Keeper& keeper, const Condition& condition) {
    const auto until = Keeper::Clock::now() + kPatience;
    while (!condition()) {
      ASSERT_LT(Keeper::Clock::now(), until);
      const auto news = keeper.turn(Keeper::Clock::now());
      incidents_.insert(incidents_.end(), news.begin(), news.end());
      if (!news.empty()) continue;
      std::vector<pollfd> descriptors;
      keeper.append_descriptors(descriptors);
      const auto next = keeper.next_start().value_or(until);
      const auto wait = std::min(next, Keeper::Clock::now() + kTurn) - Keeper::Clock::now();
      const auto left = std::chrono::ceil<std::chrono::milliseconds>(std::max(wait, Keeper::Clock::duration::zero()));
      poll(descriptors.data(), descriptors.size(), static_cast<int>(left.count()));
    }
  }
  std::vector<Kind> kinds() {
    std::vector<Kind> all;
    for (const Incident& incident : incidents_) all.push_back(incident.kind);
    return all;
  }
  std::vector<Incident> incidents_;
};

TEST_F(KeeperTest, StartsAllAndEndsAll) {
  Keeper keeper({service("a", "sleep", {"600"}), service("b", "sleep", {"600"})}, options(3));
  turn_until(keeper, Kind::kStarted, 2);
  EXPECT_FALSE(keeper.all_ended());
  keeper.ask_to_end();
  turn_until(keeper, Kind::kExited, 2);
  EXPECT_TRUE(keeper.all_ended());
  EXPECT_FALSE(keeper.next_start());
  for (const Incident& incident : incidents_) {
    if (incident.kind != Kind::kExited) continue;
    EXPECT_TRUE(incident.wanted);
    EXPECT_EQ(incident.end.signal_number, SIGTERM);
    EXPECT_GT(incident.pid, 0);
  }
}

// A shell that tells of itself once and then waits for ever, as a loop that hangs; also while it is stopped.
TEST_F(KeeperTest, KillsAndRestartsWhatHangs) {
  KeeperOptions watching = options(3);
  watching.watchdog = 100ms;
  Keeper keeper({service("a", "sh", {"-c", "echo >&3; kill -STOP $$"})}, watching);
  turn_until(keeper, Kind::kStarted, 2);
  EXPECT_EQ(kinds(), (std::vector<Kind>{Kind::kStarted, Kind::kHung, Kind::kExited, Kind::kStarted}));
  EXPECT_TRUE(incidents_[1].reason.starts_with("its loop was silent for ")) << incidents_[1].reason;
  EXPECT_EQ(incidents_[2].end.signal_number, SIGKILL);
  EXPECT_EQ(incidents_[2].reason, incidents_[1].reason) << "who hears of the end hears why";
}

// Starting may take longer than a loop may be silent: reading large meshes, for example.
TEST_F(KeeperTest, HasMorePatienceWithALoopThatHasNotBegun) {
  KeeperOptions watching = options(3);
  watching.watchdog = 10ms;
  watching.start_limit = kPatience;
  Keeper keeper({service("a", "sh", {"-c", "sleep 0.3; exit 5"})}, watching);
  turn_until(keeper, Kind::kExited, 1);
  EXPECT_EQ(kinds(), (std::vector<Kind>{Kind::kStarted, Kind::kExited}));
  EXPECT_EQ(incidents_[1].end.exit_code, 5);
}

// However long it took to hang: that was no life.
TEST_F(KeeperTest, CountsALoopThatNeverBeginsAsAFailedStart) {
  KeeperOptions watching = options(1);
  watching.watchdog = 1s;
  watching.start_limit = 200ms;
  watching.restart.steady = 1ms;
  Keeper keeper({service("a", "sh", {"-c", "exec sleep 600"})}, watching);
  turn_until(keeper, Kind::kGivenUp, 1);
  EXPECT_EQ(kinds(), (std::vector<Kind>{Kind::kStarted, Kind::kHung, Kind::kExited, Kind::kStarted, Kind::kHung,
                                        Kind::kExited, Kind::kGivenUp}));
  EXPECT_TRUE(incidents_[1].reason.starts_with("its loop did not begin within ")) << incidents_[1].reason;
  EXPECT_EQ(incidents_[2].end.signal_number, SIGKILL);
}

TEST_F(KeeperTest, RestartsWhatWasKilled) {
  Keeper keeper({service("a", "sleep", {"600"})}, options(3));
  turn_until(keeper, Kind::kStarted, 1);
  const pid_t pid = incidents_[0].pid;
  kill(pid, SIGKILL);
  turn_until(keeper, Kind::kStarted, 2);
  EXPECT_EQ(kinds(), (std::vector<Kind>{Kind::kStarted, Kind::kExited, Kind::kStarted}));
  EXPECT_EQ(incidents_[1].pid, pid);
  EXPECT_EQ(incidents_[1].end.signal_number, SIGKILL);
  EXPECT_EQ(incidents_[1].reason, "") << "that was not we";
  EXPECT_FALSE(incidents_[1].wanted);
  EXPECT_EQ(incidents_[1].restarts, 0U);
  EXPECT_EQ(incidents_[2].restarts, 1U);
  EXPECT_NE(incidents_[2].pid, pid);
}

TEST_F(KeeperTest, GivesUpAndSaysSo) {
  Keeper keeper({service("a", "false", {}), service("b", "sleep", {"600"})}, options(3));
  turn_until(keeper, Kind::kGivenUp, 1);
  const auto of_a = [](const Incident& incident) { return incident.service->name == "a"; };
  EXPECT_EQ(std::count_if(incidents_.begin(), incidents_.end(), of_a), 4 + 4 + 1);  // starts, exits, and the end of it
  EXPECT_EQ(keeper.complaint(), "a was given up after 3 restarts in a row");
  EXPECT_FALSE(keeper.next_start());
  EXPECT_FALSE(keeper.all_ended());  // b goes on
}

TEST_F(KeeperTest, TriesAgainWhatWasGivenUpAndCounts) {
  KeeperOptions trying = options(2);
  trying.restart.retry = 1ms;
  Keeper keeper({service("a", "false", {})}, trying);
  turn_until(keeper, Kind::kGivenUp, 1);
  EXPECT_EQ(keeper.complaint(), "a was given up after 2 restarts in a row, and is tried again every 0 s");
  EXPECT_TRUE(keeper.next_start());
  turn_until(keeper, Kind::kGivenUp, 3);
  EXPECT_TRUE(keeper.complaint().ends_with(" (2 times so far)")) << keeper.complaint();
}

// What it lacked is there in the end.
TEST_F(KeeperTest, ForgivesWhatLivesAgain) {
  std::string folder = (std::filesystem::temp_directory_path() / "keeper_test-XXXXXX").string();
  ASSERT_NE(mkdtemp(folder.data()), nullptr);
  KeeperOptions trying = options(1);
  trying.restart.retry = 1ms;
  trying.restart.steady = 20ms;
  Keeper keeper({service("a", "sh", {"-c", "test -e " + folder + "/part && exec sleep 600"})}, trying);
  turn_until(keeper, Kind::kGivenUp, 2);
  std::ofstream(folder + "/part") << "here";
  turn_until(keeper, [&] { return keeper.complaint().empty(); });
  EXPECT_FALSE(keeper.all_ended());
  std::filesystem::remove_all(folder);
}

TEST_F(KeeperTest, WithoutRestartAReturnIsTheEnd) {
  Keeper keeper({service("a", "true", {})}, options(0));
  turn_until(keeper, Kind::kGivenUp, 1);
  EXPECT_EQ(kinds(), (std::vector<Kind>{Kind::kStarted, Kind::kExited, Kind::kGivenUp}));
  EXPECT_EQ(incidents_[1].end.exit_code, 0);
  EXPECT_EQ(keeper.complaint(), "a ended and is not restarted");
}

TEST_F(KeeperTest, ProgramThatCannotBeStartedIsTriedAgainAndGivenUp) {
  Keeper keeper({service("a", "no-such-program", {})}, options(2));
  turn_until(keeper, Kind::kGivenUp, 1);
  EXPECT_EQ(kinds(), (std::vector<Kind>{Kind::kNotStarted, Kind::kNotStarted, Kind::kNotStarted, Kind::kGivenUp}));
  EXPECT_EQ(incidents_[0].reason, "/bin/no-such-program cannot be started: No such file or directory");
  EXPECT_EQ(
      keeper.complaint(),
      "a was given up after 2 restarts in a row: /bin/no-such-program cannot be started: No such file or directory");
}

TEST_F(KeeperTest, KillsWhatIgnoresItsEnd) {
  Keeper keeper({service("a", "sh", {"-c", "trap '' TERM; exec sleep 600"})}, options(3));
  turn_until(keeper, Kind::kStarted, 1);
  keeper.ask_to_end();
  keeper.kill_all();
  turn_until(keeper, Kind::kExited, 1);
  EXPECT_TRUE(incidents_.back().wanted);
  EXPECT_TRUE(keeper.all_ended());
}

}  // namespace
}  // namespace hecaton::services
