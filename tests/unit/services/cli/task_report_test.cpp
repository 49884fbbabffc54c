#include "services/cli/task_report.hpp"

#include <cstdio>
#include <fstream>

#include <gtest/gtest.h>

#include "services/command_line/program.hpp"

namespace hecaton::services::cli {
namespace {

Report example_report() {
  Report report;
  report.cell = "c";
  report.asked = 3;
  report.tasks = 3;
  report.reached = 2;
  report.timed_out = 1;
  report.smallest = world::Separation{0.031, world::ContactKind::kArmArm, "a/x", "b/y", 1.5};
  report.duration = 12.5;
  report.times = {3.0, 1.0};
  report.arms = {{"a", 2, 2, 0, 0}, {"b", 1, 0, 0, 1}};
  return report;
}

TEST(Report, BeginsWithTheDocumentedKeys) {
  const Json json = to_json(example_report());
  std::vector<std::string> keys;
  for (const auto& [key, value] : json.items()) keys.push_back(key);
  const std::vector<std::string> promised{
      "tasks",      "reached", "blocked", "timed_out", "contacts", "min_separation_m",
      "duration_s", "tick_us", "arms",    "faults"};
  ASSERT_GE(keys.size(), promised.size());
  keys.resize(promised.size());
  EXPECT_EQ(keys, promised);
  EXPECT_EQ(json["tasks"], 3);
  EXPECT_EQ(json["min_separation_m"], 0.031);
  EXPECT_TRUE(json["tick_us"].is_null());
  EXPECT_EQ(json["arms"][1], (Json{{"name", "b"}, {"tasks", 1}, {"reached", 0}, {"blocked", 0}, {"timed_out", 1}}));
  EXPECT_EQ(json["faults"], Json::array());
  EXPECT_EQ(json["closest_pair"]["a"], "a/x");
}

TEST(Report, HasTickTimesWhenMeasured) {
  Report report = example_report();
  report.tick_us = Quantiles{1.0, 2.0, 3.0};
  EXPECT_EQ(to_json(report)["tick_us"], (Json{{"p50", 1.0}, {"p99", 2.0}, {"max", 3.0}}));
}

TEST(Report, SaysWhenNoPairWasChecked) {
  Report report = example_report();
  report.smallest.reset();
  EXPECT_TRUE(to_json(report)["min_separation_m"].is_null());
  EXPECT_NE(table_text(report, Palette(false)).find("no pair was checked"), std::string::npos);
}

TEST(Report, IsPositiveOnlyWithAllTasksReachedAndNoContact) {
  Report report = example_report();
  EXPECT_FALSE(report.positive());
  report.reached = 3;
  EXPECT_TRUE(report.positive());
  report.contacts = 1;
  EXPECT_FALSE(report.positive());
  EXPECT_FALSE(Report().positive());
}

TEST(Report, CountsTasksWithoutGoalsAsMissed) {
  Report report = example_report();
  report.reached = 3;
  report.timed_out = 0;
  report.asked = 4;
  report.not_drawn = 1;
  EXPECT_FALSE(report.positive());
  EXPECT_EQ(to_json(report)["not_drawn"], 1);
  const std::string text = table_text(report, Palette(false));
  EXPECT_NE(text.find("75.0 %"), std::string::npos) << text;
  EXPECT_NE(text.find("1 tasks: no free goals were found"), std::string::npos) << text;
}

TEST(Report, GivesTheReasonOfEveryMissedTask) {
  Report report = example_report();
  report.missed = {{4, "b", "timed_out", {0.5, 1.0}, "no progress: b/hand – crate, 3 mm"}};
  EXPECT_EQ(to_json(report)["missed"], Json::parse(R"([{"round": 4, "arm": "b", "outcome": "timed_out",
      "goal": [0.5, 1.0], "reason": "no progress: b/hand – crate, 3 mm"}])"));
  const std::string text = table_text(report, Palette(false));
  EXPECT_NE(text.find("missed: round 4, b timed out: no progress: b/hand – crate, 3 mm\n"), std::string::npos) << text;
  report.missed.resize(14, report.missed.front());
  EXPECT_NE(table_text(report, Palette(false)).find("missed: 4 more"), std::string::npos);
}

TEST(Report, OfAnInterruptedRunSaysHowMuchIsDone) {
  Report report = example_report();
  report.asked = 100;
  report.reached = 3;
  report.timed_out = 0;
  EXPECT_FALSE(report.positive()) << "97 tasks are missing";
  EXPECT_TRUE(to_json(report)["interrupted"].is_null());
  report.interrupted = Interrupted{15, 3, 100, "tasks"};
  EXPECT_EQ(static_cast<int>(report.exit_code()), 143);
  EXPECT_EQ(to_json(report)["interrupted"],
            (Json{{"signal", "SIGTERM"}, {"done", 3}, {"asked", 100}, {"unit", "tasks"}}));
  const std::string text = table_text(report, Palette(false));
  EXPECT_NE(text.find("interrupted by SIGTERM: 3 of 100 tasks done"), std::string::npos) << text;
  EXPECT_NE(text.find("100.0 % of the tasks so far"), std::string::npos) << text;
}

TEST(Report, NamesTheClosestPair) {
  const std::string text = table_text(example_report(), Palette(false));
  EXPECT_NE(text.find("31 mm (a/x – b/y)"), std::string::npos);
  EXPECT_NE(text.find("66.7 %"), std::string::npos);
}

TEST(Quantile, IsTheSmallestValueNotBelowTheShare) {
  const std::vector<double> sorted{1, 2, 3, 4, 5, 6, 7, 8, 9, 10};
  EXPECT_EQ(quantile(sorted, 0.5), 5.0);
  EXPECT_EQ(quantile(sorted, 0.95), 10.0);
  EXPECT_EQ(quantile(sorted, 0.9), 9.0);
  EXPECT_EQ(quantile(sorted, 0.0), 1.0);
  EXPECT_EQ(quantile({}, 0.5), 0.0);
}

TEST(Quantiles, SortTheValues) {
  const auto found = quantiles({3.0, 1.0, 2.0});
  ASSERT_TRUE(found);
  EXPECT_EQ(found->p50, 2.0);
  EXPECT_EQ(found->max, 3.0);
  EXPECT_FALSE(quantiles({}));
}

TEST(WriteReport, RejectsAFileThatCannotBeWritten) {
  try {
    check_writable("/nowhere/report.json");
    FAIL() << "no failure";
  } catch (const Failure& failure) {
    EXPECT_EQ(failure.code(), ExitCode::kBadInput);
    EXPECT_STREQ(failure.what(), "report file '/nowhere/report.json' cannot be written");
  }
}

TEST(WriteReport, WritesTheJsonOfTheReport) {
  const std::string path = testing::TempDir() + "hecaton_report_test.json";
  write_report(path, example_report());
  std::ifstream file(path);
  EXPECT_EQ(Json::parse(file), to_json(example_report()));
  std::remove(path.c_str());
}

}  // namespace
}  // namespace hecaton::services::cli
