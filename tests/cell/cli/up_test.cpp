/// hecaton up: tasks and their report, and its ends, after which no process is left.

#include <fstream>

#include "tests/cell/cli/live_cell.hpp"
#include "tests/support/signal_process.hpp"

namespace hecaton::test {
namespace {

void expect_gone(const std::vector<Watched>& processes) {
  for (const Watched& process : processes) EXPECT_TRUE(process.wait_for_end());
}

TEST(Up, ReachesTasksAndReports) {
  const std::string report_file = testing::TempDir() + "hecaton_up_" + std::to_string(getpid()) + ".json";
  const FreeDomain domain;
  const Ran ran = run_hecaton({"up", kThreePuma, "--tasks", "6", "--seed", "7", "--headless", "--report", report_file,
                               "--domain", std::to_string(domain.number()), "--start-timeout", "100s"});
  EXPECT_EQ(ran.code, 0) << ran.err;
  EXPECT_NE(ran.out.find("reached"), std::string::npos) << ran.out;
  EXPECT_NE(ran.err.find("round 2:"), std::string::npos) << ran.err;
  std::ifstream file(report_file);
  const Json report = Json::parse(file, nullptr, false);
  ASSERT_TRUE(report.is_object());
  EXPECT_EQ(report["tasks"], 6);
  EXPECT_EQ(report["reached"], 6);
  EXPECT_EQ(report["contacts"], 0);
  EXPECT_GT(report["min_separation_m"].get<double>(), 0.0);
  EXPECT_EQ(report["arms"].size(), 3U);
  EXPECT_TRUE(report["faults"].is_array());
  EXPECT_GE(report["rounds"].get<int>(), 2);
  // World, supervisor, agent, and a driver and a planner for each arm.
  EXPECT_EQ(report["processes"].size(), 9U);
  for (const Json& process : report["processes"]) {
    EXPECT_FALSE(Watched(process["pid"].get<pid_t>()).found()) << process << " is left";
  }
  std::remove(report_file.c_str());
}

class UpLeavesNoProcess : public LiveCell {
 protected:
  [[nodiscard]] std::vector<Watched> watch() const {
    std::vector<Watched> watched;
    for (const auto& [node, pid] : processes()) {
      watched.emplace_back(pid);
      EXPECT_TRUE(watched.back().found()) << node;
    }
    return watched;
  }
  void TearDown() override { up_.reset(); }
};

TEST_F(UpLeavesNoProcess, AfterSigterm) {
  const auto watched = watch();
  up_->signal(SIGTERM);
  EXPECT_EQ(up_->wait(), 0) << up_->err();
  expect_gone(watched);
}

TEST_F(UpLeavesNoProcess, AfterSigkill) {
  const auto watched = watch();
  up_->signal(SIGKILL);
  EXPECT_EQ(up_->wait(), 128 + SIGKILL);
  expect_gone(watched);
}

TEST_F(UpLeavesNoProcess, WhenItsAgentIsKilled) {
  const auto watched = watch();
  ASSERT_TRUE(signal_process(processes().at("agent/localhost"), SIGKILL));
  EXPECT_EQ(up_->wait(), 1) << up_->err();
  EXPECT_NE(up_->err().find("the agent of the cell was ended by signal 9"), std::string::npos) << up_->err();
  expect_gone(watched);
}

}  // namespace
}  // namespace hecaton::test
