#include "services/runtime/log.hpp"

#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <thread>

#include <gtest/gtest.h>
#include <unistd.h>

#include "services/runtime/log_limit.hpp"

namespace hecaton::services {
namespace {

TEST(Log, QuotesValuesThatNeedIt) {
  EXPECT_EQ(log_text("started", {{"arm", "north"}, {"period_ms", 2.5}, {"count", 3}, {"done", true}}),
            "event=started arm=north period_ms=2.5 count=3 done=true");
  EXPECT_EQ(log_text("goal rejected", {{"reason", "a=b \"c\""}, {"empty", ""}}),
            R"(event="goal rejected" reason="a=b \"c\"" empty="")");
  EXPECT_EQ(log_text("x", {{"text", "two\nlines\x1b[31m"}}), R"(event=x text="two\nlines[31m")");
}

TEST(Log, WritesLinesOfTheLevelToTheFileAtTheEndOfTheScope) {
  const auto path = std::filesystem::temp_directory_path() / ("hecaton-log-" + std::to_string(getpid()));
  ServiceOptions options;
  options.log_file = path.string();
  options.log_level = LogLevel::kWarning;
  {
    const LogScope scope("planner/north", options);
    log_info("below the level");
    log_warning("wanted", {{"n", 1}});
  }
  log_error("after the scope");
  std::ifstream file(path);
  std::string line;
  ASSERT_TRUE(std::getline(file, line));
  EXPECT_EQ(line.find("time=20"), 0U) << line;
  EXPECT_NE(line.find("level=warning node=planner/north event=wanted n=1"), std::string::npos) << line;
  EXPECT_FALSE(std::getline(file, line)) << line;
  std::filesystem::remove(path);
}

TEST(LogLimit, LeavesLinesOfAFrequentEventOutAndCountsThem) {
  LogLimit limit;
  LogLimit::Time now{};
  int admitted = 0;
  for (int i = 0; i < 10'000; ++i) admitted += limit.admit("order", now) ? 1 : 0;
  EXPECT_EQ(admitted, 200);
  EXPECT_EQ(limit.admit("fault", now), 0U) << "another event has lines of its own";
  EXPECT_EQ(limit.admit("order", now + std::chrono::milliseconds(199)), std::nullopt);
  EXPECT_EQ(limit.admit("order", now + std::chrono::milliseconds(201)), 9'801U);
  EXPECT_EQ(limit.admit("order", now + std::chrono::hours(1)), 0U);
}

TEST(Log, SaysHowManyLinesAreLeftOut) {
  const auto path = std::filesystem::temp_directory_path() / ("hecaton-log-limit-" + std::to_string(getpid()));
  ServiceOptions options;
  options.log_file = path.string();
  {
    const LogScope scope("world", options);
    for (int i = 0; i < 400; ++i) log_info("a flood of edits");
    std::this_thread::sleep_for(std::chrono::milliseconds(250));  // lines are given by the second, not by an event
    log_info("a flood of edits");
  }
  std::ifstream file(path);
  int lines = 0;
  std::string last;
  for (std::string line; std::getline(file, line); ++lines) last = line;
  EXPECT_LT(lines, 300);
  EXPECT_NE(last.find("omitted_before="), std::string::npos) << last;
  std::filesystem::remove(path);
}

TEST(Log, RefusesAFileThatCannotBeOpened) {
  ServiceOptions options;
  options.log_file = "/";
  EXPECT_THROW(LogScope("x", options), std::runtime_error);
}

}  // namespace
}  // namespace hecaton::services
