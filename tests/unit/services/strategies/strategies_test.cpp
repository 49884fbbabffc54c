// hecaton-strategies: repeatable and resumable searches, whose results cells load.

#include <filesystem>
#include <fstream>
#include <iomanip>
#include <sstream>

#include <gtest/gtest.h>

#include "planner/methods/strategy/strategy.hpp"
#include "services/command_line/document.hpp"
#include "services/config/cell_file.hpp"
#include "services/strategies/commands.hpp"
#include "tests/unit/services/command_line/run_program_line.hpp"

namespace hecaton::services::cli {
namespace {

Ran run_line(const std::vector<std::string>& words) {
  return run_line(strategies_program(), words);
}

const std::string kScorbots = std::string(HECATON_SOURCE_DIR) + "/deploy/cells/scorbot_2a.yaml";

/// A small search: 64 strategies.
std::vector<std::string> small_search(const std::vector<std::string>& more) {
  std::vector<std::string> words{"search",  kScorbots, "--tasks", "40",     "--confirm", "60",
                                 "--alpha", "-2 2",    "--beta",  "-2.5 1", "-o",        "json"};
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

std::string content(const std::string& path) {
  std::ostringstream text;
  text << std::ifstream(path).rdbuf();
  return text.str();
}

class StrategiesTest : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::path(testing::TempDir()) /
              ("strategies_" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  [[nodiscard]] std::string in_folder(const std::string& name) const { return (folder_ / name).string(); }

 private:
  std::filesystem::path folder_;
};

TEST_F(StrategiesTest, SearchIsTheSameForAllNumbersOfThreads) {
  const Ran one = run_line(small_search({"--threads", "1"}));
  ASSERT_EQ(one.code, ExitCode::kDone) << one.err;
  EXPECT_EQ(run_line(small_search({"--threads", "3"})).out, one.out);
  EXPECT_NE(run_line(small_search({"--seed", "5"})).out, one.out);
  const Json report = Json::parse(one.out);
  EXPECT_EQ(report["stages"][0]["candidates"], 64);
  EXPECT_EQ(report["strategies"][0]["faults"], 0);
  EXPECT_EQ(report["strategies"][0]["tasks"], 2 * (40 + 60 + 60));
}

TEST_F(StrategiesTest, InterruptedSearchResumes) {
  const Ran whole = run_line(small_search({"--results", in_folder("found")}));
  ASSERT_EQ(whole.code, ExitCode::kDone) << whole.err;
  const std::string csv = content(in_folder("found.csv"));
  const std::string progress = content(in_folder("found.progress"));
  std::ofstream(in_folder("found.progress")) << progress.substr(0, progress.size() / 2);  // truncates a line
  const Ran resumed = run_line(small_search({"--results", in_folder("found"), "--resume"}));
  EXPECT_EQ(resumed.out, whole.out);
  EXPECT_EQ(content(in_folder("found.csv")), csv);
  const Ran other = run_line(small_search({"--results", in_folder("found"), "--resume", "--seed", "9"}));
  EXPECT_EQ(other.code, ExitCode::kBadInput);
  EXPECT_NE(other.err.find("is of another search"), std::string::npos) << other.err;
}

// Earlier results stay until a search has succeeded.
TEST_F(StrategiesTest, FailedSearchKeepsEarlierResults) {
  const std::string csv = in_folder("found") + ".csv";
  std::ofstream(csv) << "found before\n";
  EXPECT_NE(run_line(small_search({"--combine", csv, "--results", in_folder("found")})).code, ExitCode::kDone);
  std::ifstream file(csv);
  std::string line;
  EXPECT_TRUE(std::getline(file, line));
  EXPECT_EQ(line, "found before");
}

TEST_F(StrategiesTest, ShowAndValidateReadSearchResults) {
  const Ran search = run_line(small_search({"--results", in_folder("found")}));
  const Ran show = run_line({"show", in_folder("found.csv"), "--top", "10", "-o", "json"});
  ASSERT_EQ(show.code, ExitCode::kDone) << show.err;
  EXPECT_EQ(Json::parse(show.out), Json::parse(search.out)["strategies"]);
  const Ran validate =
      run_line({"validate", kScorbots, "--strategies", in_folder("found.csv"), "--tasks", "100", "-o", "json"});
  const Json report = Json::parse(validate.out);
  EXPECT_EQ(report["arms"].size(), 2U);
  EXPECT_EQ(report["arms"][0]["autocorrelation"].size(), 6U);
  EXPECT_EQ(report["strategy"]["tasks"], 200);
}

// `strategy: {file: …}` loads the results of search.
TEST_F(StrategiesTest, CellLoadsSearchResults) {
  const Ran search = run_line(small_search({"--results", in_folder("found")}));
  std::string cell = content(kScorbots);
  for (std::size_t own = 0; (own = cell.find("    strategy: {coeff")) != std::string::npos;) {
    cell.erase(own, cell.find('\n', own) + 1 - own);
  }
  const std::string defaults = "  strategy:\n";
  ASSERT_NE(cell.find(defaults), std::string::npos);
  cell.insert(cell.find(defaults) + defaults.size(), "    file: " + in_folder("found.yaml") + "\n");
  const config::CellFile file = config::parse_cell_file(cell, kScorbots);
  const Json best = Json::parse(search.out)["strategies"][0]["arms"];
  for (std::size_t arm = 0; arm < 2; ++arm) {
    const auto loaded = planner::parameters_of<planner::StrategyParameters>(file.cell.arms[arm].methods);
    EXPECT_EQ(best[arm]["name"], file.cell.arms[arm].arm.name);
    EXPECT_EQ(loaded.coefficients, 2);
    EXPECT_EQ(loaded.strategy.coefficients[0], best[arm]["coefficients"][0].get<double>());
    EXPECT_EQ(loaded.strategy.coefficients[1], best[arm]["coefficients"][1].get<double>());
    EXPECT_EQ(loaded.strategy.direction, best[arm]["direction"].get<double>());
  }
}

TEST_F(StrategiesTest, RejectsInvalidInput) {
  const Ran puma = run_line({"search", std::string(HECATON_SOURCE_DIR) + "/deploy/cells/three_puma.yaml"});
  EXPECT_EQ(puma.code, ExitCode::kBadInput);
  EXPECT_NE(puma.err.find("tasks.areas is missing"), std::string::npos) << puma.err;
  EXPECT_EQ(run_line(small_search({"--resume"})).code, ExitCode::kUsage);
  std::ofstream(in_folder("bad.csv")) << "rank,time,time_error,tasks,faults,a_direction\n1,80,1,100,0,2\n";
  const Ran bad = run_line({"show", in_folder("bad.csv")});
  EXPECT_EQ(bad.code, ExitCode::kBadInput);
  EXPECT_NE(bad.err.find("line 2: a direction must be 1 or -1"), std::string::npos) << bad.err;
}

TEST_F(StrategiesTest, RejectsCoefficientsThatCellFilesReject) {
  std::ofstream(in_folder("far.csv")) << "rank,time,time_error,tasks,faults,a_direction,a_1\n1,80,1,100,0,1,1001\n";
  const std::vector<std::vector<std::string>> lines = {{"search", kScorbots, "--alpha", "0 1001"},
                                                       {"search", kScorbots, "--beta=-1e9"},
                                                       {"validate", kScorbots, "--from", "1001 1 1 2 1 1"},
                                                       {"simplex", kScorbots, "--from", "1001 1 1 2 1 1"},
                                                       {"show", in_folder("far.csv")}};
  for (const std::vector<std::string>& line : lines) {
    const Ran ran = run_line(line);
    EXPECT_EQ(ran.code, ExitCode::kBadInput) << line[1];
    EXPECT_NE(ran.err.find("must be a number between -1000 and 1000"), std::string::npos) << ran.err;
  }
}

// A repeated strategy would count twice.
TEST_F(StrategiesTest, RejectsRepeatedValues) {
  const Ran ran = run_line({"search", kScorbots, "--alpha", "0 2 -0"});
  EXPECT_EQ(ran.code, ExitCode::kBadInput);
  EXPECT_NE(ran.err.find("--alpha has 0 twice"), std::string::npos) << ran.err;
}

TEST_F(StrategiesTest, AllCommandsRejectOverlappingAreas) {
  std::string cell = content(kScorbots);
  const std::string spread = "spread: 0.1176";
  ASSERT_NE(cell.find(spread), std::string::npos);
  cell.replace(cell.find(spread), spread.size(), "spread: 1.2");
  const std::string urdf = "urdf: urdf/";
  cell.replace(cell.find(urdf), urdf.size(), "urdf: " HECATON_SOURCE_DIR "/deploy/cells/urdf/");
  const std::string file = in_folder("overlap.yaml");
  std::ofstream(file) << cell;
  const std::vector<std::vector<std::string>> lines = {{"search", file}, {"validate", file}, {"simplex", file}};
  for (const std::vector<std::string>& line : lines) {
    const Ran ran = run_line(line);
    EXPECT_EQ(ran.code, ExitCode::kBadInput) << line[0];
    EXPECT_NE(ran.err.find("tasks.areas.robot1 = left, right must be poses more than twice tasks.spread apart"),
              std::string::npos)
        << line[0] << ": " << ran.err;
  }
}

/// Commands in docs/explanation/strategies.md and their output: "$ hecaton-strategies …", and then their output.
std::vector<std::pair<std::string, std::string>> quoted_runs() {
  std::istringstream page(content(HECATON_SOURCE_DIR "/docs/explanation/strategies.md"));
  std::vector<std::pair<std::string, std::string>> runs;
  const std::string indent = "    ";
  const std::string prompt = indent + "$ hecaton-strategies ";
  bool inside = false;
  for (std::string line; std::getline(page, line);) {
    if (line.starts_with(prompt)) {
      runs.emplace_back(line.substr(prompt.size()), "");
      inside = true;
    } else if (inside && (line.empty() || line.starts_with(indent))) {
      runs.back().second += (line.empty() ? "" : line.substr(indent.size())) + "\n";
    } else {
      inside = false;
    }
  }
  return runs;
}

// The output in the document must be that of the commands.
TEST_F(StrategiesTest, DocumentedOutputMatchesCommands) {
  const auto runs = quoted_runs();
  ASSERT_FALSE(runs.empty());
  for (const auto& [command, expected] : runs) {
    std::vector<std::string> words;
    std::istringstream text(command);
    for (std::string word; text >> std::quoted(word);) words.push_back(word);
    for (std::string& word : words) {
      if (word.starts_with("deploy/")) word.insert(0, std::string(HECATON_SOURCE_DIR) + "/");
    }
    const Ran ran = run_line(words);
    const auto trimmed = [](std::string lines) { return lines.erase(lines.find_last_not_of('\n') + 1); };
    EXPECT_EQ(trimmed(ran.out), trimmed(expected)) << command;
  }
}

// Files of other cells, and files without results: one sentence each.
TEST_F(StrategiesTest, RejectsFilesThatDoNotFit) {
  const auto says = [&](const std::vector<std::string>& words, const std::string& sentence) {
    const Ran ran = run_line(words);
    EXPECT_EQ(ran.code, ExitCode::kBadInput) << sentence;
    EXPECT_NE(ran.err.find(sentence), std::string::npos) << ran.err;
    EXPECT_EQ(std::count(ran.err.begin(), ran.err.end(), '\n'), 1) << ran.err;
  };
  std::ofstream(in_folder("empty.csv")) << "";
  const std::string first = "rank,time,time_error,tasks,faults,robot1_direction,robot1_1,robot1_2";
  std::ofstream(in_folder("one.csv")) << first << "\n1,80,1,100,0,1,-2,1\n";
  std::ofstream(in_folder("three.csv")) << first << ",robot2_direction,robot2_1,robot2_2,robot3_direction\n"
                                        << "1,80,1,100,0,1,-2,1,1,2,1,1\n";
  std::ofstream(in_folder("other.csv")) << first << ",south_direction,south_1,south_2\n1,80,1,100,0,1,-2,1,1,2,1\n";
  std::ofstream(in_folder("fewer.csv")) << first << ",robot2_direction,robot2_1\n1,80,1,100,0,1,-2,1,1,2\n";
  std::ofstream(in_folder("huge.csv")) << first << "\n1,80,1,1e300,0,1,-2,1\n";
  says({"show", in_folder("empty.csv")}, "cannot be read, or is empty");
  says({"show", in_folder("huge.csv")}, "line 2: tasks and faults must be at most 1e15");
  const auto validate = [&](const std::string& file) {
    return std::vector<std::string>{"validate", kScorbots, "--strategies", in_folder(file)};
  };
  says(validate("one.csv"), "is of another cell: it has strategies for 1 arms");
  says(validate("three.csv"), "is of another cell: it has strategies for 3 arms");
  says(validate("other.csv"), "has no strategy for arm robot2");
  says(validate("fewer.csv"), "arm robot2 must have 2 coefficients, not 1");
  says({"search", kScorbots, "--combine", in_folder("three.csv")}, "must have the strategies of two arms");
}

TEST_F(StrategiesTest, SimplexImprovesTheStrategyOfTheCell) {
  const Ran ran =
      run_line({"simplex", kScorbots, "--from", "0 1 1 2 1 1", "--tasks", "60", "--steps", "30", "-o", "json"});
  const Json report = Json::parse(ran.out);
  EXPECT_LE(report["optimum"]["time_steps"].get<double>(), report["initial"]["time_steps"].get<double>());
  EXPECT_LE(report["evaluations"], 30);
  EXPECT_EQ(run_line({"simplex", kScorbots, "--from", "1 2"}).code, ExitCode::kBadInput);
}

// Of pairs (a, b), (b, a), (b, b), (c, c), the last with a fault: in a ring of three, only a–b–b turned, and b–b–b.
TEST_F(StrategiesTest, CombinesPairsForThreeArms) {
  std::ofstream(in_folder("pairs.csv")) << "rank,time,time_error,tasks,faults,robot1_direction,robot1_1,robot1_2,"
                                           "robot2_direction,robot2_1,robot2_2\n"
                                           "1,80,1,100,0,1,-2,1,1,2,1\n2,80,1,100,0,1,2,1,1,-2,1\n"
                                           "3,80,1,100,0,1,2,1,1,2,1\n4,80,1,100,1,-1,2,1,-1,2,1\n";
  const std::string three = std::string(HECATON_SOURCE_DIR) + "/deploy/cells/scorbot_3a.yaml";
  const Ran ran =
      run_line({"search", three, "--combine", in_folder("pairs.csv"), "--tasks", "10", "--complete", "-o", "json"});
  const Json report = Json::parse(ran.out);
  EXPECT_EQ(report["stages"][0]["candidates"], 4);
  for (const Json& found : report["strategies"]) {
    int turned = 0;
    for (const Json& arm : found["arms"]) turned += arm["coefficients"][0] == -2.0 ? 1 : 0;
    EXPECT_LE(turned, 1);
  }
  const Ran none = run_line({"search", kScorbots, "--combine", in_folder("missing.csv")});
  EXPECT_EQ(none.code, ExitCode::kBadInput);
}

// Other bases and orders are for comparisons; cells do not support them.
TEST_F(StrategiesTest, ComparisonOptionsWriteNoResults) {
  const Ran as_arms = run_line(small_search({"--sets", "0"}));
  for (const char* basis : {"last", "first"}) {
    const Ran ran = run_line(small_search({"--sets", "0", "--basis", basis}));
    EXPECT_NE(ran.out, as_arms.out) << basis;
  }
  EXPECT_NE(run_line(small_search({"--sets", "0", "--neighbours", "nearest"})).out, as_arms.out);
  EXPECT_EQ(run_line(small_search({"--basis", "last", "--results", in_folder("found")})).code, ExitCode::kUsage);
}

TEST_F(StrategiesTest, ValidatesStrategyGivenByNumbers) {
  const std::vector<std::string> tasks{"--tasks", "50", "-o", "json"};
  std::vector<std::string> words{"validate", kScorbots, "--from=-2 1 1 2 1 1"};
  words.insert(words.end(), tasks.begin(), tasks.end());
  std::vector<std::string> own{"validate", kScorbots};  // the strategies of the cell are the same
  own.insert(own.end(), tasks.begin(), tasks.end());
  EXPECT_EQ(run_line(words).out, run_line(own).out);
}

TEST_F(StrategiesTest, PlotsSensitivityTable) {
  const std::string table = in_folder("sensitivity.csv");
  std::ofstream(table) << "group,variant,candidates,screened,confirmed,time\n"
                          "layout,as documented,576,159,114,83.71\ntrials,\"100 tasks, 2 x 100\",576,201,160,83.8\n";
  for (const char* ending : {".svg", ".png"}) {
    const Ran ran = run_line({"plot", table, "--image", in_folder(std::string("picture") + ending)});
    ASSERT_EQ(ran.code, ExitCode::kDone) << ran.err;
  }
  const std::string picture = content(in_folder("picture.svg"));
  EXPECT_NE(picture.find("trials: 100 tasks, 2 x 100"), std::string::npos);
  std::ofstream(table) << "group,variant,candidates,screened,confirmed,time\nlayout,a,576,many,114,83\n";
  const Ran bad = run_line({"plot", table, "--image", in_folder("picture.svg")});
  EXPECT_EQ(bad.code, ExitCode::kBadInput);
  EXPECT_NE(bad.err.find("line 2: 'many' must be a finite number"), std::string::npos) << bad.err;
  EXPECT_EQ(run_line({"plot", table, "--image", in_folder("picture.gif")}).code, ExitCode::kBadInput);
}

}  // namespace
}  // namespace hecaton::services::cli
