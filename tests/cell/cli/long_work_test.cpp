/// Long commands on a terminal and in a pipe: progress, and what a signal leaves.

#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/cell/cli/process.hpp"

namespace hecaton::test {
namespace {

using Json = nlohmann::json;

const std::string kCells = std::string(HECATON_SOURCE_DIR) + "/deploy/cells/";

std::vector<std::string> command(const std::string& program, std::vector<std::string> words) {
  words.insert(words.begin(), std::string(HECATON_BIN_DIR) + "/" + program);
  words.insert(words.end(), {"-o", "json"});
  return words;
}

/// What a command has printed when a signal ended it after its first progress.
struct Cut {
  int code;
  Json report;
  std::string err;
};

Cut interrupt(const std::vector<std::string>& words, int signal, const std::string& after = " left") {
  Process process(words, Process::Stderr::kTerminal);
  EXPECT_TRUE(process.wait_for_message(after)) << process.err();
  process.signal(signal);
  const int code = process.wait();
  return {code, Json::parse(process.out(), nullptr, false), process.err()};
}

class LongWork : public testing::Test {
 protected:
  LongWork() { std::filesystem::create_directories(folder_); }
  ~LongWork() override { std::filesystem::remove_all(folder_); }
  [[nodiscard]] std::string path(const std::string& name) const { return folder_ / name; }

