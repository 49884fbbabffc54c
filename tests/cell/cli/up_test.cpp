/// hecaton up: tasks and their report, and its ends, after which no process is left.

#include <fstream>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include "tests/cell/cli/live_cell.hpp"
#include "tests/support/signal_process.hpp"
#include "tests/support/temporary_folder.hpp"

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

TEST(Up, RefusesAPortThatAnotherProgramHolds) {
  const int listener = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in own{};
  own.sin_family = AF_INET;
  own.sin_addr.s_addr = htonl(INADDR_ANY);
  socklen_t size = sizeof own;
  ASSERT_EQ(::bind(listener, reinterpret_cast<const sockaddr*>(&own), size), 0);
  ASSERT_EQ(::listen(listener, 1), 0);
  ASSERT_EQ(::getsockname(listener, reinterpret_cast<sockaddr*>(&own), &size), 0);
  const std::string port = std::to_string(ntohs(own.sin_port));
  const TemporaryFolder folder;
  const std::string path = (folder.path() / "cell.yaml").string();
  std::ofstream(path) << "name: taken_port\n"
                         "arms:\n"
                         "  - name: north\n"
                         "    robot: ur5e\n"
                         "    device: {type: universal_robots, robot_ip: 127.0.0.1, reverse_port: " +
                             port + "}\n";
  const std::string sentence = "arms[0].device.reverse_port = " + port + " must be a free port of this machine: ";
  const std::string holder = "(process " + std::to_string(getpid()) + ") holds TCP port " + port;

  const FreeDomain domain;
  const Ran up = run_hecaton({"up", path, "--headless", "--domain", std::to_string(domain.number())});
  EXPECT_EQ(up.code, 3);
  EXPECT_NE(up.err.find(sentence), std::string::npos) << up.err;
  EXPECT_NE(up.err.find(holder), std::string::npos) << up.err;
  const Ran check = run_hecaton({"check", path});
  EXPECT_EQ(check.code, 0) << "the file is right: " << check.out;
  EXPECT_NE(check.out.find("warning: "), std::string::npos) << check.out;
  EXPECT_NE(check.out.find(holder), std::string::npos) << check.out;
  ::close(listener);
  EXPECT_EQ(run_hecaton({"check", path}).out.find("must be a free port"), std::string::npos);
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
