/// A cell of an arm with simulated controllers of ros2_control and two simulated arms, from its cell file to its
/// faults.

#include "tests/cell/cli/robot_cell.hpp"
#include "tests/support/gripper_cell.hpp"
#include "tests/support/signal_process.hpp"

namespace hecaton::test {
namespace {

class Ros2ControlCell : public RobotCell, public testing::WithParamInterface<std::string> {
 protected:
  void SetUp() override {
    std::string joints;
    for (int joint = 1; joint <= 6; ++joint)
      joints += (joint > 1 ? ",north_joint_" : "north_joint_") + std::to_string(joint);
    const std::string ros_domain = std::to_string(ros_domain_.number());
    robot_.emplace(
        std::vector<std::string>{"--domain", ros_domain, "--kind", GetParam(), "--joints", joints, "--others",
                                 "west_joint_1,finger", "--start", "0,0,0,0,1.5708,0", "--from-desired"},
        "ros2_controller");
    // A busy machine may stop the simulated controller, or the driver, for longer than the defaults.
    write_cell(
        "name: ros2_control\n"
        "timing: {command_timeout: 2s, driver_period: 4ms}\n"
        "defaults:\n"
        "  robot: irb120\n"
        "  limits: {velocity: " +
        // Without a driver it goes on until the next one has started.
        std::string(GetParam() == "velocity" ? "0.3" : "1.5") +
        ", acceleration: 6}\n"
        "arms:\n"
        "  - name: north\n"
        "    base: {xyz: [0, 0.7, 0]}\n"
        "    device: {type: ros2_control, interface: " +
        GetParam() + ", joint_prefix: north_, domain: " + ros_domain +
        "}\n"
        "  - {name: west, base: {xyz: [0.7, -0.4, 0]}}\n"
        "  - {name: east, base: {xyz: [-0.7, -0.4, 0]}}\n");
    LiveCell::SetUp();
  }
  [[nodiscard]] std::string far_pose() override {
    return robot_->state()["q"][1].get<double>() > -0.2 ? "ready" : "home";
  }
  [[nodiscard]] double slow() const override { return 2e-4; }  // [rad/s]

  /// The robot is ready, and the arm stays held without a person; with `resume` it begins where it stands.
  void resumes() {
    ASSERT_TRUE(until([&] { return faults().empty() && robot_->state()["active"] == true; })) << faults();
    EXPECT_EQ(arm()["mode"], "hold");
    robot_->order("forget");
    const Json before = robot_->state();
    EXPECT_EQ(run({"resume", "north"}).code, 0);
    ASSERT_TRUE(until([&] { return arm()["state"]["mode"] == "running"; })) << arm();
    ASSERT_TRUE(until([&] { return robot_->state()["commands"] > 0; }));
    const Json after = robot_->state();
    EXPECT_LT(after["first"].get<double>(), 2e-3) << "a step of the set-points [rad]";
    for (int j = 0; j < 6; ++j) EXPECT_NEAR(after["q"][j].get<double>(), before["q"][j].get<double>(), 2e-3) << j;
  }

  FreeDomain ros_domain_;
};

INSTANTIATE_TEST_SUITE_P(Interfaces, Ros2ControlCell, testing::Values("position", "velocity", "trajectory", "action"),
                         [](const auto& test) { return test.param; });

TEST_P(Ros2ControlCell, ReachesGoalsAndStopsUntilAPersonResumes) {
  reach("ready");
  EXPECT_NEAR(robot_->state()["q"][1].get<double>(), -0.4, 0.01);
  EXPECT_EQ(robot_->state()["refused"], 0) << robot_->state();

  stops_by([&] { robot_->order("deactivate"); }, "program_stopped");
  robot_->order("activate");
  resumes();
  reach("home");

  stops_by([&] { robot_->order("restart 4"); }, "arm_failed");
  resumes();

  const pid_t driver = processes().at("driver/north");
  stops_by([&] { EXPECT_TRUE(signal_process(driver, SIGKILL)); }, "program_stopped");
  ASSERT_TRUE(until([&] { return arm()["driver_alive"].get<bool>(); })) << arm();
  resumes();
  reach("ready");

  const Ran refused = run({"device", "north", "on"});
  EXPECT_EQ(refused.code, 1);
  EXPECT_NE(refused.err.find("arm north: its device takes no orders"), std::string::npos) << refused.err;
}

/// An arm on slides whose gripper and axes have controllers of ros2_control.
class Ros2GripperCell : public RobotCell, public testing::WithParamInterface<std::string> {
 protected:
  void SetUp() override {
    const std::string ros_domain = std::to_string(ros_domain_.number());
    robot_.emplace(std::vector<std::string>{"--domain", ros_domain, "--kind", "action", "--joints", "x,y,z", "--start",
                                            "0,0,0.7", "--from-desired", "--gripper", GetParam(), "--finger", "grip"},
                   "ros2_controller");
    (void)write_gripper_cell(
        folder_,
        "    gripper: {joint: grip, closed: 0, opened: 0.05, width: 0.1}\n    device: {type: ros2_control, "
        "interface: action, gripper_controller: gripper_controller, gripper_interface: " +
            GetParam() + ", domain: " + ros_domain + "}\n");
    LiveCell::SetUp();
  }
  [[nodiscard]] std::string far_pose() override { return "away"; }
  [[nodiscard]] double slow() const override { return 2e-4; }  // [m/s]
  [[nodiscard]] Json crate() const { return entry(json({"obstacles"}), "name", "crate"); }

