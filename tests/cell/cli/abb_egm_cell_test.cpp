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

/// A YuMi: two arms of one robot, which sends two streams from one address.
class AbbTwoArmCell : public RobotCell {
 protected:
  void SetUp() override {
    const int port = 6700 + 2 * domain_.number();
    robot_.emplace(options(port, "135"), "abb_controller.py");
    other_.emplace(options(port + 1, "-135"), "abb_controller.py");
    const auto arm_with = [&](const std::string& name, const std::string& tool, int to) {
      return "  - {name: " + name + ", robot: yumi, tool_link: " + tool +
             ", limits: {velocity: 1.2, acceleration: 6}, device: {type: abb_egm, robot_ip: " + kRobot +
             ", port: " + std::to_string(to) + "}}\n";
    };
    write_cell(
        "name: yumi_egm\n"
        "timing: {command_timeout: 2s, driver_period: 4ms}\n"
        "arms:\n" +
        arm_with("north", "left_tool0", port) + arm_with("south", "right_tool0", port + 1));
    LiveCell::SetUp();
  }
  void TearDown() override {
    RobotCell::TearDown();
    other_.reset();
  }
  /// The third joint of the arm is the additional axis of the controller.
  static std::vector<std::string> options(int port, const std::string& third_joint) {
    return {"--to",           "127.0.0.1:" + std::to_string(port),
            "--robot",        "yumi",
            "--from",         kRobot,
            "--start",        "0,-130,30,0,40,0",
            "--external",     third_joint,
            "--comm-timeout", "5"};
  }
  [[nodiscard]] std::string far_pose() override {
    return robot_->state()["q"][0].get<double>() > -10.0 ? "ready" : "home";
  }
  [[nodiscard]] double slow() const override { return 0.01; }  // [deg/s]
  [[nodiscard]] Json south() const { return entry(json({"arms"}), "name", "south"); }

  static constexpr const char* kRobot = "127.0.0.121";
  std::optional<RobotSimulator> other_;  ///< of the arm south
};

TEST_F(AbbTwoArmCell, MovesBothArmsAndHoldsTheOneThatStops) {
  for (const char* pose : {"ready", "home"}) {
    const auto second = start({"goal", "south", "--named", pose, "--wait", "--time-limit", "60s"});
    reach(pose);
    EXPECT_EQ(second->wait(), 0) << second->err() << south();
    const double first_joint = pose == std::string("ready") ? -0.5 * kDegrees : 0.0;
    EXPECT_NEAR(robot_->state()["q"][0].get<double>(), first_joint, 0.5);
    EXPECT_NEAR(other_->state()["q"][0].get<double>(), -first_joint, 0.5) << "each arm has its own stream";
  }
  for (RobotSimulator* robot : {&*robot_, &*other_}) {
    EXPECT_EQ(robot->state()["malformed"], 0) << robot->state();
    EXPECT_EQ(robot->state()["unknown_senders"], 0) << robot->state();
  }

  stops_by([&] { robot_->order("egm_stop"); }, "program_stopped");
  EXPECT_EQ(south()["mode"], "run") << "the other arm goes on";
  const Ran goes_on = run({"goal", "south", "--named", "ready", "--wait", "--time-limit", "60s"});
  EXPECT_EQ(goes_on.code, 0) << goes_on.out << goes_on.err << south();
  ASSERT_TRUE(until([&] { return faults().empty(); })) << faults();
  robot_->order("forget");
  EXPECT_EQ(run({"resume", "north"}).code, 0);
  ASSERT_TRUE(until([&] { return robot_->state()["first"].is_number(); })) << arm();
  EXPECT_LT(robot_->state()["first"].get<double>(), 0.1) << "from where the arm stands [deg]";
  reach("home");
  for (const Json& fault : json({"faults"})) EXPECT_NE(fault["kind"], "contact") << fault;
}

}  // namespace
}  // namespace hecaton::test
