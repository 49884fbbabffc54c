#include "services/arm_driver/arm_control.hpp"

#include <deque>

#include <gtest/gtest.h>

namespace hecaton::services {
namespace {

using namespace std::chrono_literals;
using device::DeviceMode;
using msg::ArmMode;
using msg::CauseKind;

constexpr std::chrono::nanoseconds kPeriod = 2ms;
constexpr double kTimeout = 0.050;  // [s]

planner::JointLimits limits() {
  planner::JointLimits limits;
  limits.lower = planner::JointVector::Constant(1, -3.0);
  limits.upper = planner::JointVector::Constant(1, 3.0);
  limits.velocity = planner::JointVector::Constant(1, 1.0);
  limits.acceleration = planner::JointVector::Constant(1, 10.0);
  return limits;
}

/// The simulated arm, with failures that the test sets.
class FaultyArm final : public device::ArmDevice {
 public:
  using Clock = device::Clock;

  explicit FaultyArm(device::DeviceSetup setup) {
    for (const device::DeviceType& type : device::device_types()) {
      if (type.type == "simulated") arm_ = type.make(setup);
    }
  }

  device::DeviceResult configure() override {
    ++configured;
    return configure_fails;
  }
  device::DeviceResult activate() override {
    active = true;
    first_write = true;
    if (starts_slowly) mode = DeviceMode::kStarting;
    return arm_->activate();
  }
  device::DeviceState read(Clock::time_point now) override {
    ++reads;
    device::DeviceState state = arm_->read(now);
    state.mode = mode;
    state.text = text;
    state.age = age;
    if (trembles > 0.0) state.measured.qd[0] += trembles * (reads % 2 == 0 ? 1.0 : -1.0);
    if (measures_nan) state.measured.qd[0] = NAN;
    if (sticks) state.measured = measured.measured;
    return measured = state;
  }
  device::DeviceResult write(const planner::JointState& set_point, std::chrono::nanoseconds valid_for) override {
    if (std::exchange(first_write, false)) first_set_point = set_point.q[0];
    EXPECT_TRUE(active);
    written = set_point;
    const auto failed = arm_->write(set_point, valid_for);
    return write_fails ? write_fails : failed;
  }
  void stop(std::string_view reason) override {
    stopped_for = reason;
    arm_->stop(reason);
  }
  void deactivate() override {
    active = false;
    arm_->deactivate();
  }

  [[nodiscard]] double tracking_delay() const override { return delay; }

  device::DeviceResult configure_fails, write_fails;
  DeviceMode mode = DeviceMode::kReady;
  std::string text;
  std::chrono::nanoseconds age{0};
  bool measures_nan = false;
  double trembles = 0.0;  ///< noise of the measured velocity [rad/s]
  bool starts_slowly = false;
  bool sticks = false;  ///< reports the same position for ever
  double delay = 0.0;   ///< [s]
  bool active = false;
  bool first_write = false;
  double first_set_point = NAN;
  int configured = 0;
  int reads = 0;
  std::string stopped_for;
  device::DeviceState measured;
  planner::JointState written;