 private:
  std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() / ("hecaton_long_work_" + std::to_string(getpid()));
};

TEST_F(LongWork, SimulationReportsTheTasksBeforeTheSignal) {
  const auto words = command("hecaton", {"simulate", kCells + "three_puma.yaml", "--tasks", "100000", "--report",
                                         path("report.json"), "--threads", "2"});
  for (const int signal : {SIGINT, SIGTERM}) {
    const Cut cut = interrupt(words, signal);
    EXPECT_EQ(cut.code, 128 + signal) << cut.err;
    ASSERT_TRUE(cut.report.is_object()) << cut.err;
    const Json& interrupted = cut.report["interrupted"];
    EXPECT_EQ(interrupted["signal"], signal == SIGINT ? "SIGINT" : "SIGTERM");
    EXPECT_EQ(interrupted["asked"], 100000);
    EXPECT_EQ(interrupted["done"], cut.report["tasks"]);
    EXPECT_GT(cut.report["tasks"], 0);
    EXPECT_EQ(cut.report["reached"].get<int>() + cut.report["blocked"].get<int>() + cut.report["timed_out"].get<int>(),
              cut.report["tasks"]);
    EXPECT_EQ(cut.report["not_drawn"], 0) << "a task that was not begun is no task without goals";
    // The line is rewritten in place and cleared before anything else.
    EXPECT_NE(cut.err.find("\rsimulate ["), std::string::npos) << cut.err;
    EXPECT_EQ(cut.err.find("[#\n"), std::string::npos) << cut.err;
    std::ifstream file(path("report.json"));
    EXPECT_EQ(Json::parse(file, nullptr, false), cut.report);
  }
}

TEST_F(LongWork, PlanningSaysThatItWasInterrupted) {
  // Two walls through the base separate the start from the goal: no planner finds a path.
  std::ofstream(path("walled.yaml")) << "name: walled\nworld: {floor_z: -1}\narms:\n  - {name: arm, urdf: "
                                     << kCells + "urdf/planar_2r.urdf"
                                     << ", limits: {acceleration: 8}}\nobstacles:\n"
                                     << "  - {name: north, shapes: [{type: box, size: [0.04, 0.9, 0.2]}], pose: "
                                        "{xyz: [0, 0.65, 0]}}\n"
                                     << "  - {name: south, shapes: [{type: box, size: [0.04, 0.9, 0.2]}], pose: "
                                        "{xyz: [0, -0.65, 0]}}\n";
  const Cut cut = interrupt(
      command("hecaton", {"plan", path("walled.yaml"), "--from", "0 0.3", "--to", "3 0.3", "--budget", "60min"}),
      SIGINT);
  EXPECT_EQ(cut.code, 130) << cut.err;
  ASSERT_TRUE(cut.report.is_object()) << cut.err;
  EXPECT_EQ(cut.report["solved"], false);
  EXPECT_EQ(cut.report["status"], "interrupted");
  EXPECT_NE(cut.report["reason"].get<std::string>().find("before the signal"), std::string::npos) << cut.report;
  EXPECT_EQ(cut.report["interrupted"]["asked"], 3600.0);
  EXPECT_GT(cut.report["interrupted"]["done"], 0.0);
}

TEST_F(LongWork, StrategySearchKeepsItsEvaluationsAndResumes) {
  std::vector<std::string> words =
      command("hecaton-strategies", {"search", kCells + "scorbot_2a.yaml", "--tasks", "20000", "--complete",
                                     "--threads", "2", "--results", path("found"), "--top", "1000"});
  const Cut cut = interrupt(words, SIGINT);
  EXPECT_EQ(cut.code, 130) << cut.err;
  ASSERT_TRUE(cut.report.is_object()) << cut.err;
  const Json& interrupted = cut.report["interrupted"];
  const int done = interrupted["done"].get<int>();
  EXPECT_GT(done, 0);
  EXPECT_EQ(interrupted["asked"], 576);
  EXPECT_EQ(cut.report["strategies"].size(), static_cast<std::size_t>(done)) << "no strategy that was not evaluated";
  EXPECT_FALSE(std::filesystem::exists(path("found.yaml"))) << "results of an incomplete search";
  EXPECT_NE(cut.err.find("--resume continues"), std::string::npos) << cut.err;
  words.emplace_back("--resume");
  const Cut resumed = interrupt(words, SIGTERM);
  EXPECT_EQ(resumed.code, 143) << resumed.err;
  EXPECT_GE(resumed.report["interrupted"]["done"].get<int>(), done);
}

TEST_F(LongWork, ValidationCountsTheTasksBeforeTheSignal) {
  const Cut cut = interrupt(command("hecaton-strategies", {"validate", kCells + "scorbot_2a.yaml", "--from",
                                                           "0 -2.5 1 2 -2.5 1", "--tasks", "1000000"}),
                            SIGINT);
  EXPECT_EQ(cut.code, 130) << cut.err;
  ASSERT_TRUE(cut.report.is_object()) << cut.err;
  EXPECT_EQ(cut.report["interrupted"]["asked"], 2'000'000);
  EXPECT_EQ(cut.report["interrupted"]["done"], cut.report["strategy"]["tasks"]);
}

TEST_F(LongWork, PipeGetsNoProgress) {
  const Ran ran = run_hecaton({"simulate", kCells + "three_puma.yaml", "--tasks", "60", "-o", "json"});
  EXPECT_EQ(ran.err.find('\r'), std::string::npos) << ran.err;
  EXPECT_EQ(ran.err.find(" left"), std::string::npos) << ran.err;
  EXPECT_TRUE(Json::parse(ran.out)["interrupted"].is_null());
}

TEST_F(LongWork, ErrorsShowNoFileContents) {
  const std::string line(1'000'000, 'x');
  std::string rubbish;
  for (int i = 0; i < 100'000; ++i) rubbish += static_cast<char>((i * 7919 + i / 251) % 256);
  const std::vector<std::pair<std::string, std::string>> files{
      {"rubbish.yaml", rubbish},
      {"rubbish.urdf", rubbish},
      {"escape.yaml", "name: \"\\" + std::string("\xff") + "\"\n"},
      {"line.yaml", line},
      {"urdf.yaml", "name: a\narms:\n  - {name: b, urdf: " + line + "}\n"},
      {"mesh.urdf", "<robot name='a'><link name='b'/><link name='c'><collision><geometry><mesh filename='package://" +
                        line +
                        "'/></geometry></collision></link><joint name='j' type='revolute'><limit lower='-1' "
                        "upper='1' velocity='1' effort='1'/><parent link='b'/><child link='c'/></joint></robot>"},
  };
  for (const auto& [name, text] : files) {
    std::ofstream(path(name), std::ios::binary) << text;
    const Ran ran = run_hecaton({"check", path(name)});
    EXPECT_EQ(ran.code, 3) << name;
    EXPECT_LT(ran.err.size(), 1500U) << name;
    EXPECT_NO_THROW(static_cast<void>(Json(ran.err).dump())) << name << ": not UTF-8";  // dump() rejects other bytes
  }
}

}  // namespace
}  // namespace hecaton::test
