#include "services/runtime/log.hpp"

#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>
#include <unistd.h>

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

TEST(Log, RefusesAFileThatCannotBeOpened) {
  ServiceOptions options;
  options.log_file = "/";
  EXPECT_THROW(LogScope("x", options), std::runtime_error);
}

}  // namespace
}  // namespace hecaton::services
