// The device of a separate program, against a program in this test.
#include "services/arm_driver/devices/program/program_arm.hpp"

#include <functional>
#include <memory>
#include <optional>
#include <thread>

#include <gtest/gtest.h>
#include <idl/device.h>

#include "services/bus/endpoint.hpp"
#include "services/bus/participant.hpp"
#include "tests/support/free_domain.hpp"

namespace hecaton::services {
namespace {

using namespace std::chrono_literals;
using device::DeviceMode;

constexpr auto kSilenceOfProgram = 500ms;
constexpr auto kPatienceWithProgram = 60s;

class ProgramArmTest : public testing::Test {
 protected:
  ProgramArmTest()
      : participant_(domain_.number(), "program"),
        states_(participant_, {.key = "south"}),
        commands_(participant_, nullptr, {.keys = {"south"}}) {
    device::DeviceSetup setup;
    setup.arm = "south";
    setup.limits.lower = device::JointVector::Constant(3, -3.0);
    setup.limits.upper = device::JointVector::Constant(3, 3.0);
    setup.limits.velocity = device::JointVector::Constant(3, 1.0);
    setup.limits.acceleration = device::JointVector::Constant(3, 4.0);
    setup.period = 4ms;
    setup.command_timeout = kSilenceOfProgram;
    setup.join = [this] { return std::make_unique<bus::Participant>(domain_.number(), "device"); };
    device_ = make_program_arm(setup);
    state_.arm("south");
    state_.q({0.1, -0.2, 0.3});
    state_.qd({0.0, 0.0, 0.0});
    state_.mode(msg::DeviceMode::DEVICE_READY);
  }

  /// The device is read, and the program reports `state_`, until the condition holds.
  [[nodiscard]] bool until(const std::function<bool()>& condition) {
    // As fast as a driver and its program: more states than that are refused.
    auto period = device::Clock::now();
    for (const auto end = period + kPatienceWithProgram; period < end;) {
      if (reports_) (void)states_.write(state_);
      read_ = device_->read(device::Clock::now());
      if (active_) {
        EXPECT_FALSE(device_->write(set_point_, 20ms));
      }
      for (auto& sample : commands_.take()) {
        command_ = sample.value;
        if (acts_) state_.session(command_->session());
        if (acts_) state_.sequence_number(command_->sequence_number());
      }
      if (condition()) return true;
      std::this_thread::sleep_until(period += 4ms);
    }
    return false;
  }
  [[nodiscard]] bool until(DeviceMode mode) {
    return until([&] { return read_.mode == mode; });
  }
  [[nodiscard]] bool until(msg::DeviceTask task) {
    return until([&] { return command_ && command_->task() == task; });
  }
  void activate() {
    ASSERT_TRUE(until(DeviceMode::kReady)) << read_.text;
    ASSERT_FALSE(device_->activate());
    set_point_ = read_.measured;
    active_ = true;
    ASSERT_TRUE(until(msg::DeviceTask::DEVICE_FOLLOW));
  }

  test::FreeDomain domain_;
  bus::Participant participant_;
  bus::Writer<msg::DeviceState> states_;
  bus::Reader<msg::DeviceCommand> commands_;
  std::unique_ptr<device::ArmDevice> device_;
  msg::DeviceState state_;
  bool reports_ = true;
  bool acts_ = true;
  bool active_ = false;
  device::JointState set_point_;
  device::DeviceState read_;
  std::optional<msg::DeviceCommand> command_;
};

TEST_F(ProgramArmTest, SendsTasksAndTakesStates) {
  ASSERT_FALSE(device_->configure());
  EXPECT_EQ(device_->read(device::Clock::now()).mode, DeviceMode::kStarting);
  ASSERT_TRUE(until(msg::DeviceTask::DEVICE_MEASURE));
  ASSERT_TRUE(until(DeviceMode::kReady));
  EXPECT_EQ(read_.measured.q, device::JointVector(Eigen::Vector3d(0.1, -0.2, 0.3)));
  const auto session = command_->session();
  activate();
  EXPECT_NE(command_->session(), session);
  EXPECT_EQ(command_->q(), (std::vector<double>{0.1, -0.2, 0.3}));
  EXPECT_DOUBLE_EQ(command_->valid_for(), 0.02);
  active_ = false;
  device_->stop("a light curtain");
  ASSERT_TRUE(until(msg::DeviceTask::DEVICE_STOP));
  EXPECT_EQ(command_->reason(), "a light curtain");
  EXPECT_TRUE(command_->q().empty());
}

TEST_F(ProgramArmTest, ReportsWhyTheProgramCannotMoveTheArm) {
  ASSERT_FALSE(device_->configure());
  state_.mode(msg::DeviceMode::DEVICE_PROTECTIVE_STOP);
  ASSERT_TRUE(until(DeviceMode::kProtectiveStop));
  EXPECT_EQ(read_.text, "its program gives no reason");
  state_.text("the gripper hit the table: release the stop");
  ASSERT_TRUE(until([&] { return read_.text == state_.text(); }));
  EXPECT_EQ(read_.measured.q.size(), 3);
  state_.q().clear();
  state_.qd().clear();
  ASSERT_TRUE(until([&] { return read_.measured.q.size() == 0; }));
  EXPECT_EQ(read_.mode, DeviceMode::kProtectiveStop);
}

TEST_F(ProgramArmTest, FailsForAnotherNumberOfJoints) {
  ASSERT_FALSE(device_->configure());
  state_.q({0.1, -0.2});
  ASSERT_TRUE(until(DeviceMode::kFailed));
  EXPECT_EQ(read_.text, "its program reports 2 positions and 3 velocities; the arm has 3 joints");
}

TEST_F(ProgramArmTest, FailsWhenTheProgramIsSilentOrStuck) {
  ASSERT_FALSE(device_->configure());
  activate();
  acts_ = false;
  ASSERT_TRUE(until(DeviceMode::kFailed));
  EXPECT_TRUE(read_.text.starts_with("its program reports states, but has acted on no command for 500 ms"))
      << read_.text;
  active_ = false;
  acts_ = true;
  device_->stop("failed");
  ASSERT_FALSE(device_->configure());
  activate();
  reports_ = false;
  ASSERT_TRUE(until(DeviceMode::kFailed));
  EXPECT_TRUE(read_.text.starts_with("its program is silent for 500 ms")) << read_.text;
}

TEST_F(ProgramArmTest, SendsNoJump) {
  ASSERT_FALSE(device_->configure());
  activate();
  set_point_.q[1] += 0.5;
  const auto failure = device_->write(set_point_, 20ms);
  ASSERT_TRUE(failure);
  EXPECT_TRUE(failure->text.starts_with("the set-point of joint 2 jumps by 0.5")) << failure->text;
}

}  // namespace
}  // namespace hecaton::services