 private:
  std::unique_ptr<ArmDevice> arm_;
};

class ArmControlTest : public testing::Test {
 protected:
  /// One period of the driver.
  void period(std::chrono::nanoseconds late = 0ns) {
    now_ += kPeriod + late;
    control_.read(now_);
    control_.set_hold(may_run_ ? std::nullopt : std::optional(cause_), for_device_);
    if (command_) last_ = control_.command(*command_);
    command_.reset();
    control_.write();
  }
  void send(std::uint64_t term = 1) {
    command_ = msg::ArmCommand();
    command_->node("planner/arm1");
    command_->term(term);
    command_->sequence_number(++sequence_);
    command_->period(0.01);
    command_->q({q_});
    command_->qd({0.5});
  }
  /// Commands of a planner that moves at 0.5 rad/s, one every 10 ms.
  void plan(std::uint64_t term = 1) {
    q_ += 0.005;
    send(term);
    for (int k = 0; k < 5; ++k) period();
  }
  void wait(double seconds) {
    for (double t = 0.0; t < seconds - 1e-9; t += 0.002) period();
  }
  void run() {
    may_run_ = true;
    cause_ = {};
    for (int k = 0; k < 100; ++k) plan();
    ASSERT_EQ(control_.mode(), ArmMode::ARM_RUNNING);
  }
  /// The supervisor holds the arm for the fault of its device, and a person resumes it.
  void resume() {
    may_run_ = false;
    for_device_ = true;
    cause_ = make_cause(CauseKind::CAUSE_HELD_BY_FAULT, "arm1", "a fault of the device");
    period();
    EXPECT_FALSE(device_.active);
    may_run_ = true;
    for_device_ = false;
    period();
    period();
  }
  [[nodiscard]] double q() const { return control_.measured().q[0]; }
  [[nodiscard]] CauseKind kind() const { return control_.cause().kind(); }
  [[nodiscard]] std::string text() const { return control_.cause().text(); }

