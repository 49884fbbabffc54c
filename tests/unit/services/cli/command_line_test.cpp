/// What is a usage error, what is bad input, and what each says. No network: nothing here gets that far.

#include <fstream>

#include <CLI/CLI.hpp>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "services/cli/command_line_shape.hpp"
#include "tests/unit/services/cli/run_line.hpp"

namespace hecaton::services::cli {
namespace {

const std::string kCell = std::string(HECATON_SOURCE_DIR) + "/deploy/cells/three_puma.yaml";
const std::string kUrdf = std::string(HECATON_SOURCE_DIR) + "/deploy/cells/urdf/puma560.urdf";

using Words = std::vector<std::string>;

TEST(CommandLine, RefusesWrongUsage) {
  const std::vector<std::pair<Words, std::string>> lines{
      {{}, "A subcommand is required"},
      {{"sttus"}, "no command 'sttus'; did you mean 'status'?"},
      {{"status", "--bogus"}, "--bogus"},
      {{"status", "-o", "xml"}, "'xml' must be table, json or yaml"},
      {{"status", "--domain", "200"}, "--domain"},
      {{"status", "--interval", "5"}, "must be a number with its unit"},
      {{"status", "--connect-timeout", "-1s"}, "must be a number with its unit"},
      {{"goal", "north"}, "--joints"},
      {{"goal", "north", "--joints", "0 nan"}, "'nan' must be a finite number"},
      {{"goal", "north", "--joints", "0 a"}, "'a' must be a finite number"},
      {{"goal", "north", "--pose", "0 0 1"}, "3 numbers given, must be 6"},
      {{"goal", "north", "--named", "home", "--joints", "0"}, "Exactly 1 option"},
      {{"goal", "north", "--named", "home", "--time-limit", "3"}, "must be a number with its unit"},
      {{"wait", "north", "--for", "reached,done"}, "'done' must be reached, blocked"},
      {{"wait", "north", "--timeout", "30"}, "must be a number with its unit"},
      {{"obstacle"}, "A subcommand is required"},
      {{"obstacle", "add", "x", "--sphere", "-1", "--pose", "0 0 0 0 0 0"}, "must be above 0"},
      {{"attach", "north"}, "OBJECT is required"},
      {{"simulate"}, "CELL is required"},
      {{"simulate", kCell, "--tasks", "0"}, "--tasks"},
      {{"simulate", kCell, "--loss", "1"}, "--loss"},
      {{"simulate", kCell, "--jitter", "20ms"}, "--jitter must be at most --age"},
      {{"simulate", kCell, "--method", "magic"}, "'magic' must be local or boundary_following"},
      {{"up"}, "CELL is required"},
      {{"check", kUrdf, "--package", "x"}, "must be NAME=DIR"},
      {{"completion", "fish"}, "fish"},
  };
  for (const auto& [words, sentence] : lines) {
    const Ran ran = run_line(words);
    EXPECT_EQ(ran.code, ExitCode::kUsage) << ran.err;
    EXPECT_NE(ran.err.find(sentence), std::string::npos) << "expected \"" << sentence << "\" in:\n" << ran.err;
    EXPECT_EQ(ran.out, "");
  }
}

TEST(CommandLine, RefusesBadInputWithOneSentence) {
  const std::string broken = testing::TempDir() + "hecaton_broken_cell.yaml";
  std::ofstream(broken) << "name: x\nbogus: 1\n";
  for (const char* command : {"check", "simulate", "up"}) {
    for (const std::string& file : {broken, std::string("/nowhere/cell.yaml")}) {
      const Ran ran = run_line({command, file});
      EXPECT_EQ(ran.code, ExitCode::kBadInput) << command << " " << file;
      EXPECT_NE(ran.err.find(file), std::string::npos) << ran.err;
      EXPECT_EQ(std::count(ran.err.begin(), ran.err.end(), '\n'), 1) << ran.err;
      EXPECT_EQ(ran.out, "");
    }
  }
  const Ran status = run_line({"status", "--cell", broken});
  EXPECT_EQ(status.code, ExitCode::kBadInput) << status.err;
  std::remove(broken.c_str());
}

TEST(CommandLine, HelpOfEveryCommandIsNoError) {
  Session session;
  const auto app = make_application(session);
  for (const CLI::App* command : subcommands_of(*app)) {
    const Ran ran = run_line({command->get_name(), "--help"});
    EXPECT_EQ(ran.code, ExitCode::kDone) << command->get_name();
    EXPECT_NE(ran.out.find(command->get_description()), std::string::npos);
  }
}

TEST(Check, ExplainsACell) {
  const Ran table = run_line({"check", kCell});
  EXPECT_EQ(table.code, ExitCode::kDone) << table.err;
  EXPECT_NE(table.out.find("this cell can start"), std::string::npos);
  const Ran json = run_line({"check", kCell, "-o", "json"});
  const auto cell = nlohmann::json::parse(json.out);
  EXPECT_EQ(cell["cell"], "three_puma");
  ASSERT_EQ(cell["arms"].size(), 3U);
  EXPECT_EQ(cell["arms"][0]["model"]["joints"].size(), 6U);
}

TEST(Check, ExplainsARobot) {
  const Ran ran = run_line({"-o", "json", "check", kUrdf});
  ASSERT_EQ(ran.code, ExitCode::kDone) << ran.err;
  const auto robot = nlohmann::json::parse(ran.out);
  EXPECT_EQ(robot["name"], "puma560");
  EXPECT_EQ(robot["joints"].size(), 6U);
  // Seven links have one shape each (see the URDF): 7 · 6 / 2 pairs.
  EXPECT_EQ(robot["geometry"].size(), 7U);
  EXPECT_EQ(robot["self_pairs"]["all"], 21);
  EXPECT_EQ(robot["self_pairs"]["checked"].get<int>() + robot["self_pairs"]["filtered"].get<int>(), 21);
}

}  // namespace
}  // namespace hecaton::services::cli
