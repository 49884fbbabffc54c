/// The examples of examples/client against a running cell.

#include <cstdlib>

#include "tests/cell/cli/live_cell.hpp"
#include "tests/support/signal_process.hpp"

namespace hecaton::test {
namespace {

class ClientExamples : public LiveCell {
 protected:
  void SetUp() override {
    setenv("HECATON_DOMAIN", domain().c_str(), 1);
    LiveCell::SetUp();
  }
  void TearDown() override {
    LiveCell::TearDown();
    unsetenv("HECATON_DOMAIN");
  }
  [[nodiscard]] static std::unique_ptr<Process> example(const std::string& name, std::vector<std::string> words) {
    words.insert(words.begin(), std::string(HECATON_BIN_DIR) + "/example_" + name);
    return std::make_unique<Process>(words);
  }
};

TEST_F(ClientExamples, TenLinesReachesBothGoals) {
  const auto program = example("ten_lines", {kThreePuma});
  EXPECT_EQ(program->wait(), 0) << program->err();
  EXPECT_EQ(program->out(), "north: reached\nwest: reached\n") << program->err();
}

TEST_F(ClientExamples, ProgressFollowsAGoalThroughAHold) {
  const auto program = example("progress", {kThreePuma, "north", "ready"});
  EXPECT_EQ(program->wait(), 0) << program->err();
  EXPECT_NE(program->out().find("held: the outcome is still"), std::string::npos) << program->out();
  EXPECT_NE(program->out().find("\nreached\n"), std::string::npos) << program->out();
}

TEST_F(ClientExamples, FaultsReportsAKilledPlanner) {
  const auto program = example("faults", {kThreePuma});
  ASSERT_TRUE(program->wait_for_output("listening to cell three_puma")) << program->err();
  ASSERT_TRUE(signal_process(processes().at("planner/north"), SIGKILL));
  EXPECT_TRUE(program->wait_for_output("fault: planner/north")) << program->out() << program->err();
}

}  // namespace
}  // namespace hecaton::test