  FaultyArm device_{{"arm1", limits(), planner::JointVector::Zero(1), kPeriod, "", "", {}}};
  ArmControl control_{{"arm1", limits(), kTimeout, kPeriod, 12ms, {}}, device_};
  device::Clock::time_point now_{std::chrono::hours(1)};
  bool may_run_ = false;
  bool for_device_ = false;
  msg::Cause cause_ = make_cause(CauseKind::CAUSE_MODE_UNKNOWN, "arm1", "no cell mode received yet");
  std::optional<msg::ArmCommand> command_;
  Judgement last_;
  double q_ = 0.0;
  std::uint64_t sequence_ = 0;
};

TEST_F(ArmControlTest, HoldsTheArmUntilACellModeArrives) {
  for (int k = 0; k < 20; ++k) plan();
  EXPECT_EQ(control_.mode(), ArmMode::ARM_STARTING);
  EXPECT_EQ(q(), 0.0);
  EXPECT_EQ(kind(), CauseKind::CAUSE_MODE_UNKNOWN);
  EXPECT_EQ(control_.gate().sequence(), 20U) << "but acknowledges its planner's commands";
}

TEST_F(ArmControlTest, BrakesWhenCommandsStop) {
  may_run_ = true;
  period();
  EXPECT_EQ(kind(), CauseKind::CAUSE_STARTING);
  run();
  EXPECT_EQ(kind(), CauseKind::CAUSE_NONE);
  EXPECT_NEAR(control_.measured().qd[0], 0.5, 1e-2);
  wait(0.030);
  EXPECT_EQ(control_.mode(), ArmMode::ARM_RUNNING) << "10 + 30 ms without a command are within 50 ms";
  wait(0.014);
  EXPECT_EQ(control_.mode(), ArmMode::ARM_BRAKING);
  EXPECT_EQ(kind(), CauseKind::CAUSE_COMMANDS_CEASED);
  EXPECT_EQ(text(), "commands ceased: none for more than 50 ms");
  wait(0.054);  // 0.5 rad/s at 10 rad/s² take 50 ms, and the measurement is a period old
  EXPECT_EQ(control_.mode(), ArmMode::ARM_STOPPED);
  EXPECT_EQ(control_.measured().qd[0], 0.0);
}

// The driver logs the cause in the period in which its mode changes.
TEST_F(ArmControlTest, SaysInTheFirstPeriodOfBrakingThatCommandsCeased) {
  run();
  for (int k = 0; k < 100 && control_.mode() == ArmMode::ARM_RUNNING; ++k) period();
  EXPECT_EQ(control_.mode(), ArmMode::ARM_BRAKING);
  EXPECT_EQ(kind(), CauseKind::CAUSE_COMMANDS_CEASED) << text();
}

// From every state on the stop profile, the arm comes to rest q̇ T/2 further, T = |q̇| / (10 rad/s²).
TEST_F(ArmControlTest, BrakesOnTheStopProfile) {
  run();
  std::vector<planner::JointState> states;
  while (control_.mode() != ArmMode::ARM_STOPPED) {
    ASSERT_LT(states.size(), 200U);
    period();
    if (control_.mode() == ArmMode::ARM_BRAKING) states.push_back(control_.measured());
  }
  ASSERT_GT(states.size(), 3U);
  for (const auto& [at, speed] : states) EXPECT_NEAR(at[0] + speed[0] * speed[0] / 20.0, q(), 1e-4);
}

TEST_F(ArmControlTest, BrakesAndIgnoresCommandsWhileHeld) {
  run();
  may_run_ = false;
  cause_ = make_cause(CauseKind::CAUSE_HOLD_ORDERED, "arm1", "the cell is held: door");
  plan();
  EXPECT_EQ(control_.mode(), ArmMode::ARM_BRAKING);
  EXPECT_EQ(control_.cause(), cause_);
  for (int k = 0; k < 20; ++k) plan();
  EXPECT_EQ(control_.mode(), ArmMode::ARM_STOPPED);
  const double stands = q();
  may_run_ = true;
  wait(0.1);
  EXPECT_EQ(q(), stands) << "an old command has no effect";
  q_ = stands;
  plan();
  EXPECT_EQ(control_.mode(), ArmMode::ARM_RUNNING);
}

TEST_F(ArmControlTest, BrakesWhenTheSetPointIsFarFromTheArm) {
  run();
  q_ += 0.07;  // more than 1 rad/s · (50 + 10) ms, with the 5 ms of the next command
  plan();
  EXPECT_EQ(last_.verdict, Verdict::kTooFar);
  EXPECT_EQ(control_.mode(), ArmMode::ARM_BRAKING);
  EXPECT_EQ(kind(), CauseKind::CAUSE_COMMAND_TOO_FAR);
  EXPECT_EQ(text(), "the set-point is too far from the arm: joint 1 measured at 0.500, set-point 0.575");
  wait(0.1);
  EXPECT_EQ(control_.mode(), ArmMode::ARM_STOPPED);
  EXPECT_GT(control_.command_age(), 0.1) << "the command is not accepted";
  q_ = q();
  plan();
  EXPECT_EQ(control_.mode(), ArmMode::ARM_RUNNING);
  EXPECT_EQ(kind(), CauseKind::CAUSE_NONE);
}

TEST_F(ArmControlTest, ComparesAnOldMeasurementWithTheCommandThen) {
  run();
  plan();
  period();
  const double age = control_.command_age_when_measured();
  EXPECT_NEAR(age, control_.command_age(), 1e-9);
  device_.age = 30ms;
  period();
  EXPECT_NEAR(control_.command_age_when_measured(), control_.command_age() - 0.030, 1e-9);
  EXPECT_LT(control_.command_age_when_measured(), 0.0) << "the command came after the measurement";
}

TEST_F(ArmControlTest, BrakesWhenOnlyCommandsOfAnOlderTermArrive) {
  run();
  control_.observe_lease({{}, 2});
  for (int k = 0; k < 20; ++k) plan(1);
  EXPECT_EQ(control_.mode(), ArmMode::ARM_STOPPED);
  EXPECT_EQ(control_.gate().stale_rejected(), 20U);
  EXPECT_EQ(control_.gate().term(), 1U);
  EXPECT_EQ(control_.cause(), last_.cause);
  EXPECT_EQ(kind(), CauseKind::CAUSE_COMMAND_REFUSED);
}

TEST_F(ArmControlTest, ReportsAFailedDeviceAndHoldsTheArm) {
  run();
  device_.mode = DeviceMode::kFailed;
  device_.text = "joint 3: overcurrent";
  period();
  EXPECT_EQ(control_.mode(), ArmMode::ARM_FAILED);
  EXPECT_EQ(control_.cause(), make_cause(CauseKind::CAUSE_DEVICE_FAILED, "arm1",
                                         "joint 3: overcurrent; once it works again, call 'hecaton resume arm1'"));
  EXPECT_EQ(device_.stopped_for, "joint 3: overcurrent");
  EXPECT_FALSE(device_.active);
  EXPECT_EQ(control_.measured().q.size(), 1) << "the last measurement is still reported";
  for (int k = 0; k < 10; ++k) plan();
  EXPECT_EQ(last_.verdict, Verdict::kAccepted) << "the command is accepted, but the arm stands";
  EXPECT_EQ(control_.mode(), ArmMode::ARM_FAILED);
}

// From 0.5 rad/s with 10 rad/s² it goes 12.5 mrad further.
TEST_F(ArmControlTest, LetsAFailedDeviceStopItsArm) {
  run();
  device_.mode = DeviceMode::kFailed;
  device_.text = "no joint states";
  period();
  const double before = q();
  wait(0.1);
  EXPECT_EQ(device_.configured, 1) << "it is configured again only later";
  EXPECT_EQ(device_.measured.measured.qd[0], 0.0) << "it brakes in read()";
  EXPECT_NEAR(q(), before + 0.0125, 0.0015) << "other arms learn where it is";
  EXPECT_EQ(control_.mode(), ArmMode::ARM_FAILED);
  EXPECT_EQ(text(), "no joint states; once it works again, call 'hecaton resume arm1'");
}

TEST_F(ArmControlTest, ReadsNoDeviceThatIsNotConfigured) {
  device_.configure_fails = device::DeviceFailure{"no such address"};
  wait(0.1);
  EXPECT_EQ(device_.reads, 0);
  device_.configure_fails.reset();
  wait(1.0);
  run();
  device_.configure_fails = device::DeviceFailure{"no such address"};
  device_.mode = DeviceMode::kFailed;
  period();
  wait(1.1);
  const int before = device_.reads;
  wait(0.1);
  EXPECT_EQ(device_.reads, before) << "it cannot be reached any more";
}

TEST_F(ArmControlTest, StartsARecoveredDeviceAtTheMeasuredPosition) {
  run();
  device_.mode = DeviceMode::kFailed;
  period();
  device_.mode = DeviceMode::kReady;
  wait(0.9);
  EXPECT_EQ(control_.mode(), ArmMode::ARM_FAILED) << "configured again after a second";
  EXPECT_EQ(device_.configured, 1);
  wait(0.2);
  EXPECT_EQ(device_.configured, 2);
  EXPECT_EQ(control_.mode(), ArmMode::ARM_STOPPED);
  EXPECT_FALSE(device_.active) << "held until a person resumes";
  EXPECT_EQ(kind(), CauseKind::CAUSE_DEVICE_FAILED);
  resume();
  EXPECT_EQ(device_.first_set_point, q());
  q_ = q();
  plan();
  EXPECT_EQ(control_.mode(), ArmMode::ARM_RUNNING);
}

TEST_F(ArmControlTest, FailsWhenTheDeviceCannotBeConfigured) {
  device_.configure_fails = device::DeviceFailure{"/dev/ttyUSB0: No such file or directory"};
  wait(2.5);
  EXPECT_EQ(control_.mode(), ArmMode::ARM_FAILED);
  EXPECT_EQ(kind(), CauseKind::CAUSE_DEVICE_FAILED);
  EXPECT_EQ(text(), "/dev/ttyUSB0: No such file or directory");
  EXPECT_EQ(control_.measured().q.size(), 0) << "no position is invented";
  EXPECT_EQ(device_.configured, 3);
  device_.configure_fails.reset();
  wait(1.0);
  EXPECT_EQ(control_.mode(), ArmMode::ARM_STARTING);
}

TEST_F(ArmControlTest, FailsWhenASetPointCannotBeSent) {
  run();
  device_.write_fails = device::DeviceFailure{"connection closed"};
  period();
  EXPECT_EQ(control_.mode(), ArmMode::ARM_FAILED);
  EXPECT_EQ(text(), "connection closed; once it works again, call 'hecaton resume arm1'");
  EXPECT_FALSE(device_.active);
}

TEST_F(ArmControlTest, FailsWhenTheMeasuredStateIsOldOrNotFinite) {
  run();
  device_.age = 60ms;
  period();
  EXPECT_EQ(control_.mode(), ArmMode::ARM_FAILED);
  EXPECT_EQ(text(),
            "the device's state is 60 ms old (limit 50 ms, timing.command_timeout): is a cable out, or has its "
            "controller or program stopped? Once it works again, call 'hecaton resume arm1'");
  EXPECT_EQ(control_.measured_at(), now_ - 60ms);
  device_.age = 0ms;
  device_.measures_nan = true;
  wait(1.1);
  EXPECT_EQ(control_.mode(), ArmMode::ARM_FAILED);
  EXPECT_EQ(text(), "the device measures a value that is not finite; once it works again, call 'hecaton resume arm1'")
      << "also of a later failure";
}

TEST_F(ArmControlTest, LeavesTheArmToOthersOnceItHasStopped) {
  run();
  control_.set_observed(true);
  EXPECT_EQ(control_.mode(), ArmMode::ARM_BRAKING);
  EXPECT_EQ(kind(), CauseKind::CAUSE_OBSERVED);
  EXPECT_TRUE(device_.active) << "it follows the stop profile to its end";
  wait(0.06);
  EXPECT_EQ(control_.mode(), ArmMode::ARM_OBSERVED);
  EXPECT_FALSE(device_.active);
  const double stands = q();
  for (int k = 0; k < 20; ++k) plan();
  EXPECT_EQ(last_.verdict, Verdict::kAccepted) << "its planner learns that the driver hears it";
  EXPECT_EQ(q(), stands);
  // A teach pendant switches remote control off and stops programs: that is what observing is for.
  for (const DeviceMode mode : {DeviceMode::kRemoteControlOff, DeviceMode::kProtectiveStop, DeviceMode::kNotReady}) {
    device_.mode = mode;
    period();
    EXPECT_EQ(control_.mode(), ArmMode::ARM_OBSERVED);
    EXPECT_EQ(kind(), CauseKind::CAUSE_OBSERVED);
  }
  device_.mode = DeviceMode::kReady;
  wait(0.1);
  EXPECT_FALSE(device_.active);
  control_.set_observed(false);
  period();
  EXPECT_TRUE(device_.active);
  EXPECT_EQ(device_.first_set_point, q());
  q_ = q();
  plan();
  EXPECT_EQ(control_.mode(), ArmMode::ARM_RUNNING);
}

TEST_F(ArmControlTest, HoldsAnArmThatIsGivenBackWhileItsDeviceIsStopped) {
  run();
  control_.set_observed(true);
  wait(0.1);
  device_.mode = DeviceMode::kRemoteControlOff;
  device_.text = "switch it to remote control";
  period();
  control_.set_observed(false);
  period();
  EXPECT_EQ(kind(), CauseKind::CAUSE_REMOTE_CONTROL_OFF);
  EXPECT_FALSE(device_.active);
}

TEST_F(ArmControlTest, FailsWhenAnObservedArmIsNotMeasured) {
  ArmControl control({"arm1", limits(), kTimeout, kPeriod, 12ms, {}, true}, device_);
  const auto period = [&] {
    now_ += kPeriod;
    control.read(now_);
    control.set_hold({});
    control.write();
  };
  period();
  EXPECT_EQ(control.mode(), ArmMode::ARM_OBSERVED) << "from the start";
  EXPECT_FALSE(device_.active);
  device_.mode = DeviceMode::kNotReady;
  device_.age = 60ms;
  period();
  EXPECT_EQ(control.mode(), ArmMode::ARM_FAILED) << "other arms avoid it by its state, also when the device is off";
  EXPECT_EQ(control.cause().text(),
            "the device's state is 60 ms old (limit 50 ms, timing.command_timeout): is a cable out, or has its "
            "controller or program stopped?");
  device_.age = 0ms;
  for (int k = 0; k < 600; ++k) period();
  EXPECT_EQ(control.mode(), ArmMode::ARM_OBSERVED);
  EXPECT_EQ(control.cause().kind(), CauseKind::CAUSE_OBSERVED);
}

TEST_F(ArmControlTest, ReportsAStopOfTheDeviceAsNoFailure) {
  run();
  device_.text = "protective stop: release it at the pendant";
  for (const auto& [mode, expected] : {std::pair(DeviceMode::kProtectiveStop, CauseKind::CAUSE_PROTECTIVE_STOP),
                                       std::pair(DeviceMode::kEmergencyStop, CauseKind::CAUSE_EMERGENCY_STOP),
                                       std::pair(DeviceMode::kSafeguardStop, CauseKind::CAUSE_SAFEGUARD_STOP),
                                       std::pair(DeviceMode::kProgramStopped, CauseKind::CAUSE_PROGRAM_STOPPED),
                                       std::pair(DeviceMode::kRemoteControlOff, CauseKind::CAUSE_REMOTE_CONTROL_OFF)}) {
    device_.mode = mode;
    wait(0.1);
    EXPECT_EQ(control_.mode(), ArmMode::ARM_STOPPED);
    EXPECT_EQ(control_.cause(), make_cause(expected, "arm1", device_.text));
    EXPECT_FALSE(device_.active);
  }
  device_.mode = DeviceMode::kNotReady;
  wait(0.1);
  EXPECT_EQ(kind(), CauseKind::CAUSE_PROTECTIVE_STOP) << "not being ready does not hide why the device stopped";
  wait(1.0);
  EXPECT_EQ(kind(), CauseKind::CAUSE_DEVICE_NOT_READY) << "later a person reads what the device lacks now";
  device_.mode = DeviceMode::kReady;
  wait(0.1);
  EXPECT_FALSE(device_.active);
  EXPECT_EQ(kind(), CauseKind::CAUSE_PROTECTIVE_STOP) << "the stop that ended the motion";
  resume();
  EXPECT_TRUE(device_.active);
  EXPECT_EQ(device_.first_set_point, q());
  EXPECT_EQ(device_.configured, 1);
}

TEST_F(ArmControlTest, ReportsADeviceThatIsNotReadyAnyMore) {
  run();
  device_.text = "the robot is off";
  device_.mode = DeviceMode::kNotReady;
  wait(0.1);
  EXPECT_EQ(control_.cause(), make_cause(CauseKind::CAUSE_DEVICE_NOT_READY, "arm1", device_.text));
}

TEST_F(ArmControlTest, WaitsForADeviceThatStarts) {
  device_.mode = DeviceMode::kStarting;
  device_.text = "connects";
  may_run_ = true;
  wait(0.1);
  EXPECT_EQ(control_.cause(), make_cause(CauseKind::CAUSE_STARTING, "arm1", "connects"));
  device_.starts_slowly = true;
  device_.mode = DeviceMode::kReady;
  period();
  EXPECT_TRUE(device_.active);
  wait(0.1);
  EXPECT_TRUE(std::isnan(device_.first_set_point)) << "no set-point before it is ready";
  device_.mode = DeviceMode::kReady;
  period();
  EXPECT_EQ(device_.first_set_point, q());
}

// Of CAUSE_STARTING the supervisor makes no fault: no hold would come, and no resume.
TEST_F(ArmControlTest, ReportsADeviceThatStartsAgainAsStopped) {
  run();
  device_.mode = DeviceMode::kStarting;
  device_.text = "connects";
  wait(0.1);
  EXPECT_FALSE(device_.active);
  EXPECT_EQ(control_.cause(),
            make_cause(CauseKind::CAUSE_PROGRAM_STOPPED, "arm1",
                       "the device follows no set-points any more and starts again: connects; once it works again, "
                       "call 'hecaton resume arm1'"));
  device_.mode = DeviceMode::kReady;
  wait(0.1);
  EXPECT_FALSE(device_.active);
  EXPECT_EQ(kind(), CauseKind::CAUSE_PROGRAM_STOPPED);
  resume();
  EXPECT_TRUE(device_.active);
  EXPECT_EQ(device_.first_set_point, q());
}

TEST_F(ArmControlTest, IsHeldFromTheStartUntilAPersonResumes) {
  FaultyArm arm({"arm1", limits(), planner::JointVector::Zero(1), kPeriod, "", "", {}});
  const msg::Cause restarted = make_cause(CauseKind::CAUSE_PROGRAM_STOPPED, "arm1", "its driver was restarted");
  ArmControl control({"arm1", limits(), kTimeout, kPeriod, 12ms, restarted}, arm);
  const auto step = [&](bool held) {
    control.set_hold(held ? std::optional(restarted) : std::nullopt, held);
    control.read(now_ += kPeriod);
  };
  step(false);
  step(false);
  EXPECT_FALSE(arm.active);
  EXPECT_EQ(control.cause(), restarted);
  step(true);
  EXPECT_FALSE(arm.active);
  step(false);
  EXPECT_TRUE(arm.active);
}

TEST_F(ArmControlTest, DoesNotJumpBackByTheLagOfTheDevice) {
  device_.delay = 0.03;
  run();
  const double before = device_.written.q[0];
  q_ -= 0.03;  // the planner begins again at the measured position
  send();
  period();
  EXPECT_NEAR(device_.written.q[0], before, 1.5 * 0.002 + 1e-9) << "1.5 times the velocity limit";
  EXPECT_EQ(control_.mode(), ArmMode::ARM_RUNNING);
}

TEST_F(ArmControlTest, BrakesWhenALaggingDeviceStaysBehind) {
  device_.delay = 0.03;
  run();
  device_.sticks = true;
  for (int k = 0; k < 40; ++k) plan();
  EXPECT_NE(control_.mode(), ArmMode::ARM_RUNNING);
  EXPECT_EQ(kind(), CauseKind::CAUSE_COMMAND_TOO_FAR);
}

TEST_F(ArmControlTest, BeginsTheStopAtTheMeasuredPositionAfterAStall) {
  run();
  const double before = q();
  period(200ms);  // the device has stopped by itself: 12 ms at 0.5 rad/s, then 50 ms of braking
  EXPECT_NEAR(q(), before + 0.5 * 0.012 + 0.0125, 0.0015);
  EXPECT_NEAR(device_.written.q[0], q(), 1e-6);
  EXPECT_NE(control_.mode(), ArmMode::ARM_RUNNING);
}

TEST_F(ArmControlTest, MovesSmoothlyWithALateLoop) {
  run();
  const double before = q();
  std::chrono::nanoseconds late = 0ns;
  for (int k = 0; k < 20; ++k) {  // each second period comes 1 ms late, each other one early
    q_ += 0.005;
    send();
    for (int i = 0; i < 5; ++i) {
      late = late == 0ns ? 1ms : 0ns;
      period(late == 0ns ? -1ms : 1ms);
      ASSERT_NEAR(control_.measured().qd[0], 0.5, 0.03);
    }
  }
  EXPECT_NEAR(q(), before + 0.1, 0.001);
}

// Velocities of a real arm at rest are never exactly zero.
TEST_F(ArmControlTest, HasStoppedAlthoughMeasuredVelocitiesTremble) {
  run();
  device_.trembles = 0.005;
  may_run_ = false;
  for (int i = 0; i < 200; ++i) period();
  for (int i = 0; i < 500; ++i) {
    period();
    ASSERT_EQ(control_.mode(), ArmMode::ARM_STOPPED) << "period " << i;
  }
}

TEST_F(ArmControlTest, StopsTheDeviceAtItsEnd) {
  device::DeviceSetup setup{"arm1", limits(), planner::JointVector::Zero(1), kPeriod, "", "", {}};
  FaultyArm arm(setup);
  {
    ArmControl control({"arm1", limits(), kTimeout, kPeriod, 12ms, {}}, arm);
    control.set_hold({});
    control.read(now_);
    ASSERT_TRUE(arm.active);
  }
  EXPECT_FALSE(arm.active);
  EXPECT_EQ(arm.stopped_for, "the driver shuts down");
}

}  // namespace
}  // namespace hecaton::services
