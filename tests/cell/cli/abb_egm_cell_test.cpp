/// A cell of a simulated controller of ABB and two simulated arms, from its cell file to its faults.

#include "tests/cell/cli/robot_cell.hpp"
#include "tests/support/signal_process.hpp"

namespace hecaton::test {
namespace {

constexpr double kDegrees = 180.0 / 3.14159265358979;
constexpr int kGuided = 3;

class AbbEgmCell : public RobotCell {
 protected:
  void SetUp() override {
    const std::string port = std::to_string(6600 + domain_.number());
    // A busy machine may stop the simulated controller, or the driver, for longer than the defaults.
    robot_.emplace(std::vector<std::string>{"--to", "127.0.0.1:" + port, "--comm-timeout", "5"}, "abb_controller.py");
    write_cell(
        "name: abb_egm\n"
        "timing: {command_timeout: 2s, driver_period: 4ms}\n"
        "defaults:\n"
        "  robot: irb120\n"
        "  limits: {velocity: 1.5, acceleration: 6}\n"
        "arms:\n"
        "  - name: north\n"
        "    base: {xyz: [0, 0.7, 0]}\n"
        "    device: {type: abb_egm, robot_ip: " +
        robot_->address() + ", port: " + port +
        "}\n"
        "  - {name: west, base: {xyz: [0.7, -0.4, 0]}}\n"
        "  - {name: east, base: {xyz: [-0.7, -0.4, 0]}}\n");
    LiveCell::SetUp();
  }
  [[nodiscard]] std::string far_pose() override {
    return robot_->state()["q"][1].get<double>() > -0.2 * kDegrees ? "ready" : "home";
  }
  [[nodiscard]] double slow() const override { return 0.01; }  // [deg/s]

  /// EGM guides the robot again, and the arm stays held without a person; with `resume` it begins where it stands.
  void resumes() {
    ASSERT_TRUE(until([&] { return faults().empty() && robot_->state()["egm"] == kGuided; })) << faults();
    EXPECT_EQ(arm()["mode"], "hold");
    robot_->order("forget");
    const Json before = robot_->state();
    EXPECT_EQ(run({"resume", "north"}).code, 0);
    ASSERT_TRUE(until([&] { return arm()["state"]["mode"] == "running"; })) << arm();
    ASSERT_TRUE(until([&] { return robot_->state()["first"].is_number(); })) << arm();
    const Json after = robot_->state();
    EXPECT_LT(after["first"].get<double>(), 0.1) << "from where the arm stands [deg]";
    EXPECT_LT(after["largest"].get<double>(), 0.1) << "a step of the set-points [deg]";
    for (int j = 0; j < 6; ++j) EXPECT_NEAR(after["q"][j].get<double>(), before["q"][j].get<double>(), 0.05) << j;
  }
};

TEST_F(AbbEgmCell, ReachesGoalsAndStopsUntilAPersonResumes) {
  reach("ready");
  EXPECT_NEAR(robot_->state()["q"][1].get<double>(), -0.4 * kDegrees, 0.5);
  EXPECT_EQ(robot_->state()["malformed"], 0);

  stops_by([&] { robot_->order("motors off"); }, "device_not_ready");
  robot_->order("motors on");
  robot_->order("program start");
  resumes();
  reach("home");

  stops_by([&] { robot_->order("egm_stop"); }, "program_stopped");
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
