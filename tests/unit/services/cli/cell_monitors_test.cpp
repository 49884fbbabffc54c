#include "services/cli/cell_monitors.hpp"

#include <chrono>
#include <vector>

#include <gtest/gtest.h>
#include <unistd.h>

namespace hecaton::services::cli {
namespace {

msg::ContactReport report_at(double time, std::uint64_t contacts, double smallest) {
  msg::ContactReport report;
  report.time(time);
  report.contacts(contacts);
  report.has_smallest(true);
  report.smallest().distance(smallest);
  report.smallest().a("a/x");
  report.smallest().b("b/y");
  return report;
}

TEST(ContactTotals, KeepContactsOfAnEarlierWorld) {
  ContactTotals totals;
  totals.update(report_at(1.0, 1, 0.02));
  totals.update(report_at(2.0, 2, 0.01));
  EXPECT_EQ(totals.contacts(), 2U);
  totals.update(report_at(1.95, 2, 0.01));  // a restarted world resumes from its checkpoint
  EXPECT_EQ(totals.contacts(), 2U);
  totals.update(report_at(0.5, 0, 0.3));  // a restarted world counts from 0
  EXPECT_EQ(totals.contacts(), 2U);
  totals.update(report_at(0.7, 3, 0.3));
  EXPECT_EQ(totals.contacts(), 5U);
  ASSERT_TRUE(totals.smallest());
  EXPECT_EQ(totals.smallest()->distance, 0.01);
}

TEST(ContactTotals, HaveNoSeparationBeforeAPairIsChecked) {
  ContactTotals totals;
  totals.update(msg::ContactReport());
  EXPECT_FALSE(totals.smallest());
}

msg::CellStatus heartbeat(const std::string& node, std::uint64_t ticks, double p50, double p99, double max) {
  msg::CellStatus status;
  msg::NodeStatus entry;
  entry.heartbeat().node(node);
  entry.heartbeat().kind(msg::NodeKind::NODE_PLANNER);
  entry.heartbeat().ticks(ticks);
  entry.heartbeat().tick_p50_us(p50);
  entry.heartbeat().tick_p99_us(p99);
  entry.heartbeat().tick_max_us(max);
  status.nodes().push_back(entry);
  return status;
}

TEST(TickStatistics, UseWindowsThatDoNotOverlap) {
  TickStatistics statistics;
  EXPECT_FALSE(statistics.typical());
  statistics.update(heartbeat("p", 100, 900, 900, 5));  // not a whole window yet
  EXPECT_FALSE(statistics.typical());
  statistics.update(heartbeat("p", 600, 10, 30, 50));
  statistics.update(heartbeat("p", 700, 1, 1, 70));  // overlaps; only its longest tick counts
  statistics.update(heartbeat("p", 1200, 20, 40, 60));
  statistics.update(heartbeat("p", 1800, 30, 90, 60));
  const auto typical = statistics.typical();
  ASSERT_TRUE(typical);
  EXPECT_EQ(typical->p50, 20.0);
  EXPECT_EQ(typical->p99, 40.0);
  EXPECT_EQ(typical->max, 70.0);
  EXPECT_EQ(statistics.worst()->p99, 90.0);
}

TEST(TickStatistics, UsePlannersOnly) {
  msg::CellStatus status = heartbeat("driver/a", 5000, 1, 1, 1);
  status.nodes().front().heartbeat().kind(msg::NodeKind::NODE_DRIVER);
  TickStatistics statistics;
  statistics.update(status);
  EXPECT_FALSE(statistics.typical());
}

TEST(ProcessUsage, GrowsWhileThisProcessWorks) {
  const auto before = process_usage(getpid());
  ASSERT_TRUE(before);
  EXPECT_GT(before->rss_bytes, 100'000U);
  EXPECT_GE(before->peak_rss_bytes, before->rss_bytes / 2);
  volatile double sum = 0.0;
  auto after = before;
  // Until the kernel has counted two of its clock ticks (10 ms each).
  while (after && after->cpu_time < before->cpu_time + 0.02) {
    for (int i = 0; i < 100'000; ++i) sum = sum + 1.0;
    after = process_usage(getpid());
  }
  ASSERT_TRUE(after);
  EXPECT_GE(after->cpu_time, before->cpu_time + 0.02);
}

TEST(ProcessUsage, IsEmptyForAnUnknownProcess) {
  EXPECT_FALSE(process_usage(0x7fffffff));
}

TEST(UsageMonitor, ReportsEveryRunningProcess) {
  msg::CellStatus status = heartbeat("planner/a", 1, 1, 1, 1);
  status.nodes().front().heartbeat().pid(getpid());
  UsageMonitor monitor;
  monitor.begin(status);
  const Json processes = monitor.end(status);
  ASSERT_EQ(processes.size(), 1U);
  EXPECT_EQ(processes[0]["node"], "planner/a");
  EXPECT_EQ(processes[0]["pid"], getpid());
  EXPECT_TRUE(processes[0]["cpu_percent"].is_number());
  EXPECT_NE(usage_text(processes, Palette(false)).find("planner/a"), std::string::npos);
}

using namespace std::chrono_literals;

constexpr bus::Clock::time_point kBegin{1h};
constexpr int kPid = 123;

msg::ProcessEvent exited(const std::string& node, int pid = kPid, bool wanted = false) {
  msg::ProcessEvent event;
  event.node(node);
  event.pid(pid);
  event.kind(msg::ProcessEventKind::PROCESS_EXITED);
  event.signal_number(9);
  event.wanted(wanted);
  return event;
}

/// `pid`: 0 before the supervisor has received its own heartbeat.
msg::CellStatus up_for(double uptime, int pid = kPid, const std::string& node = "supervisor",
                       const std::string& standby = {}) {
  msg::CellStatus status;
  status.supervisor(node);
  status.standby(standby);
  status.uptime(uptime);
  if (pid == 0) return status;
  msg::NodeStatus own;
  own.heartbeat().node(node);
  own.heartbeat().pid(pid);
  status.nodes().push_back(own);
  return status;
}

class SupervisorTrackerTest : public testing::Test {
 protected:
  std::string answer(const msg::CellStatus& status, bus::Clock::duration at) {
    return tracker_.on_status(&status, kBegin + at);
  }
  std::string silence(bus::Clock::duration at) { return tracker_.on_status(nullptr, kBegin + at); }
  std::string event(const msg::ProcessEvent& event, bus::Clock::duration at = 0s) {
    return tracker_.on_process_event(event, kBegin + at);
  }

  SupervisorTracker tracker_;
};

TEST_F(SupervisorTrackerTest, ReportsDeathAndRestartOnce) {
  EXPECT_EQ(answer(up_for(20.0), 0s), "");
  EXPECT_EQ(event(exited("supervisor")),
            "the supervisor died (process 123, signal 9): arms continue, faults and orders wait for its restart");
  EXPECT_EQ(answer(up_for(20.0), 10ms), "") << "last answer of the dead process";
  EXPECT_EQ(silence(500ms), "") << "known already";
  EXPECT_EQ(answer(up_for(0.2, 124), 600ms), "the supervisor was restarted");
  EXPECT_EQ(answer(up_for(0.3, 124), 700ms), "");
  EXPECT_EQ(silence(1200ms), "the supervisor does not answer: arms continue, faults and orders wait for it");
}

TEST_F(SupervisorTrackerTest, RecognisesARestartByPidOrUptime) {
  EXPECT_EQ(answer(up_for(20.0), 0s), "");
  EXPECT_NE(event(exited("supervisor"), 1s), "") << "reported after the restart";
  EXPECT_EQ(answer(up_for(0.9, 124), 1100ms), "the supervisor was restarted");
  EXPECT_NE(event(exited("supervisor", 124), 2s), "");
  EXPECT_EQ(answer(up_for(0.1, 0), 2500ms), "the supervisor was restarted");
  EXPECT_EQ(answer(up_for(0.2, 125), 2600ms), "") << "reported already";
  EXPECT_NE(event(exited("supervisor", 125), 3s), "");
  EXPECT_EQ(answer(up_for(0.1, 125), 3500ms), "the supervisor was restarted") << "the same pid again";
}

TEST_F(SupervisorTrackerTest, IgnoresADeathReportedAfterTheRestart) {
  EXPECT_EQ(answer(up_for(20.0), 0s), "");
  EXPECT_EQ(answer(up_for(0.1, 124), 300ms), "the supervisor was restarted");
  EXPECT_EQ(event(exited("supervisor"), 400ms), "");
  EXPECT_EQ(answer(up_for(0.3, 124), 500ms), "");
}

TEST_F(SupervisorTrackerTest, ReportsTakeoverAndSilenceOfTheStandby) {
  EXPECT_EQ(answer(up_for(20.0, kPid, "supervisor", "supervisor@beta"), 0s), "");
  EXPECT_EQ(event(exited("supervisor")),
            "the supervisor died (process 123, signal 9): arms continue, supervisor@beta takes over");
  EXPECT_EQ(answer(up_for(20.0, kPid, "supervisor", "supervisor@beta"), 5ms), "") << "last answer of the dead process";
  // Its uptime equals that of the dead process.
  EXPECT_EQ(answer(up_for(20.0, 200, "supervisor@beta"), 20ms), "supervisor@beta leads, in place of the supervisor");
  EXPECT_EQ(answer(up_for(21.0, 200, "supervisor@beta", "supervisor"), 1s), "") << "the other supervisor stands by";
  EXPECT_EQ(silence(2s),
            "supervisor@beta does not answer: arms continue, faults and orders wait for it or the supervisor");
  EXPECT_EQ(answer(up_for(23.0, 200, "supervisor@beta", "supervisor"), 3s), "supervisor@beta answers again");
  EXPECT_EQ(event(exited("supervisor@beta", 200), 4s),
            "supervisor@beta died (process 200, signal 9): arms continue, the supervisor takes over");
  EXPECT_EQ(answer(up_for(4.0, 124, "supervisor"), 4100ms), "the supervisor leads, in place of supervisor@beta");
}

TEST_F(SupervisorTrackerTest, IgnoresTheDeathOfTheStandby) {
  EXPECT_EQ(answer(up_for(20.0, kPid, "supervisor@beta", "supervisor"), 0s), "");
  EXPECT_EQ(event(exited("supervisor", 200)), "");
  EXPECT_EQ(event(exited("supervisor@beta")),
            "supervisor@beta died (process 123, signal 9): arms continue, faults and orders wait for its restart")
      << "no supervisor stands by";
}

TEST_F(SupervisorTrackerTest, ReportsNoTakeoverWhenBothDie) {
  EXPECT_EQ(answer(up_for(20.0, kPid, "supervisor", "supervisor@beta"), 0s), "");
  EXPECT_NE(event(exited("supervisor")), "");
  EXPECT_EQ(event(exited("supervisor@beta", 200)),
            "supervisor@beta died (process 200, signal 9): arms continue, faults and orders wait for its restart");
  EXPECT_EQ(silence(500ms), "") << "known already";
  EXPECT_EQ(answer(up_for(0.1, 124), 600ms), "the supervisor was restarted");
}

TEST_F(SupervisorTrackerTest, ReportsTakeoverFromASilentLeader) {
  EXPECT_EQ(answer(up_for(20.0, kPid, "supervisor", "supervisor@beta"), 0s), "");
  EXPECT_EQ(silence(500ms),
            "the supervisor does not answer: arms continue, faults and orders wait for it or supervisor@beta");
  EXPECT_EQ(answer(up_for(20.4, 200, "supervisor@beta"), 600ms), "supervisor@beta leads, in place of the supervisor");
  EXPECT_EQ(answer(up_for(20.5, 200, "supervisor@beta"), 700ms), "");
}

TEST_F(SupervisorTrackerTest, ReportsSilenceOnce) {
  EXPECT_EQ(silence(0s), "the supervisor does not answer: arms continue, faults and orders wait for it");
  EXPECT_EQ(silence(500ms), "");
  EXPECT_EQ(answer(up_for(20.0), 1s), "the supervisor answers again");
  EXPECT_EQ(answer(up_for(21.0), 2s), "");
}

TEST_F(SupervisorTrackerTest, IgnoresOtherProcessesWantedExitsAndPastEvents) {
  EXPECT_EQ(event(exited("supervisor")), "") << "before the first answer";
  EXPECT_EQ(answer(up_for(20.0), 0s), "");
  EXPECT_EQ(event(exited("world")), "");
  EXPECT_EQ(event(exited("supervisor", kPid, true)), "");
  EXPECT_EQ(event(exited("supervisor", 122)), "") << "an earlier process";
  EXPECT_NE(silence(500ms), "");
}

}  // namespace
}  // namespace hecaton::services::cli