  FreeDomain ros_domain_;
};

INSTANTIATE_TEST_SUITE_P(Interfaces, Ros2GripperCell, testing::Values("action", "position"),
                         [](const auto& test) { return test.param; });

TEST_P(Ros2GripperCell, TakesACrateAndPutsItDown) {
  reach("crate");
  robot_->order("object 0.02");  // the crate is 40 mm wide
  const Json closed = json({"tool", "north", "close"});
  EXPECT_EQ(closed.value("holding", ""), "crate") << closed;
  EXPECT_NEAR(closed["width"].get<double>(), 0.04, 1e-3);
  EXPECT_EQ(crate()["attached_to"], "north") << crate();
  EXPECT_EQ(arm()["tool"]["holding"], "crate") << "in the status";
  EXPECT_EQ(robot_->state()["effort"], GetParam() == "action" ? 10.0 : -1.0);

  reach("lifted");
  const Json opened = json({"tool", "north", "open"});
  EXPECT_TRUE(opened["holding"].is_null()) << opened;
  EXPECT_NEAR(opened["width"].get<double>(), 0.1, 3e-3);
  EXPECT_TRUE(crate()["attached_to"] == "") << crate();
}

TEST_P(Ros2GripperCell, HoldsNothingWhenTheFingersMeetNothing) {
  reach("crate");
  const Ran missed = run({"tool", "north", "close"});
  EXPECT_EQ(missed.code, 1);
  EXPECT_NE(missed.err.find("its gripper is closed and holds nothing: crate is not where the cell has it"),
            std::string::npos)
      << missed.err;
  EXPECT_TRUE(crate()["attached_to"] == "") << crate();

  robot_->order("object 0.03");
  const Ran stuck = run({"tool", "north", "open"});
  EXPECT_EQ(stuck.code, 1);
  EXPECT_NE(stuck.err.find("its gripper stands at 0.03 instead of 0.05"), std::string::npos) << stuck.err;
  robot_->order("gripper off");
  const Ran inactive = run({"tool", "north", "close"});
  EXPECT_EQ(inactive.code, 1);
  EXPECT_NE(inactive.err.find("/gripper_controller"), std::string::npos) << inactive.err;
}

class Ros2ControlDeviceTest : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Interfaces, Ros2ControlDeviceTest, testing::Values("action", "velocity"),
                         [](const auto& test) { return test.param; });

TEST_P(Ros2ControlDeviceTest, Passes) {
  const TemporaryFolder folder;
  const FreeDomain ros_domain;
  const std::string domain = std::to_string(ros_domain.number());
  RobotSimulator robot(
      {"--domain", domain, "--kind", GetParam(), "--joints", "joint_1,joint_2,joint_3,joint_4,joint_5,joint_6",
       "--start", "0,0,0,0,1.5708,0", "--from-desired"},
      "ros2_controller");
  const std::string path = (folder.path() / "cell.yaml").string();
  std::ofstream(path) << "name: device_test\n"
                         "timing: {command_timeout: 1s}\n"
                         "arms:\n"
                         "  - name: north\n"
                         "    robot: irb120\n"
                         "    limits: {velocity: 1.5, acceleration: 6}\n"
                         "    device: {type: ros2_control, interface: " +
                             GetParam() + ", domain: " + domain + "}\n";
  // A busy machine may stop the simulated controller: repeated, as a person would.
  Ran ran;
  for (int tries = 0; tries < 3; ++tries) {
    ran = run_hecaton({"device-test", path, "north", "--yes", "-o", "json", "--distance", "0.02", "--duration", "4s"});
    if (ran.code == 0) break;
  }
  EXPECT_EQ(ran.code, 0) << ran.out << ran.err;
  EXPECT_EQ(robot.state()["refused"], 0) << robot.state();
  EXPECT_GT(robot.state()["commands"].get<int>(), 20) << robot.state();
}

}  // namespace
}  // namespace hecaton::test
