// The conformance test of devices, in virtual time: a device with one fault fails exactly the check of this fault.
#include "services/arm_driver/device_test.hpp"

#include <set>

#include <gtest/gtest.h>

#include "services/runtime/periodic_loop.hpp"

namespace hecaton::services {
namespace {

using namespace std::chrono_literals;

constexpr int kTestedJoints = 3;
constexpr std::chrono::nanoseconds kTestPeriod = 2ms;

class VirtualPeriods final : public DriverPeriods {
 public:
  [[nodiscard]] Clock::time_point next() override {
    ++periods;
    due_ = next_deadline(due_, now_, kTestPeriod).at;
    late_ = late_each > 0 && periods % late_each == 0 ? 2 * kTestPeriod : Clock::duration::zero();
    return now_ = std::max(now_, due_);
  }
  [[nodiscard]] Clock::duration late() const override { return late_; }
  [[nodiscard]] Clock::time_point now() const override { return now_; }
  [[nodiscard]] bool ended() const override { return periods >= end_after; }
  /// A call of the device takes time.
  void pass(Clock::duration time) { now_ += time; }

  int periods = 0;
  int late_each = 0;  ///< periods: the machine says that it exceeded every such wait
  int end_after = std::numeric_limits<int>::max();

 private:
  Clock::time_point due_{std::chrono::hours(1)};
  Clock::time_point now_{std::chrono::hours(1)};
  Clock::duration late_{0};
};

device::DeviceSetup setup_of_arm() {
  device::DeviceSetup setup;
  setup.arm = "north";
  setup.limits.lower = device::JointVector::Constant(kTestedJoints, -3.0);
  setup.limits.upper = device::JointVector::Constant(kTestedJoints, 3.0);
  setup.limits.velocity = device::JointVector::Constant(kTestedJoints, 1.0);
  setup.limits.acceleration = device::JointVector::Constant(kTestedJoints, 10.0);
  setup.start = device::JointVector::LinSpaced(kTestedJoints, -2.0, 2.5);
  setup.period = kTestPeriod;
  return setup;
}

/// The simulated arm, with a fault that the test chooses.
class FlawedArm final : public device::ArmDevice {
 public:
  using Clock = device::Clock;

  explicit FlawedArm(VirtualPeriods& periods) : periods_(periods) {
    for (const device::DeviceType& type : device::device_types()) {
      if (type.type == "simulated") arm_ = type.make(setup_of_arm());
    }
  }

  device::DeviceResult configure() override { return {}; }
  device::DeviceResult activate() override {
    if (cannot_activate) return device::DeviceFailure{"the servo amplifier is off"};
    active = true;
    since_activation_ = 0;
    ++activations;
    offset_ += jump;
    return arm_->activate();
  }
  device::DeviceState read(Clock::time_point now) override {
    periods_.pass(read_takes);
    if (++since_activation_ == stalls_at && activations == 1) periods_.pass(40ms);
    if (stalls_each > 0 && active && since_activation_ % stalls_each == 0) periods_.pass(20ms);
    if (runs_on && active && last_ && !written_) {
      last_->q += last_->qd * 0.002;
      static_cast<void>(arm_->write(*last_, 12ms));
    }
    written_ = false;
    device::DeviceState state = arm_->read(now);
    states_.push_back(state.measured);
    if (lag > 0) {
      state.measured = states_[states_.size() > lag ? states_.size() - 1 - lag : 0];
    }
    if (drifts_from > 0 && activations == 2 && active && since_activation_ > drifts_from) drift_ += 2e-5;
    if (drifts_when_off && !active && activations == 2) drift_ += 2e-5;
    state.measured.q.array() += offset_ + drift_;
    state.age = age;
    if (starts_silently && active && since_activation_ < 50) state.mode = device::DeviceMode::kStarting;
    if (stops_after > 0 && activations > 0 && since_activation_ > stops_after) {
      state.mode = device::DeviceMode::kProtectiveStop;
      state.text = "joint 2: torque";
    }
    if (measured_joints < kTestedJoints) {
      state.measured.q.conservativeResize(measured_joints);
      state.measured.qd.conservativeResize(measured_joints);
    }
    if (off) {
      state.mode = device::DeviceMode::kNotReady;
      state.text = "switch it on";
    }
    return state;
  }
  device::DeviceResult write(const device::JointState& set_point, std::chrono::nanoseconds valid_for) override {
    device::JointState executed = set_point;
    if (cannot_brake && last_ && (last_->qd.cwiseAbs() - set_point.qd.cwiseAbs()).maxCoeff() > 0.004) {
      executed = {last_->q + last_->qd * 0.002, last_->qd};
    }
    last_ = executed;
    last_speed = set_point.qd.cwiseAbs().maxCoeff();
    executed.q.array() -= offset_;
    written_ = true;
    return arm_->write(executed, valid_for);
  }
  void stop(std::string_view reason) override {
    active = false;
    last_.reset();
    arm_->stop(reason);
  }
  void deactivate() override {
    active = false;
    last_.reset();
    arm_->deactivate();
  }

