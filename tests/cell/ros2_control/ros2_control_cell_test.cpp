/// A cell of an arm with simulated controllers of ros2_control and two simulated arms, from its cell file to its
/// faults.

#include "tests/cell/cli/robot_cell.hpp"
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
        "  limits: {velocity: 1.5, acceleration: 6}\n"
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

INSTANTIATE_TEST_SUITE_P(Interfaces, Ros2ControlCell, testing::Values("position", "trajectory"),
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

}  // namespace
}  // namespace hecaton::test
