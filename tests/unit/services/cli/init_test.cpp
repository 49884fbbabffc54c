// `hecaton init` and `hecaton robots`.

#include <filesystem>
#include <fstream>
#include <sstream>

#include <gtest/gtest.h>

#include "services/cli/cell_draft.hpp"
#include "services/command_line/document.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/unit/services/cli/run_line.hpp"

namespace hecaton::services::cli {
namespace {

namespace fs = std::filesystem;

/// A folder for the files of one test.
class InitTest : public testing::Test {
 protected:
  [[nodiscard]] std::string path(const std::string& name) const { return folder_.path(name); }
  [[nodiscard]] std::string content(const std::string& name) const {
    std::ifstream file(path(name));
    return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  }

 private:
  test::TemporaryFolder folder_;
};

TEST_F(InitTest, WritesACellThatChecksDrawsTasksAndSimulates) {
  const std::string cell = path("pair.yaml");
  const Ran init = run_line({"init", "-o", cell, "left=xarm6@-0.45 0 0", "right=xarm6@0.45 0 0 0 0 3.14"});
  ASSERT_EQ(init.code, ExitCode::kDone) << init.err;
  EXPECT_NE(init.out.find("next: hecaton check " + cell), std::string::npos) << init.out;
  EXPECT_TRUE(content("pair.yaml").starts_with("# A cell of Hecaton")) << content("pair.yaml");
  const Ran check = run_line({"check", cell});
  EXPECT_EQ(check.code, ExitCode::kDone) << check.err << check.out;
  EXPECT_NE(check.out.find("next: hecaton simulate " + cell), std::string::npos) << check.out;
  const Ran simulate = run_line({"simulate", cell, "--tasks", "4", "-o", "json"});
  ASSERT_NE(simulate.code, ExitCode::kBadInput) << simulate.err;
  EXPECT_EQ(Json::parse(simulate.out)["contacts"], 0);
}

TEST_F(InitTest, LeavesAnExistingFileAsItIs) {
  std::ofstream(path("cell.yaml")) << "mine\n";
  const Ran ran = run_line({"init", "-o", path("cell.yaml"), "left=ur5e"});
  EXPECT_EQ(ran.code, ExitCode::kBadInput);
  EXPECT_NE(ran.err.find("exists already"), std::string::npos) << ran.err;
  EXPECT_EQ(content("cell.yaml"), "mine\n");
}

TEST_F(InitTest, FindsPosesForAUrdfWithoutAny) {
  fs::copy_file(std::string(HECATON_SOURCE_DIR) + "/deploy/cells/urdf/puma560.urdf", path("arm.urdf"));
  const Ran ran = run_line({"init", "-o", path("cell.yaml"), "left=" + path("arm.urdf")});
  ASSERT_EQ(ran.code, ExitCode::kDone) << ran.err;
  const std::string text = content("cell.yaml");
  EXPECT_NE(text.find("urdf: 'arm.urdf'"), std::string::npos) << "relative to the cell file: " << text;
  EXPECT_NE(text.find("home: ["), std::string::npos) << text;
  EXPECT_NE(text.find("pose_sequence: [home, ready]"), std::string::npos) << "one arm has no conflicts: " << text;
  EXPECT_EQ(run_line({"check", path("cell.yaml")}).code, ExitCode::kDone);
}

TEST_F(InitTest, FindsOtherPosesWhereHomesMeet) {
  // Both UR5e reach 0.49 m along their −x at home, into the other arm.
  const Ran ran = run_line({"init", "-o", path("cell.yaml"), "left=ur5e@-0.3 0 0 0 0 3.14159", "right=ur5e@0.3 0 0"});
  ASSERT_EQ(ran.code, ExitCode::kDone) << ran.err;
  EXPECT_NE(content("cell.yaml").find("poses:"), std::string::npos) << content("cell.yaml");
  EXPECT_EQ(run_line({"check", path("cell.yaml")}).code, ExitCode::kDone);
}

TEST_F(InitTest, RejectsWhatIsNoArm) {
  struct Case {
    const char* word;
    const char* piece;
  };
  for (const Case& one : {Case{"ur5e", "must be NAME=ROBOT@"}, Case{"left=ur5", "did you mean 'ur5e'?"},
                          Case{"left=ur5e@1 2", "must be NAME=ROBOT@"}, Case{"=ur5e", "must be NAME=ROBOT@"},
                          Case{"left=ur5e@1 2 x", "must be NAME=ROBOT@"}, Case{"left=ur5e@1e9 0 0", "within ±100"}}) {
    const Ran ran = run_line({"init", "-o", path("cell.yaml"), one.word});
    EXPECT_EQ(ran.code, ExitCode::kBadInput) << one.word;
    EXPECT_NE(ran.err.find(one.piece), std::string::npos) << one.word << ": " << ran.err;
    EXPECT_FALSE(fs::exists(path("cell.yaml")));
  }
}

TEST_F(InitTest, RejectsTwoArmsOfOneName) {
  const Ran ran = run_line({"init", "-o", path("cell.yaml"), "a=ur5e@0 0 0", "a=ur5e@2 0 0"});
  EXPECT_EQ(ran.code, ExitCode::kBadInput);
  EXPECT_NE(ran.err.find("two arms have the name a"), std::string::npos) << ran.err;
}

TEST(AskForArms, AsksAgainAfterAnAnswerThatIsNoArm) {
  std::istringstream in("left\nur5e\n-0.5 0 0\nright\npanda\n0.5 0\nright\npanda\n\n\n");
  std::ostringstream out;
  const std::vector<std::string> arms = ask_for_arms(in, out);
  ASSERT_EQ(arms.size(), 2U) << out.str();
  EXPECT_EQ(parse_draft_arm(arms[0]).base[0], -0.5);
  EXPECT_EQ(parse_draft_arm(arms[1]).robot, "panda");
  EXPECT_EQ(parse_draft_arm(arms[1]).base, std::vector<double>(6, 0.0));
  EXPECT_NE(out.str().find("must be NAME=ROBOT@"), std::string::npos);
}

TEST(AskForArms, FailsWhenTheInputEnds) {
  std::istringstream in("left\n");
  std::ostringstream out;
  EXPECT_THROW(static_cast<void>(ask_for_arms(in, out)), Failure);
}

TEST(Robots, ListsFiguresSourcesAndWhatIsApproximate) {
  const Json robots = Json::parse(run_line({"robots", "-o", "json"}).out)["robots"];
  ASSERT_GE(robots.size(), 26U);
  for (const Json& robot : robots) {
    EXPECT_GT(robot["reach_m"].get<double>(), 0.0) << robot["name"];
    EXPECT_GT(robot["payload_kg"].get<double>(), 0.0) << robot["name"];
    EXPECT_FALSE(robot["sources"].empty()) << robot["name"];
    EXPECT_FALSE(robot["approximate"].empty()) << robot["name"];
    for (const Json& tool : robot["tools"]) {
      EXPECT_EQ(tool["joints"].size(), tool["poses"]["home"].size()) << robot["name"];
    }
  }
  const std::string table = run_line({"robots"}).out;
  EXPECT_NE(table.find("ABB YuMi"), std::string::npos) << table;
  EXPECT_NE(table.find("7 + 7"), std::string::npos) << table;
}

TEST(Robots, StandInForAUrdfInCommands) {
  const Ran check = run_line({"check", "ur5e"});
  EXPECT_EQ(check.code, ExitCode::kDone) << check.err;
  EXPECT_NE(check.out.find("robot ur5e: 6 joints"), std::string::npos) << check.out;
  const Ran plan = run_line({"plan", "xarm6", "--from", "home", "--to", "ready", "-o", "json"});
  EXPECT_EQ(plan.code, ExitCode::kDone) << plan.err;
  const Ran unknown = run_line({"check", "ur5"});
  EXPECT_EQ(unknown.code, ExitCode::kBadInput);
  EXPECT_NE(unknown.err.find("did you mean 'ur5e'?"), std::string::npos) << unknown.err;
}

}  // namespace
}  // namespace hecaton::services::cli