  Clock::duration read_takes{0};
  std::chrono::nanoseconds age{0};
  int stalls_at = 0;    ///< period after the first activation in which the machine stalls
  int stalls_each = 0;  ///< periods
  std::size_t lag = 0;  ///< in periods
  double jump = 0.0;    ///< at each activation [rad]
  int stops_after = 0;  ///< periods after an activation
  int drifts_from = 0;  ///< periods after the second activation
  bool drifts_when_off = false;
  bool runs_on = false;  ///< without set-points
  bool cannot_brake = false;
  bool cannot_activate = false;
  bool starts_silently = false;  ///< without a text
  bool off = false;
  int measured_joints = kTestedJoints;

  bool active = false;
  int activations = 0;
  double last_speed = 0.0;  ///< of a joint in the last set-point [rad/s]

 private:
  VirtualPeriods& periods_;
  std::unique_ptr<device::ArmDevice> arm_;
  std::vector<device::JointState> states_;
  std::optional<device::JointState> last_;
  bool written_ = false;
  int since_activation_ = 0;
  double offset_ = 0.0;  ///< of the joints, which the device knows [rad]
  double drift_ = 0.0;   ///< which it does not know [rad]
};

class DeviceTestTest : public testing::Test {
 protected:
  void run(double distance = 0.05) {
    const auto arm = setup_of_arm();
    DeviceTestSetup setup{{"north", arm.limits, 0.05, kTestPeriod, 12ms}};
    setup.distance = distance;
    report_ = test_device(setup, device_, periods_);
    EXPECT_FALSE(device_.active) << "deactivated at the end";
  }
  [[nodiscard]] const DeviceCheck& check(const std::string& name) const {
    for (const DeviceCheck& one : report_.checks) {
      if (one.name == name) return one;
    }
    throw std::runtime_error("no check " + name);
  }
  /// Names of the checks with this result.
  [[nodiscard]] std::set<std::string> with(CheckResult result) const {
    std::set<std::string> names;
    for (const DeviceCheck& one : report_.checks) {
      if (one.result == result) names.insert(one.name);
    }
    return names;
  }
  void expect_failed(const std::string& name) {
    run();
    EXPECT_EQ(with(CheckResult::kFailed), std::set<std::string>{name});
    EXPECT_FALSE(report_.passed());
  }
  using Names = std::set<std::string>;

