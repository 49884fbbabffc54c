// Gripper and signals of a simulated arm: orders, what is announced, and what a restart keeps.

#include "services/arm_driver/tool_control.hpp"

#include <filesystem>

#include <gtest/gtest.h>

#include "services/arm_driver/grasp.hpp"
#include "services/runtime/cause.hpp"
#include "tests/support/gripper_cell.hpp"

namespace hecaton::services {
namespace {

using namespace std::chrono_literals;
using Clock = device::Clock;
using msg::CauseKind;
using msg::DeviceOrder;

constexpr auto kPeriod = 2ms;

/// A device that sets signals at once, or fails.
class PlainDevice : public device::ArmDevice {
 public:
  device::DeviceResult configure() override { return {}; }
  device::DeviceResult activate() override { return {}; }
  device::DeviceState read(Clock::time_point) override { return {}; }
  device::DeviceResult write(const device::JointState&, std::chrono::nanoseconds) override { return {}; }
  void stop(std::string_view) override {}
  void deactivate() override {}
  [[nodiscard]] std::optional<double> signal(std::size_t index) const override { return signals[index]; }
  device::DeviceResult set_signal(std::size_t index, double value) override {
    if (failure) return failure;
    signals[index] = value;
    return {};
  }

  std::array<std::optional<double>, 3> signals{};
  device::DeviceResult failure;
};

/// A device with fingers that something may stop.
class YieldingDevice final : public PlainDevice {
 public:
  [[nodiscard]] std::vector<double> outside() const override {
    return known ? std::vector<double>{finger} : std::vector<double>{};
  }
  device::DeviceResult move_outside(const std::vector<double>& positions, double wanted) override {
    target = positions[0];
    force = wanted;
    return {};
  }
  [[nodiscard]] bool fingers_yield() const override { return true; }
  [[nodiscard]] std::optional<device::OrderEnd> outside_end() override {
    if (!target) return {};
    const double from = finger;
    finger = *std::exchange(target, std::nullopt);
    if (object && (from - *object) * (finger - *object) < 0.0) finger = *object;
    return device::OrderEnd{failure};
  }

  bool known = true;
  double finger = 0.05, force = 0.0;
  std::optional<double> target, object;
};

/// Periods of a driver whose arm stands above the crate.
class Tool : public testing::Test {
 protected:
  void use(const std::string& arm = test::kGripperKeys) {
    file_.emplace(config::load_cell_file(test::write_gripper_cell(folder_, arm)));
    q_ = file_->cell.arms[0].arm.named.at("crate");
    attached_ = {{"crate", false}};
    restart();
  }
  void restart(device::ArmDevice* device = nullptr) {
    control_.reset();
    if (device == nullptr) {
      device_ = make_device(*file_, 0, (folder_.path() / "device").string(), device::device_types());
      device = device_.get();
    }
    control_.emplace(*file_, 0, signal_kinds(*file_, 0), (folder_.path() / "tool").string(), *device);
    period();
  }
  [[nodiscard]] ToolInputs inputs() {
    return {now_,      q_,
            moves_,    stopped_,
            attached_, [this] { return obstacles_ ? file_->cell.scene.obstacles : std::vector<world::Obstacle>(); }};
  }
  /// Plays the world, too: it attaches and detaches what the tool asks for.
  void period() {
    now_ += kPeriod;
    if (device_) (void)device_->read(now_);
    control_->update(inputs());
    control_->write(tool_);
    control_->write(state_);
    if (!world_) return;
    if (!tool_.grasping().empty()) attached_[tool_.grasping()] = true;
    if (!tool_.releasing().empty()) attached_[tool_.releasing()] = false;
  }
  [[nodiscard]] static msg::DeviceRequest request(DeviceOrder order) {
    msg::DeviceRequest request;
    request.order(order);
    return request;
  }
  /// The end of an order: CAUSE_NONE if it was carried out.
  msg::Cause carry_out(const msg::DeviceRequest& request) {
    if (auto refused = control_->begin(request, inputs())) return *refused;
    for (int i = 0; i < 10000; ++i) {
      period();
      if (auto end = control_->end()) {
        period();
        return *end;
      }
    }
    return make_cause(CauseKind::CAUSE_TIME_LIMIT, "", "no end");
  }
  msg::Cause carry_out(DeviceOrder order) { return carry_out(request(order)); }

