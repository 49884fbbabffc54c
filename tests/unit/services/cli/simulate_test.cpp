#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>

#include <gtest/gtest.h>
#include <unistd.h>

#include "services/command_line/document.hpp"
#include "tests/unit/services/cli/run_line.hpp"

namespace hecaton::services::cli {
namespace {

const std::string kThreePuma = std::string(HECATON_SOURCE_DIR) + "/deploy/cells/three_puma.yaml";
const std::string kDense = std::string(HECATON_SOURCE_DIR) + "/deploy/cells/three_puma_dense.yaml";

std::vector<std::string> simulate(const std::vector<std::string>& more) {
  std::vector<std::string> words{"simulate", kThreePuma, "--tasks", "7", "--seed", "7", "-o", "json"};
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

TEST(Simulate, GivesTheSameReportInEveryRunAndForAnyNumberOfThreads) {
  const Ran first = run_line(simulate({}));
  ASSERT_FALSE(first.out.empty()) << first.err;
  EXPECT_EQ(run_line(simulate({})).out, first.out);
  EXPECT_EQ(run_line(simulate({"--threads", "2"})).out, first.out);
  EXPECT_NE(run_line(simulate({"--seed", "8"})).out, first.out);
}

TEST(Simulate, CountsEveryTaskOnce) {
  const Ran ran = run_line(simulate({}));
  const Json report = Json::parse(ran.out);
  EXPECT_EQ(report["tasks"], 7);
  const auto count = [&](const char* key) { return report[key].get<int>(); };
  EXPECT_EQ(count("reached") + count("blocked") + count("timed_out"), 7);
  int of_arms = 0;
  for (const Json& arm : report["arms"]) of_arms += arm["tasks"].get<int>();
  EXPECT_EQ(of_arms, 7);
  EXPECT_TRUE(report["tick_us"].is_null()) << "measured times are not repeatable";
  const bool positive = count("reached") == 7 && report["contacts"] == 0;
  EXPECT_EQ(ran.code, positive ? ExitCode::kDone : ExitCode::kNegative);
  EXPECT_NE(ran.err.find("simulated seconds per second"), std::string::npos);
}

TEST(Simulate, MeasuresTicksWithTiming) {
  const Json report = Json::parse(run_line(simulate({"--timing"})).out);
  ASSERT_TRUE(report["tick_us"].is_object());
  EXPECT_GT(report["tick_us"]["p50"].get<double>(), 0.0);
  EXPECT_LE(report["tick_us"]["p50"].get<double>(), report["tick_us"]["p99"].get<double>());
  EXPECT_LE(report["tick_us"]["p99"].get<double>(), report["tick_us"]["max"].get<double>());
}

TEST(Simulate, ReportsTheCostOfRollouts) {
  const std::vector<std::string> words{"simulate", kDense, "--tasks", "9", "--seed", "7", "-o", "json"};
  const Json report = Json::parse(run_line(words).out);
  EXPECT_GT(report["rollouts"]["answers"].get<int>(), 0);
  // Nine rollouts of three arms, each of at least one tick.
  EXPECT_GE(report["rollouts"]["ticks"].get<int>(), 27 * report["rollouts"]["answers"].get<int>());
  EXPECT_TRUE(report["rollouts"]["processor_us"].is_null());
  std::vector<std::string> timed = words;
  timed.emplace_back("--timing");
  EXPECT_GT(Json::parse(run_line(timed).out)["rollouts"]["processor_us"].get<double>(), 0.0);
  timed.emplace_back("--rollouts=0");
  EXPECT_EQ(Json::parse(run_line(timed).out)["rollouts"]["answers"], 0);
}

TEST(Simulate, GivesAReasonForEveryMissedTask) {
  const Json report = Json::parse(run_line({"simulate", kDense, "--tasks", "7", "--seed", "1", "-o", "json", "--method",
                                            "local", "--no-routes", "--rollouts", "0"})
                                      .out);
  const int missed = report["blocked"].get<int>() + report["timed_out"].get<int>();
  ASSERT_GT(missed, 0) << "the local method has local minima";
  ASSERT_EQ(report["missed"].size(), static_cast<std::size_t>(missed));
  for (const Json& task : report["missed"]) {
    EXPECT_FALSE(task["reason"].get<std::string>().empty()) << task;
    EXPECT_EQ(task["goal"].size(), 6U);
  }
  EXPECT_TRUE(report["interrupted"].is_null());
  EXPECT_EQ(report["tasks_asked"], 7);
}

TEST(Simulate, TakesLessTimeWithFasterJoints) {
  const Json slow = Json::parse(run_line(simulate({"--speed", "0.5"})).out);
  const Json fast = Json::parse(run_line(simulate({"--speed", "3"})).out);
  EXPECT_LT(fast["task_s"]["p50"].get<double>(), slow["task_s"]["p50"].get<double>());
}

TEST(Simulate, RejectsRolloutsThatAreNoWholeNumber) {
  for (const char* bad : {"x", "-1", "1.5", "1001"}) {
    const Ran ran = run_line(simulate({std::string("--rollouts=") + bad}));
    EXPECT_EQ(ran.code, ExitCode::kBadInput) << bad;
    EXPECT_NE(ran.err.find(std::string("--rollouts = '") + bad + "' must be a whole number from 0 to 1000"),
              std::string::npos)
        << ran.err;
  }
}

TEST(Simulate, ReportsVelocityReversalsOfEveryMethod) {
  for (const char* method : {"local", "single_subspace", "boundary_following"}) {
    const Ran ran = run_line(simulate({"--rollouts", "0", "--method", method}));
    const Json report = Json::parse(ran.out);
    EXPECT_EQ(report["method"], method);
    EXPECT_GT(report["velocity_reversals"]["joint_s_near"].get<double>(), 0.0);
    EXPECT_GE(report["velocity_reversals"]["per_joint_s"].get<double>(),
              report["velocity_reversals"]["quick_per_joint_s"].get<double>());
    if (std::string(method) == "local") {
      EXPECT_EQ(report["subspaces_drawn"], 0);
    }
  }
}

TEST(Simulate, RejectsBurstsTooShortForTheLoss) {
  const Ran ran = run_line(simulate({"--loss", "0.75", "--burst", "2"}));
  EXPECT_EQ(ran.code, ExitCode::kBadInput);
  EXPECT_NE(ran.err.find("--burst = 2 must be at least loss/(1 − loss) = 3 for --loss = 0.75"), std::string::npos)
      << ran.err;
  EXPECT_EQ(Json::parse(run_line(simulate({"--loss", "0.2", "--burst", "2"})).out)["network"]["burst"], 2.0);
}

TEST(Simulate, WritesTheReportThatItPrints) {
  const std::string path = testing::TempDir() + "hecaton_simulate_test.json";
  const Ran ran = run_line(simulate({"--report", path}));
  std::ifstream file(path);
  std::stringstream text;
  text << file.rdbuf();
  EXPECT_EQ(text.str(), ran.out);
  std::remove(path.c_str());
}

TEST(Simulate, ChangesTheMethodAndTheNetwork) {
  const Json report =
      Json::parse(run_line(simulate({"--method", "local", "--age", "20ms", "--jitter", "5ms", "--loss", "0.1"})).out);
  EXPECT_EQ(report["method"], "local");
  EXPECT_EQ(report["subspaces_drawn"], 0) << "the local planner follows no boundary";
  EXPECT_EQ(report["network"], (Json{{"age_s", 0.02}, {"jitter_s", 0.005}, {"loss", 0.1}, {"burst", 0.0}}));
}

TEST(Simulate, ExitsWithOneWhenTasksWereMissed) {
  // The local planner alone reaches about two thirds of such tasks [Lahouar06]: of sixty some are missed.
  const Ran ran = run_line({"simulate", kThreePuma, "--tasks", "60", "--method", "local", "-o", "json"});
  const Json report = Json::parse(ran.out);
  EXPECT_LT(report["reached"].get<int>(), 60);
  EXPECT_EQ(ran.code, ExitCode::kNegative);
}

TEST(Simulate, PlotsTheFirstEpisodeInCspace) {
  const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) / "hecaton_plots";
  std::filesystem::remove_all(folder);
  const Ran ran = run_line({"simulate", std::string(HECATON_SOURCE_DIR) + "/deploy/cells/planar_2r.yaml", "--tasks",
                            "1", "--plot", folder.string()});
  EXPECT_NE(ran.err.find(" plots in " + folder.string()), std::string::npos) << ran.err;
  std::ifstream file(folder / "arm_0000.svg");
  std::stringstream text;
  text << file.rdbuf();
  EXPECT_TRUE(text.str().starts_with("<svg"));
  EXPECT_TRUE(text.str().ends_with("</svg>\n"));
  std::filesystem::remove_all(folder);
}

// [Cardenas10] figures 5 and 6, and 2 beside them.
TEST(Simulate, PlotsArmsInTheirPotentialFields) {
  for (const std::string cell : {"mobile_rectangle", "puma_potential"}) {
    const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) / ("hecaton_field_" + cell);
    std::filesystem::remove_all(folder);
    const Ran ran = run_line({"simulate", std::string(HECATON_SOURCE_DIR) + "/deploy/cells/" + cell + ".yaml",
                              "--tasks", "1", "--plot", folder.string()});
    EXPECT_EQ(ran.code, ExitCode::kDone) << ran.err;
    std::ifstream file(folder / ((cell == "puma_potential" ? "puma" : "robot") + std::string("_0004.svg")));
    std::stringstream text;
    text << file.rdbuf();
    const std::string svg = text.str();
    EXPECT_TRUE(svg.starts_with("<svg"));
    EXPECT_TRUE(svg.ends_with("</svg>\n"));
    EXPECT_EQ(svg.find("nan"), std::string::npos);
    EXPECT_NE(svg.find("marker-end"), std::string::npos) << "arrows of the field";
    std::size_t panels = 0;
    for (std::size_t at = svg.find("<svg x="); at != std::string::npos; at = svg.find("<svg x=", at + 1)) ++panels;
    EXPECT_EQ(panels, cell == "puma_potential" ? 3U : 2U)
        << "view from above, view from the side unless the arm stays level, field";
    std::filesystem::remove_all(folder);
  }
}

TEST(Simulate, RejectsPlotsThatItCannotWrite) {
  const Ran none = run_line(simulate({"--plot", testing::TempDir()}));
  EXPECT_EQ(none.code, ExitCode::kBadInput);
  EXPECT_NE(none.err.find("--plot = "), std::string::npos) << none.err;
  EXPECT_NE(none.err.find("sensed_cspace, known_cspace or potential_field"), std::string::npos) << none.err;
  const Ran nowhere = run_line(
      {"simulate", std::string(HECATON_SOURCE_DIR) + "/deploy/cells/planar_2r.yaml", "--plot", "/dev/null/plots"});
  EXPECT_EQ(nowhere.code, ExitCode::kBadInput);
  EXPECT_NE(nowhere.err.find("--plot: /dev/null/plots cannot be created"), std::string::npos) << nowhere.err;
}

TEST(Simulate, RejectsAMethodThatDoesNotSuitAnArm) {
  const Ran ran = run_line(simulate({"--method", "known_cspace"}));
  EXPECT_EQ(ran.code, ExitCode::kBadInput);
  EXPECT_NE(ran.err.find("--method = known_cspace must be given to an arm of two links"), std::string::npos) << ran.err;
}

TEST(Simulate, ArmsWithStrategiesReachTheirGoalsWithoutContact) {
  const std::string cell = std::string(HECATON_SOURCE_DIR) + "/deploy/cells/scorbot_2a.yaml";
  for (const char* method : {"strategy", "strategy_step"}) {
    const Ran ran = run_line({"simulate", cell, "--method", method, "--tasks", "20", "-o", "json"});
    const Json report = Json::parse(ran.out);
    EXPECT_EQ(report["contacts"], 0) << method;
    EXPECT_EQ(report["reached"], 20) << method;
  }
}

// An arm's method does not matter to the record; a field, a C-space and boundary following have one each.
TEST(Simulate, RecordsTheFirstEpisodeWithEachKindOfMethod) {
  const auto file = std::filesystem::temp_directory_path() / ("hecaton-record-" + std::to_string(getpid()) + ".jsonl");
  for (const std::string cell : {"three_puma", "planar_2r", "planar_3r"}) {
    const std::string path = std::string(HECATON_SOURCE_DIR) + "/deploy/cells/" + cell + ".yaml";
    const Ran ran = run_line({"simulate", path, "--tasks", "1", "--seed", "3", "--record", file.string()});
    std::ifstream lines(file);
    double last = 0.0;
    int count = 0;
    for (std::string line; std::getline(lines, line); ++count) {
      const Json moment = Json::parse(line);
      if (count > 0) {
        EXPECT_NEAR(moment["time"].get<double>() - last, 0.05, 0.011) << cell;
      }
      last = moment["time"].get<double>();
      ASSERT_FALSE(moment["arms"].empty()) << cell;
      EXPECT_EQ(moment["arms"][0]["tool"].size(), 3U) << cell;
      EXPECT_FALSE(moment["obstacles"][0]["shapes"].empty()) << cell;
    }
    EXPECT_GT(count, 5) << cell << ": " << ran.err;
    std::filesystem::remove(file);
  }
}

TEST(Simulate, RefusesARecordThatCannotBeWritten) {
  const Ran ran = run_line(simulate({"--record", "/nowhere/episode.jsonl"}));
  EXPECT_EQ(ran.code, ExitCode::kBadInput);
  EXPECT_NE(ran.err.find("--record: /nowhere/episode.jsonl cannot be written"), std::string::npos) << ran.err;
}

}  // namespace
}  // namespace hecaton::services::cli