  VirtualPeriods periods_;
  FlawedArm device_{periods_};
  DeviceTestReport report_;
};

TEST_F(DeviceTestTest, PassesTheSimulatedArm) {
  run();
  EXPECT_TRUE(report_.passed());
  EXPECT_EQ(report_.tested(), 11);
  for (const DeviceCheck& one : report_.checks) {
    EXPECT_EQ(one.result, CheckResult::kOk) << one.name << ": " << one.measured << " " << one.details;
  }
  // At 0.05 π / 2 s = 0.0785 rad/s and 10 rad/s² a stop takes 8 ms: after 50 ms of silence, or after 12 ms.
  EXPECT_NEAR(check("commands_cease").limit, 0.050 + 0.00785 + 0.004, 1e-4);
  EXPECT_NEAR(check("writes_cease").limit, 0.012 + 0.00785 + 0.004, 1e-4);
  EXPECT_GT(check("commands_cease").measured, 0.0);
  EXPECT_GT(check("writes_cease").measured, 0.0);
  EXPECT_NEAR(check("tracking").limit, 0.0785 * 0.002 + 0.001, 1e-5);
  EXPECT_EQ(device_.activations, 2);
}

TEST_F(DeviceTestTest, FailsADeviceWhoseCallsAreTooSlow) {
  device_.read_takes = 3ms;
  expect_failed("period");
  EXPECT_NEAR(check("period").measured, 0.003, 1e-6);
  EXPECT_EQ(with(CheckResult::kNotTested), Names{});
}

TEST_F(DeviceTestTest, LeavesOutAsManyCallsAsThisMachineInterruptsWaits) {
  device_.stalls_each = 50;  // 2 % of the calls
  run();
  EXPECT_EQ(check("period").result, CheckResult::kFailed) << "of a machine that exceeds no wait";
}

TEST_F(DeviceTestTest, PassesADeviceOnAMachineThatStallsInWaitsAsWell) {
  device_.stalls_each = 50;
  periods_.late_each = 40;
  run();
  EXPECT_EQ(check("period").result, CheckResult::kOk) << check("period").details;
  EXPECT_NEAR(check("period").limit, 0.002, 1e-9) << "the limit stays";
}

TEST_F(DeviceTestTest, FailsASlowDeviceAlsoOnAMachineThatStalls) {
  device_.read_takes = 3ms;
  periods_.late_each = 4;
  run();
  EXPECT_EQ(check("period").result, CheckResult::kFailed);
}

TEST_F(DeviceTestTest, DoesNotCountAStallOfThisMachine) {
  device_.stalls_at = 600;  // in the motion of the first joint
  run(0.4);                 // at 0.25 rad/s the stop of the device during the stall is an error of more than 3 mrad
  EXPECT_TRUE(report_.passed());
  EXPECT_LT(check("tracking").measured, 1e-3);
  EXPECT_NEAR(report_.longest_gap, 0.040, 1e-6);
}

TEST_F(DeviceTestTest, MeasuresBetweenManyStallsOfThisMachine) {
  device_.stalls_each = 50;  // eight times a second
  run(0.1);
  EXPECT_EQ(check("tracking").result, CheckResult::kOk) << check("tracking").details;
  EXPECT_LT(check("tracking").measured, 1e-3);
}

TEST_F(DeviceTestTest, FailsADeviceThatLagsBetweenManyStallsOfThisMachine) {
  device_.stalls_each = 50;
  device_.lag = 20;
  run();
  EXPECT_EQ(check("tracking").result, CheckResult::kFailed);
  EXPECT_GT(check("tracking").measured, 1e-3) << check("tracking").details;
}

TEST_F(DeviceTestTest, MeasuresNothingDuringStallsWithoutEnd) {
  device_.stalls_each = 1;
  run();
  EXPECT_EQ(check("tracking").result, CheckResult::kFailed);
  EXPECT_EQ(check("tracking").details, "this machine stalls too often to measure it");
}

TEST_F(DeviceTestTest, FailsADeviceThatLagsWithoutSayingSo) {
  device_.lag = 20;
  expect_failed("tracking");
  EXPECT_NEAR(check("tracking").measured, 0.0785 * 0.040, 2e-4) << "40 ms at the highest speed";
  EXPECT_EQ(check("commands_cease").result, CheckResult::kNotTested) << "a failed motion is the last one";
}

TEST_F(DeviceTestTest, FailsADeviceThatRunsOnWithoutSetPoints) {
  device_.runs_on = true;
  expect_failed("writes_cease");
  EXPECT_GT(check("writes_cease").measured, 0.4);
}

TEST_F(DeviceTestTest, FailsADeviceThatDoesNotBrake) {
  device_.cannot_brake = true;
  expect_failed("commands_cease");
  EXPECT_EQ(check("writes_cease").result, CheckResult::kNotTested);
}

TEST_F(DeviceTestTest, FailsADeviceThatJumpsWhenItIsActivated) {
  device_.jump = 0.005;
  expect_failed("activation");
  EXPECT_NEAR(check("activation").measured, 0.005, 1e-9);
  EXPECT_EQ(check("tracking").result, CheckResult::kNotTested);
}

TEST_F(DeviceTestTest, FailsADeviceThatCannotBeActivated) {
  device_.cannot_activate = true;
  expect_failed("activation");
  EXPECT_EQ(check("activation").details, "the servo amplifier is off");
}

TEST_F(DeviceTestTest, FailsADeviceWithOldStates) {
  device_.age = 60ms;
  expect_failed("state_age");
  EXPECT_NEAR(check("state_age").measured, 0.060, 1e-9);
  EXPECT_EQ(check("measures").result, CheckResult::kOk);
}

TEST_F(DeviceTestTest, FailsADeviceThatStops) {
  device_.stops_after = 500;
  expect_failed("states");
  EXPECT_EQ(check("states").details, "joint 2: torque");
  EXPECT_EQ(check("tracking").result, CheckResult::kNotTested);
}

TEST_F(DeviceTestTest, FailsADeviceThatSaysNotWhyItIsNotReady) {
  device_.starts_silently = true;
  expect_failed("states");
  EXPECT_EQ(check("states").details, "a state that is not ready has no text");
  EXPECT_EQ(with(CheckResult::kNotTested), Names{});
}

TEST_F(DeviceTestTest, FailsADeviceThatDoesNotMeasureEveryJoint) {
  device_.measured_joints = 2;
  expect_failed("measures");
  EXPECT_EQ(check("measures").details, "the device measures 2 positions and 2 velocities, but the arm has 3 joints");
  EXPECT_EQ(report_.tested(), 1);
}

TEST_F(DeviceTestTest, FailsADeviceThatStaysOff) {
  device_.off = true;
  expect_failed("measures");
  EXPECT_EQ(check("measures").details, "switch it on");
  EXPECT_EQ(device_.activations, 0);
}

TEST_F(DeviceTestTest, FailsADeviceThatMovesByItself) {
  device_.drifts_from = 260;  // after the half second that follows its activation
  expect_failed("stale_lease");
}

TEST_F(DeviceTestTest, FailsADeviceThatMovesAfterTheTest) {
  device_.drifts_when_off = true;
  expect_failed("rest");
  EXPECT_EQ(with(CheckResult::kNotTested), Names{});
}

TEST_F(DeviceTestTest, StopsTheArmWhenAPersonEndsTheTest) {
  periods_.end_after = 750;  // 1.5 s: in the motion of the first joint
  run();
  EXPECT_FALSE(report_.passed());
  EXPECT_EQ(with(CheckResult::kFailed), Names{});
  EXPECT_EQ(check("activation").result, CheckResult::kOk);
  EXPECT_EQ(check("tracking").result, CheckResult::kNotTested);
  EXPECT_LT(device_.last_speed, 1e-3) << "on the stop profile of the driver";
  EXPECT_LT(periods_.periods, 800);
}

TEST_F(DeviceTestTest, RefusesToMoveAJointBetweenNarrowLimits) {
  const auto arm = setup_of_arm();
  DeviceTestSetup setup{{"north", arm.limits, 0.05, kTestPeriod, 12ms}};
  setup.control.limits.lower[1] = arm.start[1] - 0.04;
  setup.control.limits.upper[1] = arm.start[1] + 0.03;
  report_ = test_device(setup, device_, periods_);
  EXPECT_EQ(with(CheckResult::kFailed), Names{"tracking"});
  EXPECT_EQ(check("tracking").details, "joint 2 has no 0.05 rad (m) to move between its limits");
  EXPECT_EQ(device_.activations, 0);
}

}  // namespace
}  // namespace hecaton::services