  test::TemporaryFolder folder_;
  std::optional<config::CellFile> file_;
  std::unique_ptr<device::ArmDevice> device_;
  std::optional<ToolControl> control_;
  Clock::time_point now_{1h};
  planner::JointVector q_;
  bool moves_ = false;
  bool stopped_ = false;
  bool world_ = true;
  bool obstacles_ = true;
  std::map<std::string, bool, std::less<>> attached_;
  msg::ToolState tool_;
  msg::ArmState state_;
};

TEST_F(Tool, ClosesOnWhatIsBetweenTheFingersAndReleasesIt) {
  use();
  EXPECT_EQ(state_.outside_lower(), (std::vector<double>{0.05}));
  EXPECT_DOUBLE_EQ(tool_.width(), 0.1);
  const msg::Cause closed = carry_out(DeviceOrder::DEVICE_CLOSE_TOOL);
  EXPECT_EQ(closed.kind(), CauseKind::CAUSE_NONE) << closed.text();
  EXPECT_EQ(tool_.holding(), "crate");
  EXPECT_TRUE(attached_.at("crate"));
  // The crate is 40 mm wide: each finger stops just before it is at 20 mm.
  EXPECT_GE(state_.outside()[0], 0.02);
  EXPECT_LT(state_.outside()[0], 0.0206);
  EXPECT_LE(state_.outside_lower()[0], state_.outside()[0]);
  EXPECT_GE(state_.outside_upper()[0], state_.outside()[0]);
  EXPECT_LT(state_.outside_upper()[0] - state_.outside_lower()[0], 1.01e-4);

  const msg::Cause again = carry_out(DeviceOrder::DEVICE_CLOSE_TOOL);
  EXPECT_EQ(again.kind(), CauseKind::CAUSE_NOT_ALLOWED_NOW);
  EXPECT_NE(again.text().find("its gripper holds crate: open it first"), std::string::npos) << again.text();

  EXPECT_EQ(carry_out(DeviceOrder::DEVICE_OPEN_TOOL).kind(), CauseKind::CAUSE_NONE);
  EXPECT_EQ(tool_.holding(), "");
  EXPECT_FALSE(attached_.at("crate"));
  EXPECT_DOUBLE_EQ(state_.outside()[0], 0.05);
}

TEST_F(Tool, AnnouncesTheWayOfTheFingersBeforeTheyMove) {
  use();
  const double age = file_->cell.arms[0].parameters.state_age_limit;
  ASSERT_FALSE(control_->begin(request(DeviceOrder::DEVICE_CLOSE_TOOL), inputs()));
  const auto began = now_;
  std::optional<Clock::time_point> moved;
  while (!control_->end()) {
    period();
    if (!moved && state_.outside()[0] < 0.05) moved = now_;
    EXPECT_LE(state_.outside_lower()[0], state_.outside()[0]);
    EXPECT_GE(state_.outside_upper()[0], state_.outside()[0]);
    ASSERT_LT(now_ - began, 20s);
  }
  ASSERT_TRUE(moved);
  EXPECT_GE(std::chrono::duration<double>(*moved - began).count(), age);
}

TEST_F(Tool, ClosesToTheWantedWidth) {
  use();
  obstacles_ = false;
  msg::DeviceRequest close = request(DeviceOrder::DEVICE_CLOSE_TOOL);
  close.width(0.03);
  EXPECT_EQ(carry_out(close).kind(), CauseKind::CAUSE_NONE);
  EXPECT_NEAR(tool_.width(), 0.03, 1e-9);
  EXPECT_EQ(tool_.holding(), "");
  close.width(0.2);
  const msg::Cause wide = carry_out(close);
  EXPECT_EQ(wide.kind(), CauseKind::CAUSE_INVALID_VALUE);
  EXPECT_EQ(wide.text(), "arm north: width = 0.2 m must be at most 0.1 m");
}

TEST_F(Tool, RefusesWhileTheArmMovesOrIsStopped) {
  use();
  moves_ = true;
  EXPECT_EQ(carry_out(DeviceOrder::DEVICE_OPEN_TOOL).text(), "arm north: it moves: wait until it stands");
  moves_ = false;
  stopped_ = true;
  EXPECT_EQ(carry_out(DeviceOrder::DEVICE_OPEN_TOOL).text(), "arm north: it is stopped: resume it first");
  EXPECT_DOUBLE_EQ(state_.outside()[0], 0.05);
}

// What the world has attached for an order that ends before the fingers move stays where it is.
TEST_F(Tool, HoldsNothingWhenItsOrderEndsBeforeTheFingersMove) {
  use();
  for (const auto& [reason, sentence] :
       {std::pair(&stopped_, "arm north: it was stopped before its gripper moved: resume it, then call again"),
        std::pair(&moves_, "arm north: it moves: wait until it stands")}) {
    ASSERT_FALSE(control_->begin(request(DeviceOrder::DEVICE_CLOSE_TOOL), inputs()));
    for (int i = 0; tool_.holding().empty(); ++i) {
      period();
      ASSERT_LT(i, 1000);
    }
    EXPECT_TRUE(attached_.at("crate"));
    *reason = true;
    std::optional<msg::Cause> end;
    for (int i = 0; !end && i < 10000; ++i) {
      period();
      end = control_->end();
    }
    *reason = false;
    ASSERT_TRUE(end) << sentence;
    EXPECT_EQ(end->text(), sentence);
    for (int i = 0; i < 500; ++i) period();
    EXPECT_DOUBLE_EQ(state_.outside()[0], 0.05) << "no finger has moved";
    EXPECT_EQ(state_.outside_lower(), (std::vector<double>{0.05}));
    EXPECT_EQ(tool_.holding(), "");
    EXPECT_FALSE(attached_.at("crate"));
  }
  EXPECT_EQ(carry_out(DeviceOrder::DEVICE_CLOSE_TOOL).kind(), CauseKind::CAUSE_NONE);
  EXPECT_EQ(tool_.holding(), "crate");
  ASSERT_FALSE(control_->begin(request(DeviceOrder::DEVICE_OPEN_TOOL), inputs()));
  period();
  stopped_ = true;
  period();
  EXPECT_TRUE(control_->end());
  EXPECT_EQ(tool_.holding(), "crate") << "it was not opened";
}

TEST_F(Tool, EndsTheOrderWhenTheWorldDoesNotAnswer) {
  use();
  world_ = false;
  const msg::Cause end = carry_out(DeviceOrder::DEVICE_CLOSE_TOOL);
  EXPECT_EQ(end.kind(), CauseKind::CAUSE_NOT_ALLOWED_NOW);
  EXPECT_EQ(end.subject(), "crate");
  EXPECT_EQ(tool_.grasping(), "");
  EXPECT_DOUBLE_EQ(state_.outside()[0], 0.05) << "nothing has moved";
}

TEST_F(Tool, KeepsWhatItHoldsWhenItsProcessIsRestarted) {
  use();
  ASSERT_EQ(carry_out(DeviceOrder::DEVICE_CLOSE_TOOL).kind(), CauseKind::CAUSE_NONE);
  const double position = state_.outside()[0];
  restart();
  for (int i = 0; i < 1000; ++i) period();
  EXPECT_EQ(tool_.holding(), "crate");
  EXPECT_EQ(state_.outside(), (std::vector<double>{position})) << "nothing moves without an order";
  EXPECT_EQ(tool_.grasping() + tool_.releasing(), "");
}

TEST_F(Tool, StaysWhereARestartInterruptsItsMotion) {
  use();
  ASSERT_FALSE(control_->begin(request(DeviceOrder::DEVICE_CLOSE_TOOL), inputs()));
  while (state_.outside()[0] > 0.04) period();
  const double position = state_.outside()[0];
  restart();
  for (int i = 0; i < 1000; ++i) period();
  EXPECT_NEAR(state_.outside()[0], position, 1e-3);
  EXPECT_FALSE(control_->end());
}

TEST_F(Tool, ForgetsWhatAPersonDetaches) {
  use();
  ASSERT_EQ(carry_out(DeviceOrder::DEVICE_CLOSE_TOOL).kind(), CauseKind::CAUSE_NONE);
  attached_["crate"] = false;
  period();
  EXPECT_EQ(control_->holding(), "");
}

TEST_F(Tool, SetsAndReadsSignals) {
  use();
  ASSERT_EQ(tool_.signals().size(), 3U);
  EXPECT_EQ(tool_.signals()[0].name(), "lamp");
  EXPECT_EQ(tool_.signals()[0].kind(), msg::SignalKind::SIGNAL_DIGITAL_OUTPUT);
  msg::DeviceRequest set = request(DeviceOrder::DEVICE_SET_SIGNAL);
  set.name("lamp");
  set.value(1.0);
  EXPECT_EQ(carry_out(set).kind(), CauseKind::CAUSE_NONE);
  EXPECT_EQ(tool_.signals()[0].value(), 1.0);
  set.value(0.5);
  EXPECT_EQ(carry_out(set).text(), "arm north: signal lamp = 0.5 must be 0 or 1: it is digital");
  set.name("lamb");
  const msg::Cause unknown = carry_out(set);
  EXPECT_EQ(unknown.kind(), CauseKind::CAUSE_UNKNOWN_NAME);
  EXPECT_EQ(unknown.text(), "arm north: it has no signal lamb; it has lamp, part, pressure");
  restart();
  EXPECT_EQ(tool_.signals()[0].value(), 1.0) << "the device keeps it";
}

TEST_F(Tool, OpensAndClosesAGripperBySignals) {
  use("    signals: {shut: digital_output 1, wide: digital_output 2}\n"
      "    gripper: {joint: grip, closed: 0, opened: 0.05, close: {shut: 1, wide: 0}, open: {shut: 0, wide: 1}, time: "
      "0.1s}\n");
  EXPECT_EQ(state_.outside_lower()[0], 0.0) << "the device measures no position";
  EXPECT_EQ(state_.outside_upper()[0], 0.05);
  EXPECT_EQ(carry_out(DeviceOrder::DEVICE_CLOSE_TOOL).kind(), CauseKind::CAUSE_NONE);
  EXPECT_EQ(tool_.signals()[0].value(), 1.0);
  EXPECT_EQ(tool_.signals()[1].value(), 0.0);
  EXPECT_EQ(tool_.holding(), "crate");
  EXPECT_EQ(carry_out(DeviceOrder::DEVICE_OPEN_TOOL).kind(), CauseKind::CAUSE_NONE);
  EXPECT_EQ(tool_.signals()[1].value(), 1.0);
  EXPECT_EQ(state_.outside_lower(), (std::vector<double>{0.05}));
  EXPECT_EQ(tool_.holding(), "");

  PlainDevice device;
  device.failure = device::DeviceFailure{"its cable is out"};
  restart(&device);
  const msg::Cause failed = carry_out(DeviceOrder::DEVICE_CLOSE_TOOL);
  EXPECT_EQ(failed.kind(), CauseKind::CAUSE_DEVICE_FAILED);
  EXPECT_EQ(failed.text(), "arm north: its cable is out");
  EXPECT_EQ(tool_.holding(), "") << "no signal was set";
  EXPECT_FALSE(attached_.at("crate"));
}

TEST_F(Tool, ClosesFingersThatYieldAsFarAsTheObjectLetsThem) {
  use();
  YieldingDevice device;
  device.known = false;
  restart(&device);
  EXPECT_EQ(state_.outside_upper()[0] - state_.outside_lower()[0], 0.05) << "the whole range until it is measured";
  device.known = true;
  period();
  EXPECT_EQ(state_.outside_lower(), (std::vector<double>{0.05}));
  device.object = 0.0195;
  msg::DeviceRequest close = request(DeviceOrder::DEVICE_CLOSE_TOOL);
  close.force(12.0);
  const msg::Cause closed = carry_out(close);
  EXPECT_EQ(closed.kind(), CauseKind::CAUSE_NONE) << closed.text();
  EXPECT_EQ(device.force, 12.0);
  EXPECT_EQ(tool_.holding(), "crate");
  EXPECT_NEAR(tool_.width(), 0.039, 1e-9);
  device.object = device.finger = 0.018;  // the object gives way
  period();
  EXPECT_LE(state_.outside_lower()[0], 0.018);
  EXPECT_EQ(carry_out(DeviceOrder::DEVICE_OPEN_TOOL).kind(), CauseKind::CAUSE_NONE);
  EXPECT_EQ(tool_.holding(), "");
}

TEST_F(Tool, HoldsNothingWhenFingersThatYieldMeetNothing) {
  use();
  YieldingDevice device;
  restart(&device);
  const msg::Cause missed = carry_out(DeviceOrder::DEVICE_CLOSE_TOOL);
  EXPECT_EQ(missed.kind(), CauseKind::CAUSE_NOT_ALLOWED_NOW);
  EXPECT_EQ(missed.text(), "arm north: its gripper is closed and holds nothing: crate is not where the cell has it");
  EXPECT_EQ(tool_.holding(), "");
  EXPECT_FALSE(attached_.at("crate"));
  device.object = 0.03;
  const msg::Cause stuck = carry_out(DeviceOrder::DEVICE_OPEN_TOOL);
  EXPECT_EQ(stuck.text(),
            "arm north: its gripper stands at 0.03 instead of 0.05: look whether something stops its fingers");
  device.failure = device::DeviceFailure{"its controller refuses"};
  const msg::Cause failed = carry_out(DeviceOrder::DEVICE_OPEN_TOOL);
  EXPECT_EQ(failed.kind(), CauseKind::CAUSE_DEVICE_FAILED);
  EXPECT_EQ(failed.text(), "arm north: its controller refuses");
}

TEST_F(Tool, TakesThePlaceOfAJointFromAPerson) {
  use("    host: localhost\n");
  EXPECT_EQ(state_.outside_lower(), (std::vector<double>{0.0}));
  EXPECT_EQ(state_.outside_upper(), (std::vector<double>{0.05}));
  msg::DeviceRequest place = request(DeviceOrder::DEVICE_PLACE_JOINT);
  place.name("grip");
  place.value(0.03);
  EXPECT_EQ(carry_out(place).kind(), CauseKind::CAUSE_NONE);
  EXPECT_EQ(state_.outside_lower(), (std::vector<double>{0.03}));
  EXPECT_EQ(state_.outside_upper(), (std::vector<double>{0.03}));
  place.value(0.06);
  const msg::Cause outside = carry_out(place);
  EXPECT_EQ(outside.kind(), CauseKind::CAUSE_INVALID_VALUE);
  EXPECT_EQ(outside.text(), "arm north: joint grip = 0.06 must be within its range, 0 to 0.05");
  place.name("x");
  EXPECT_EQ(carry_out(place).kind(), CauseKind::CAUSE_UNKNOWN_NAME);
  restart();
  EXPECT_EQ(state_.outside_lower(), (std::vector<double>{0.03})) << "the order lasts";
  EXPECT_EQ(carry_out(DeviceOrder::DEVICE_CLOSE_TOOL).kind(), CauseKind::CAUSE_UNKNOWN_NAME) << "there is no gripper";
}

TEST_F(Tool, HoldsOnlyWhatIsBetweenItsFingers) {
  use();
  const planner::Arm& arm = file_->cell.arms[0].arm;
  const std::vector<double> open{0.05};
  const std::vector<double> closed{0.0};
  auto obstacles = file_->cell.scene.obstacles;
  const auto grasp = find_grasp(arm, q_, open, closed, obstacles);
  ASSERT_TRUE(grasp);
  EXPECT_EQ(grasp->obstacle, "crate");
  obstacles[0].X_WO.translation().y() = 0.1;  // beside the open finger
  EXPECT_FALSE(find_grasp(arm, q_, open, closed, obstacles));
  obstacles[0].X_WO.translation() = Eigen::Vector3d(0.3, 0.0, 0.2);  // below the finger tips
  EXPECT_FALSE(find_grasp(arm, q_, open, closed, obstacles));
  obstacles[0].X_WO.translation() = Eigen::Vector3d(0.3, 0.02, 0.3);  // nearer to one finger: that one stops at 40 mm
  const auto shifted = find_grasp(arm, q_, open, closed, obstacles);
  ASSERT_TRUE(shifted);
  EXPECT_NEAR(shifted->positions[0], 0.04, 5e-4);
}

TEST(ToolKeys, AreRefusedWithASentence) {
  const test::TemporaryFolder folder;
  const auto refusal = [&](const std::string& arm) -> std::string {
    try {
      require_known_devices(config::load_cell_file(test::write_gripper_cell(folder, arm)));
    } catch (const std::runtime_error& error) {
      const std::string sentence = error.what();
      return sentence.substr(sentence.find(": ") + 2);
    }
    return "nothing";
  };
  EXPECT_EQ(refusal(test::kGripperKeys), "nothing");
  const auto names = [&](const std::string& arm, const std::string& words) {
    EXPECT_NE(refusal(arm).find(words), std::string::npos) << refusal(arm);
  };
  names("    signals: {lamp: relay 1}\n", "arms[0].signals.lamp = relay 1 must be digital_input");
  names("    gripper: {joint: x, closed: 0, opened: 0.05}\n", "arms[0].gripper.joint = x must be");
  names("    gripper: {joint: grip, closed: 0, opened: 0.06}\n", "arms[0].gripper.opened = 0.06 must be");
  names("    gripper: {joint: grip, closed: 0, opened: 0}\n", "arms[0].gripper.opened = 0 must be another position");
  names("    gripper: {width: 0.1}\n", "arms[0].gripper.joint is missing");
  names("    gripper: {close: {a: 1}, open: {a: 0}}\n", "the arm has no signals");
  names("    signals: {a: digital_input}\n    gripper: {close: {a: 1}, open: {a: 0}}\n", "must be an output");
}

TEST(ToolKeys, DependOnTheTypeOfTheDevice) {
  for (const device::DeviceType& type : device::device_types()) {
    const bool has_signals = type.type == "simulated" || type.type == "universal_robots";
    EXPECT_EQ(type.signal != nullptr, has_signals) << type.type;
    EXPECT_EQ(type.moves_outside, type.type == "simulated" || type.type == "ros2_control") << type.type;
    if (type.type != "universal_robots") continue;
    EXPECT_EQ(type.signal("tool_output 1"), device::SignalKind::kDigitalOutput);
    EXPECT_EQ(type.signal("analog_input 0"), device::SignalKind::kAnalogInput);
    for (const char* port : {"tool_output 2", "tool_output", "tool_output 10", "digital_output 8", "relay 1", ""}) {
      EXPECT_FALSE(type.signal(port)) << port;
    }
  }
}

}  // namespace
}  // namespace hecaton::services
