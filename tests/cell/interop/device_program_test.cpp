/// A cell in which a separate program moves an arm: examples/device_program, of another DDS vendor.

#include <hecaton/client.hpp>

#include "tests/cell/cli/robot_cell.hpp"
#include "tests/support/signal_process.hpp"

namespace hecaton::test {
namespace {

class DeviceProgram : public RobotCell {
 protected:
  void SetUp() override {
    // A busy machine may stop the program for longer than the default.
    write_cell(
        "name: with_program\n"
        "timing: {command_timeout: 2s, driver_period: 4ms}\n"
        "defaults:\n"
        "  robot: irb120\n"
        "  limits: {velocity: 0.5, acceleration: 6}\n"
        "arms:\n"
        "  - name: north\n"
        "    base: {xyz: [0, 0.7, 0]}\n"
        "    device: {type: program}\n"
        "  - {name: west, base: {xyz: [0.7, -0.4, 0]}}\n");
    start({"0", "0", "0", "0", "1.5708", "0"});
    LiveCell::SetUp();
  }
  void TearDown() override {
    cell_.reset();
    program_.reset();
    RobotCell::TearDown();
  }

  void start(const std::vector<std::string>& positions) {
    std::vector<std::string> words{std::string(HECATON_BIN_DIR) + "/simulated_joints", domain(), "with_program",
                                   "north"};
    words.insert(words.end(), positions.begin(), positions.end());
    program_ = std::make_unique<Process>(words);
  }
  [[nodiscard]] double speed() {
    double fastest = 0.0;
    for (const double qd : cell().arm("north").state(kPatience).qd) fastest = std::max(fastest, std::abs(qd));
    return fastest;
  }
  [[nodiscard]] std::string far_pose() override {
    return cell().arm("north").state(kPatience).q[1] > -0.2 ? "ready" : "home";
  }
  [[nodiscard]] double slow() const override { return 1e-3; }

  /// The arm is on its way; then `event` happens. It is held with a fault of this kind, and its goal has ended.
  void holds_after(const std::function<void()>& event, const std::string& kind) {
    const hecaton::Goal goal = cell().arm("north").go_to(far_pose());
    ASSERT_TRUE(until([&] { return speed() > 0.1; })) << arm();
    event();
    EXPECT_EQ(goal.wait(kPatience).kind, OutcomeKind::kCancelled);
    ASSERT_TRUE(until([&] { return arm()["mode"] == "hold"; })) << arm();
    EXPECT_TRUE(until([&] { return reported(kind); })) << kind << json({"faults"});
  }
  void resumes() {
    ASSERT_TRUE(until([&] { return faults().empty(); })) << faults();
    EXPECT_EQ(arm()["mode"], "hold");
    EXPECT_EQ(run({"resume", "north"}).code, 0);
    ASSERT_TRUE(until([&] { return arm()["state"]["mode"] == "running"; })) << arm();
  }

  [[nodiscard]] Cell& cell() {
    if (!cell_) cell_.emplace(Cell::connect(ConnectOptions{cell_file(), domain_.number()}, kPatience));
    return *cell_;
  }

  std::unique_ptr<Process> program_;
  std::optional<Cell> cell_;
};

TEST_F(DeviceProgram, ReachesGoalsAndStopsUntilAPersonResumes) {
  reach("ready");
  EXPECT_NEAR(arm()["state"]["q"][1].get<double>(), -0.4, 0.01);

  holds_after([&] { program_->signal(SIGKILL); }, "arm_failed");
  std::vector<std::string> there;
  for (int joint = 0; joint < 6; ++joint) there.push_back(joint == 4 ? "1.5708" : "0.1");
  start(there);
  resumes();
  reach("ready");

  // Without a driver the program brakes the arm. A new driver begins where the arm stands.
  const pid_t driver = processes().at("driver/north");
  holds_after([&] { EXPECT_TRUE(signal_process(driver, SIGKILL)); }, "program_stopped");
  ASSERT_TRUE(until([&] { return arm()["driver_alive"].get<bool>(); })) << arm();
  resumes();
  reach("home");
}

class DeviceProgramTest : public testing::Test {
 protected:
  [[nodiscard]] Ran device_test(const std::string& distance) const {
    const std::string path = (folder_.path() / "cell.yaml").string();
    std::ofstream(path) << "name: device_test\n"
                           "timing: {command_timeout: 400ms, driver_period: 4ms}\n"
                           "arms:\n"
                           "  - name: north\n"
                           "    robot: irb120\n"
                           "    limits: {velocity: 0.5, acceleration: 6}\n"
                           "    device: {type: program}\n";
    return run_hecaton({"device-test", path, "north", "--yes", "-o", "json", "--distance", distance, "--duration", "4s",
                        "--domain", std::to_string(domain_.number())});
  }

  TemporaryFolder folder_;
  FreeDomain domain_;
};

TEST_F(DeviceProgramTest, PassesTheExample) {
  const Process program({std::string(HECATON_BIN_DIR) + "/simulated_joints", std::to_string(domain_.number()),
                         "device_test", "north", "0", "0", "0", "0", "1.5708", "0"});
  // A busy machine may stop the program: repeated, as a person would.
  Ran ran;
  for (int tries = 0; tries < 3; ++tries) {
    ran = device_test("0.02");
    if (ran.code == 0) break;
  }
  EXPECT_EQ(ran.code, 0) << ran.out << ran.err;
  const Json report = Json::parse(ran.out, nullptr, false);
  EXPECT_EQ(report["device"], "program");
  ASSERT_EQ(report["checks"].size(), 11U);
  for (const Json& check : report["checks"]) EXPECT_EQ(check["result"], "ok") << check;
}

TEST_F(DeviceProgramTest, FailsWithoutAProgram) {
  const Ran ran = device_test("0.02");
  EXPECT_EQ(ran.code, 1) << ran.err;
  const Json report = Json::parse(ran.out, nullptr, false);
  EXPECT_EQ(report["passed"], false);
  EXPECT_EQ(report["checks"][0]["result"], "failed") << ran.out;
  EXPECT_NE(report["checks"][0]["details"].get<std::string>().find("program"), std::string::npos) << ran.out;
}

}  // namespace
}  // namespace hecaton::test
