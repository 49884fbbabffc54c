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
    {
      const Ran resumed = run({"resume", "north"});
      EXPECT_EQ(resumed.code, 0) << resumed.err << resumed.out << json({"faults"});
    }
    ASSERT_TRUE(until([&] { return robot_->state()["runtime_state"] == 2; })) << arm();
    ASSERT_TRUE(until([&] { return arm()["state"]["mode"] == "running"; })) << arm();
    ASSERT_TRUE(until([&] { return robot_->state()["first"].is_number(); })) << arm();
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
  EXPECT_NE(refused.err.find("arm west: a simulated arm is always on"), std::string::npos) << refused.err;
}

TEST_F(UniversalRobotsCell, LeavesAnArmToAPersonAndTakesItBack) {
  reach("ready");
  ASSERT_EQ(run({"goal", "north", "--named", "home"}).code, 0);
  const Ran observe = run({"device", "north", "observe"});
  ASSERT_EQ(observe.code, 0) << observe.err;
  ASSERT_TRUE(until([&] { return arm()["state"]["mode"] == "observed"; })) << arm();
  EXPECT_EQ(run({"wait", "north", "--for", "cancelled", "--timeout", "60s"}).code, 0);
  ASSERT_TRUE(until([&] { return robot_->state()["runtime_state"] == 1; })) << "no program runs";
  robot_->order("remote_control off");

  const Ran refused = run({"goal", "north", "--named", "home", "--wait"});
  EXPECT_EQ(refused.code, 1);
  EXPECT_NE(refused.out.find("others move it"), std::string::npos) << refused.err << refused.out;

  // The person swings the robot towards the arms that work. Its driver dies and still commands nothing.
  const std::vector<double> there{0.4, -1.2, 1.2, -1.5, -1.5, 0.3};
  robot_->order("jog 0.4 -1.2 1.2 -1.5 -1.5 0.3");
  for (const char* named : {"ready", "home"}) {
    for (const char* other : {"west", "east"}) {
      const Ran ran = run({"goal", other, "--named", named, "--wait", "--time-limit", "60s"});
      EXPECT_EQ(ran.code, 0) << ran.out << ran.err;
    }
    EXPECT_TRUE(signal_process(static_cast<pid_t>(processes().at("driver/north")), SIGKILL));
    ASSERT_TRUE(until([&] {
      const Json now = arm();
      return now["driver_alive"].get<bool>() && now["state"]["mode"] == "observed" && faults().empty();
    })) << arm();
    EXPECT_EQ(robot_->state()["runtime_state"], 1);
  }
  ASSERT_TRUE(until([&] { return robot_speed() < slow(); }));
  const Json measured = arm()["state"]["q"];
  for (int j = 0; j < 6; ++j) EXPECT_NEAR(measured[j].get<double>(), there[j], 1e-2) << j;
  for (const Json& fault : json({"faults"})) EXPECT_NE(fault["kind"], "contact") << fault;

  robot_->order("remote_control on");
  robot_->order("forget");
  ASSERT_EQ(run({"device", "north", "command"}).code, 0);
  EXPECT_EQ(run({"device", "north", "command"}).code, 1) << "it is commanded already";
  // On a busy machine the simulated controller may have stopped for so long that the arm is held.
  EXPECT_TRUE(until([&] { return run({"resume", "north"}).code == 0; })) << json({"faults"});
  ASSERT_TRUE(until([&] { return arm()["state"]["mode"] == "running"; })) << arm();
  ASSERT_TRUE(until([&] { return robot_->state()["first"].is_number(); })) << arm();
  EXPECT_LT(robot_->state()["first"].get<double>(), 1e-4);
  reach("home");
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
