/// A cell of a simulated controller of Universal Robots and two simulated arms, from its cell file to its faults.

#include "tests/cell/cli/robot_cell.hpp"
#include "tests/support/signal_process.hpp"

namespace hecaton::test {
namespace {

class UniversalRobotsCell : public RobotCell {
 protected:
  void SetUp() override {
    robot_.emplace(std::vector<std::string>{"--unlock-after", "0.2", "--start", "0,-1.5708,1.5708,-1.5708,-1.5708,0"});
    write_cell(
        "name: universal_robots\n"
        // A busy machine may stop the simulated controller for longer than the default.
        "timing: {command_timeout: 400ms}\n"
        "defaults:\n"
        "  robot: ur5e\n"
        "  limits: {velocity: 1.5, acceleration: 6}\n"
        "arms:\n"
        "  - name: north\n"
        "    base: {xyz: [0, 0.9, 0]}\n"
        // The same of the driver.
        "    device: {type: universal_robots, timeout: 0.4s, robot_ip: " +
        robot_->address() + ", reverse_port: " + std::to_string(50100 + domain_.number()) +
        "}\n"
        "  - {name: west, base: {xyz: [0.8, -0.4, 0]}}\n"
        "  - {name: east, base: {xyz: [-0.8, -0.4, 0]}}\n");
    LiveCell::SetUp();
  }
  [[nodiscard]] std::string far_pose() override {
    return robot_->state()["q"][1].get<double>() > -1.8 ? "ready" : "home";
  }
  [[nodiscard]] double slow() const override { return 1e-4; }  // [rad/s]

  /// Without a person the arm stays held and the robot gets no program; with `resume` it begins where it stands.
  void resumes() {
    ASSERT_TRUE(until([&] { return faults().empty(); })) << faults();
    const Json before = robot_->state();
    EXPECT_EQ(arm()["mode"], "hold");
    EXPECT_EQ(before["runtime_state"], 1) << "no program runs";
    robot_->order("forget");
    EXPECT_EQ(run({"resume", "north"}).code, 0);
    ASSERT_TRUE(until([&] { return robot_->state()["runtime_state"] == 2; })) << arm();
    ASSERT_TRUE(until([&] { return arm()["state"]["mode"] == "running"; })) << arm();
    const Json after = robot_->state();
    EXPECT_LT(after["first"].get<double>(), 1e-4);
    for (int j = 0; j < 6; ++j) EXPECT_NEAR(after["q"][j].get<double>(), before["q"][j].get<double>(), 1e-3) << j;
  }
};

TEST_F(UniversalRobotsCell, ReachesGoalsAndStopsUntilAPersonResumes) {
  reach("ready");
  EXPECT_NEAR(robot_->state()["q"][1].get<double>(), -2.1, 0.01);
  EXPECT_EQ(robot_->state()["ignored"], 0);

  stops_by([&] { robot_->order("protective_stop"); }, "protective_stop");
  EXPECT_TRUE(until([&] { return run({"device", "north", "unlock"}).code == 0; }));
  resumes();
  reach("home");

  stops_by([&] { robot_->order("stop_program"); }, "program_stopped");
  resumes();

  const pid_t driver = processes().at("driver/north");
  stops_by([&] { EXPECT_TRUE(signal_process(driver, SIGKILL)); }, "program_stopped");
  ASSERT_TRUE(until([&] { return arm()["driver_alive"].get<bool>() && faults().empty(); })) << arm();
  resumes();
  reach("ready");

  const Ran refused = run({"device", "west", "on"});
  EXPECT_EQ(refused.code, 1);
  EXPECT_NE(refused.err.find("arm west: its device takes no orders"), std::string::npos) << refused.err;
}

TEST_F(UniversalRobotsCell, SlowsDownWithTheSpeedSlider) {
  reach("ready");
  robot_->order("slider 0.2");
  robot_->order("forget");
  reach("home");
  EXPECT_LT(robot_->state()["fastest"].get<double>(), 0.2 * 1.5 * 1.1);
  EXPECT_LT(robot_->state()["largest"].get<double>(), 0.01);
}

}  // namespace
}  // namespace hecaton::test
