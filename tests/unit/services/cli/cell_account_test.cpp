#include "services/cli/cell_account.hpp"

#include <chrono>
#include <vector>

#include <gtest/gtest.h>
#include <unistd.h>

namespace hecaton::services::cli {
namespace {

msg::RefereeReport report_at(double time, std::uint64_t contacts, double smallest) {
  msg::RefereeReport report;
  report.time(time);
  report.contacts(contacts);
  report.judged(true);
  report.smallest().distance(smallest);
  report.smallest().a("a/x");
  report.smallest().b("b/y");
  return report;
}

TEST(RefereeAccount, KeepsWhatAnEarlierWorldSaw) {
  RefereeAccount account;
  account.update(report_at(1.0, 1, 0.02));
  account.update(report_at(2.0, 2, 0.01));
  EXPECT_EQ(account.contacts(), 2U);
  account.update(report_at(1.95, 2, 0.01));  // another world goes on with the account
  EXPECT_EQ(account.contacts(), 2U);
  account.update(report_at(0.5, 0, 0.3));  // a new world began to count
  EXPECT_EQ(account.contacts(), 2U);
  account.update(report_at(0.7, 3, 0.3));
  EXPECT_EQ(account.contacts(), 5U);
  ASSERT_TRUE(account.smallest());
  EXPECT_EQ(account.smallest()->distance, 0.01);
}

TEST(RefereeAccount, HasNoSeparationBeforeAnythingWasJudged) {
  RefereeAccount account;
  account.update(msg::RefereeReport());
  EXPECT_FALSE(account.smallest());
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

TEST(TickAccount, TakesWindowsThatDoNotOverlap) {
  TickAccount account;
  EXPECT_FALSE(account.typical());
  account.update(heartbeat("p", 100, 900, 900, 5));  // not a whole window yet
  EXPECT_FALSE(account.typical());
  account.update(heartbeat("p", 600, 10, 30, 50));
  account.update(heartbeat("p", 700, 1, 1, 70));  // overlaps; only its longest tick counts
  account.update(heartbeat("p", 1200, 20, 40, 60));
  account.update(heartbeat("p", 1800, 30, 90, 60));
  const auto typical = account.typical();
  ASSERT_TRUE(typical);
  EXPECT_EQ(typical->p50, 20.0);
  EXPECT_EQ(typical->p99, 40.0);
  EXPECT_EQ(typical->max, 70.0);
  EXPECT_EQ(account.worst()->p99, 90.0);
}

TEST(TickAccount, CountsPlannersOnly) {
  msg::CellStatus status = heartbeat("driver/a", 5000, 1, 1, 1);
  status.nodes().front().heartbeat().kind(msg::NodeKind::NODE_DRIVER);
  TickAccount account;
  account.update(status);
  EXPECT_FALSE(account.typical());
}

TEST(ProcessUsage, SeesThisProcessWork) {
  const auto before = process_usage(getpid());
  ASSERT_TRUE(before);
  EXPECT_GT(before->rss_bytes, 100'000U);
  EXPECT_GE(before->peak_rss_bytes, before->rss_bytes / 2);
  volatile double sum = 0.0;
  auto after = before;
  // Until the kernel has booked at least two of its clock ticks (10 ms each) for us.
  while (after && after->cpu_time < before->cpu_time + 0.02) {
    for (int i = 0; i < 100'000; ++i) sum = sum + 1.0;
    after = process_usage(getpid());
  }
  ASSERT_TRUE(after);
  EXPECT_GE(after->cpu_time, before->cpu_time + 0.02);
}

TEST(ProcessUsage, KnowsNoProcessThatIsNot) {
  EXPECT_FALSE(process_usage(0x7fffffff));
}

TEST(UsageAccount, TellsOfEveryProcessThatIsThere) {
  msg::CellStatus status = heartbeat("planner/a", 1, 1, 1, 1);
  status.nodes().front().heartbeat().pid(getpid());
  UsageAccount account;
  account.begin(status);
  const Json processes = account.end(status);
  ASSERT_EQ(processes.size(), 1U);
  EXPECT_EQ(processes[0]["node"], "planner/a");
  EXPECT_EQ(processes[0]["pid"], getpid());
  EXPECT_TRUE(processes[0]["cpu_percent"].is_number());
  EXPECT_NE(usage_text(processes, Palette(false)).find("planner/a"), std::string::npos);
}

}  // namespace
}  // namespace hecaton::services::cli
