// hecaton device-test on the simulated arm and on a simulated controller of Universal Robots.
#include <fstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/cell/cli/process.hpp"
#include "tests/support/robot_simulator.hpp"
#include "tests/support/temporary_folder.hpp"

namespace hecaton::test {
namespace {

using Json = nlohmann::json;

class DeviceTestCommand : public testing::Test {
 protected:
  std::string cell(const std::string& device) {
    const std::string path = (folder_.path() / "cell.yaml").string();
    std::ofstream(path)
        << "name: device_test\n"
           // A busy machine may stop the test, or the simulated controller, for longer than the default.
           "timing: {command_timeout: 400ms}\n"
           "arms:\n"
           "  - name: north\n"
           "    robot: ur5e\n"
           "    limits: {velocity: 1.5, acceleration: 6}\n"
           "    device: {" +
               device + "}\n";
    return path;
  }
  static void expect_passed(const Ran& ran) {
    EXPECT_EQ(ran.code, 0) << ran.out << ran.err;
    const Json report = Json::parse(ran.out, nullptr, false);
    EXPECT_EQ(report["passed"], true) << ran.out;
    EXPECT_EQ(report["checks"].size(), 11U);
    for (const Json& check : report["checks"]) EXPECT_EQ(check["result"], "ok") << check;
  }

  TemporaryFolder folder_;
};

TEST_F(DeviceTestCommand, PassesTheSimulatedArm) {
  expect_passed(run_hecaton({"device-test", cell("type: simulated"), "north", "-o", "json", "--duration", "1s"}));
}

TEST_F(DeviceTestCommand, PassesASimulatedControllerOfUniversalRobots) {
  RobotSimulator robot({"--start", "0,-1.5708,1.5708,-1.5708,-1.5708,0"});
  const std::string path =
      cell("type: universal_robots, timeout: 0.4s, robot_ip: " + robot.address() + ", reverse_port: 50399");
  const Ran refused = run_hecaton({"device-test", path, "north"});
  EXPECT_EQ(refused.code, 2) << refused.err;
  EXPECT_NE(refused.err.find("call 'hecaton device-test' with --yes, or on a terminal"), std::string::npos)
      << refused.err;
  // A simulated controller that stalls lags behind, and its states are old: repeated, as a person would on a busy
  // machine.
  Ran ran;
  for (int tries = 0; tries < 3; ++tries) {
    ran = run_hecaton({"device-test", path, "north", "--yes", "-o", "json", "--distance", "0.02", "--duration", "4s"});
    const Json report = Json::parse(ran.out, nullptr, false);
    if (ran.code == 0 || report["checks"][1]["measured"].get<double>() < 0.03) break;
  }
  expect_passed(ran);
  EXPECT_NE(ran.err.find("arm north moves now: each joint by 0.02 rad (m)"), std::string::npos) << ran.err;
  EXPECT_EQ(robot.state()["runtime_state"], 1) << "no program runs";
}

TEST_F(DeviceTestCommand, FailsWhenTheDeviceDoesNotConnect) {
  const std::string path = cell("type: universal_robots, robot_ip: 127.0.0.1, reverse_port: 50399");
  // So slow that a simulated controller that stalls for 60 ms is still close enough: 0.02 π / 5 s · 60 ms < 1 mrad.
  const Ran ran =
      run_hecaton({"device-test", path, "north", "--yes", "-o", "json", "--distance", "0.02", "--duration", "5s"});
  EXPECT_EQ(ran.code, 1) << ran.err;
  const Json report = Json::parse(ran.out, nullptr, false);
  EXPECT_EQ(report["passed"], false);
  EXPECT_EQ(report["checks"][0]["result"], "failed") << ran.out;
  EXPECT_NE(report["checks"][0]["details"], "");
}

TEST_F(DeviceTestCommand, PrintsWhatIsDoneWhenAPersonEndsIt) {
  Process test({std::string(HECATON_BIN_DIR) + "/hecaton", "device-test", cell("type: simulated"), "north"},
               Process::Stderr::kTerminal);
  ASSERT_TRUE(test.wait_for_message("moves joint 1")) << test.err();
  test.signal(SIGINT);
  EXPECT_EQ(test.wait(), 130);
  EXPECT_NE(test.out().find("begins where it stands"), std::string::npos) << test.out();
  EXPECT_NE(test.out().find("not tested"), std::string::npos) << test.out();
  EXPECT_NE(test.err().find("interrupted by SIGINT"), std::string::npos) << test.err();
}

TEST_F(DeviceTestCommand, RefusesUnknownArmsAndObservedArms) {
  const Ran unknown = run_hecaton({"device-test", cell("type: simulated"), "south"});
  EXPECT_EQ(unknown.code, 3);
  EXPECT_NE(unknown.err.find("ARM = south must be an arm of "), std::string::npos) << unknown.err;
  const Ran observed = run_hecaton({"device-test", cell("type: observed, source: simulated"), "north"});
  EXPECT_EQ(observed.code, 3);
  EXPECT_NE(observed.err.find("others move arm north"), std::string::npos) << observed.err;
}

}  // namespace
}  // namespace hecaton::test
