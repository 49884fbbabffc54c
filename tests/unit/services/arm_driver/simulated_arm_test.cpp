// The simulated arm as imperfect as real ones: its keys, its lag, and the events that a person causes.
#include "services/arm_driver/devices/simulated/simulated_arm.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "services/arm_driver/devices/simulated/options.hpp"
#include "tests/support/temporary_folder.hpp"

namespace hecaton::device {
namespace {

using namespace std::chrono_literals;

constexpr auto kSimulatedPeriod = 2ms;

class SimulatedArmTest : public testing::Test {
 protected:
  SimulatedArmTest() {
    setup_.arm = "north";
    setup_.where = "cell.yaml: arms[0].device";
    setup_.limits.lower = JointVector::Constant(2, -3.0);
    setup_.limits.upper = JointVector::Constant(2, 3.0);
    setup_.limits.velocity = JointVector::Constant(2, 2.0);
    setup_.limits.acceleration = JointVector::Constant(2, 20.0);
    setup_.start = JointVector::Zero(2);
    setup_.joint_names = {"shoulder", "elbow"};
    setup_.period = kSimulatedPeriod;
    setup_.signals = {"protective_stop", "emergency_stop", "connection_lost", "speed_scaling"};
  }
  void make() { arm_ = make_simulated_arm(setup_); }
  std::string refusal(const std::string& key, const std::string& value) {
    setup_.values = {{key, value}};
    try {
      make();
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "nothing";
  }
  /// Moves joint 1 at this speed for some periods.
  DeviceState move(double speed, int periods) {
    DeviceState state;
    for (int i = 0; i < periods; ++i) {
      state = arm_->read(now_ += kSimulatedPeriod);
      target_ += speed * 0.002;
      JointState set_point{JointVector::Zero(2), JointVector::Zero(2)};
      set_point.q[0] = target_;
      set_point.qd[0] = speed;
      EXPECT_FALSE(arm_->write(set_point, 12ms));
    }
    return state;
  }

  DeviceSetup setup_;
  std::unique_ptr<ArmDevice> arm_;
  Clock::time_point now_{1h};
  double target_ = 0.0;
};

TEST_F(SimulatedArmTest, LagsByWhatItReports) {
  setup_.values = {{"servo", "ros2_control"}, {"noise", "0"}, {"resolution", "0"}, {"jitter", "0"}};
  make();
  EXPECT_DOUBLE_EQ(arm_->tracking_delay(), 0.15);
  const DeviceState state = move(0.5, 500);
  const double now = target_ - 0.5 * 0.002;  // what is due at the last read()
  EXPECT_NEAR(now - state.measured.q[0], 0.5 * arm_->tracking_delay(), 1e-3);
}

TEST_F(SimulatedArmTest, TakesSetPointsInItsOwnPeriod) {
  setup_.values = {{"servo_period", "20ms"}};
  make();
  move(0.0, 5);
  EXPECT_EQ(move(0.5, 3).measured.q[0], 0.0) << "its second cycle has not begun";
  EXPECT_GT(move(0.5, 10).measured.q[0], 0.0);
  const DeviceState state = move(0.5, 500);
  EXPECT_NEAR(target_ - 0.5 * 0.002, state.measured.q[0], 1e-4);
  EXPECT_EQ(arm_->tracking_delay(), 0.0);
}

TEST_F(SimulatedArmTest, RefusesWrongKeys) {
  EXPECT_EQ(refusal("servo", "kuka"),
            "cell.yaml: arms[0].device.servo = kuka must be one of ur_cb3, ur_e_series, abb_egm, ros2_control");
  EXPECT_EQ(refusal("dead_time", "2s"), "cell.yaml: arms[0].device.dead_time = 2s must be 0s to 0.3s");
  EXPECT_EQ(refusal("jitter", "5ms"), "cell.yaml: arms[0].device.jitter = 5ms must be 0s to 0s");
  EXPECT_EQ(refusal("damping", "1"), "cell.yaml: arms[0].device.damping = 1 must be 0 to 0.99");
  EXPECT_EQ(refusal("protective_effort", "11"), "cell.yaml: arms[0].device.protective_effort = 11 must be 0 to 10");
  setup_.forces.reason = "link wrist has no mass in the robot description (<inertial>)";
  EXPECT_EQ(refusal("protective_effort", "1"),
            "cell.yaml: arms[0].device.protective_effort needs masses and effort limits, but link wrist has no mass in "
            "the robot description (<inertial>): complete it, or leave the key out");
}

TEST_F(SimulatedArmTest, StopsProtectivelyAboveItsSpeedUntilAPersonUnlocksIt) {
  setup_.values = {{"protective_speed", "1"}};
  make();
  EXPECT_EQ(move(0.5, 200).mode, DeviceMode::kReady);
  const DeviceState stopped = move(1.8, 200);
  EXPECT_EQ(stopped.mode, DeviceMode::kProtectiveStop);
  EXPECT_EQ(stopped.text,
            "protective stop, because joint shoulder moved at 1.02 rad/s, its limit is 1 rad/s: call 'hecaton device "
            "north unlock', then resume the arm");
  EXPECT_TRUE(stopped.measured.qd.isZero());
  EXPECT_EQ(arm_->signal(0), 1.0);
  EXPECT_FALSE(arm_->continues_after_restart());
  EXPECT_FALSE(arm_->begin(DeviceOrder::kUnlock));
  EXPECT_TRUE(arm_->order_end());
  EXPECT_FALSE(arm_->order_end()) << "once";
  EXPECT_EQ(arm_->read(now_ += kSimulatedPeriod).mode, DeviceMode::kReady);
}

TEST_F(SimulatedArmTest, StopsProtectivelyAboveItsForceUntilAPersonUnlocksIt) {
  // A mass of 2 kg m² at each joint, and 3 N m of weight at the first one.
  setup_.forces.of_motion = [](const JointVector& /*q*/, const JointVector& /*qd*/, const JointVector& qdd) {
    JointVector force = 2.0 * qdd;
    force[0] += 3.0;
    return force;
  };
  setup_.forces.limits = JointVector::Constant(2, 20.0);
  setup_.values = {{"protective_effort", "1"}};
  make();
  EXPECT_EQ(move(0.0, 500).mode, DeviceMode::kReady) << "its weight alone is no reason";
  // 8 rad/s², the limit of the effort is at 8.5 rad/s².
  for (int i = 0; i < 100; ++i) ASSERT_EQ(move(0.016 * i, 1).mode, DeviceMode::kReady) << i;
  for (int i = 100; i > 0; --i) ASSERT_EQ(move(0.016 * i, 1).mode, DeviceMode::kReady) << i;
  // 12 rad/s², within the limit of the acceleration: 27 N m.
  DeviceState stopped;
  for (int i = 0; i < 100; ++i) stopped = move(0.024 * i, 1);
  EXPECT_EQ(stopped.mode, DeviceMode::kProtectiveStop);
  EXPECT_TRUE(stopped.text.starts_with("protective stop, because joint shoulder needed 20.")) << stopped.text;
  EXPECT_TRUE(
      stopped.text.ends_with(" N m, its limit is 20 N m: call 'hecaton device north unlock', then resume the arm"))
      << stopped.text;
  EXPECT_FALSE(arm_->begin(DeviceOrder::kUnlock));
  EXPECT_EQ(arm_->read(now_ += kSimulatedPeriod).mode, DeviceMode::kReady);
}

TEST_F(SimulatedArmTest, StaysInAProtectiveStopWhenItsProcessEnds) {
  const test::TemporaryFolder folder;
  setup_.checkpoint = folder.path("north");
  setup_.signals.clear();
  setup_.values = {{"protective_speed", "1"}};
  make();
  EXPECT_EQ(move(1.8, 200).mode, DeviceMode::kProtectiveStop);
  arm_.reset();
  make();
  EXPECT_EQ(arm_->read(now_ += kSimulatedPeriod).text,
            "protective stop: call 'hecaton device north unlock', then resume the arm");
  EXPECT_FALSE(arm_->continues_after_restart());
  EXPECT_FALSE(arm_->begin(DeviceOrder::kUnlock));
  arm_.reset();
  make();
  EXPECT_EQ(arm_->read(now_ += kSimulatedPeriod).mode, DeviceMode::kReady);
}

TEST_F(SimulatedArmTest, StopsAndLosesItsConnectionWhenAPersonSaysSo) {
  make();
  move(0.5, 100);
  EXPECT_FALSE(arm_->set_signal(1, 1.0));
  EXPECT_EQ(move(0.5, 100).mode, DeviceMode::kEmergencyStop);
  EXPECT_TRUE(arm_->read(now_).measured.qd.isZero());
  EXPECT_FALSE(arm_->set_signal(1, 0.0));
  EXPECT_EQ(arm_->read(now_ += kSimulatedPeriod).mode, DeviceMode::kReady);

  EXPECT_FALSE(arm_->set_signal(2, 1.0));
  const DeviceState lost = arm_->read(now_ += 100ms);
  EXPECT_EQ(lost.mode, DeviceMode::kFailed);
  EXPECT_EQ(lost.age, 100ms);
  ASSERT_TRUE(arm_->configure());
  EXPECT_EQ(arm_->configure()->text, lost.text);
  EXPECT_FALSE(arm_->set_signal(2, 0.0));
  EXPECT_FALSE(arm_->configure());
}

TEST_F(SimulatedArmTest, ReportsTheSpeedScalingThatAPersonSets) {
  make();
  EXPECT_EQ(arm_->read(now_).speed_scaling, 1.0);
  EXPECT_FALSE(arm_->set_signal(3, 0.4));
  EXPECT_EQ(arm_->read(now_).speed_scaling, 0.4);
  ASSERT_TRUE(arm_->set_signal(3, 40.0));
}

TEST_F(SimulatedArmTest, RunsAfterItsSetPointsAtTheSpeedScaling) {
  make();
  move(0.5, 400);
  double speed = arm_->read(now_).measured.qd[0];
  ASSERT_NEAR(speed, 0.5, 1e-6);
  const auto at_scaling = [&](double scaling, int periods) {
    EXPECT_FALSE(arm_->set_signal(3, scaling));
    DeviceState state;
    for (int i = 0; i < periods; ++i) {
      state = move(0.5, 1);
      EXPECT_LE(std::abs(state.measured.qd[0] - speed), 20.0 * 0.002 + 1e-9) << "no jerk at " << scaling;
      speed = state.measured.qd[0];
    }
    return state;
  };
  EXPECT_NEAR(at_scaling(0.1, 100).measured.qd[0], 0.2, 1e-6) << "a share of the limit of 2 rad/s";
  const double rest = at_scaling(0.0, 100).measured.q[0];
  EXPECT_NEAR(at_scaling(0.0, 100).measured.q[0], rest, 1e-6);
  const double end = at_scaling(1.0, 500).measured.q[0];
  EXPECT_NEAR(end, target_ - 0.5 * 0.002, 1e-5) << "it catches up";
}

TEST_F(SimulatedArmTest, KeepsItsSpeedScalingBehindAnImperfectController) {
  setup_.values = {{"servo", "ros2_control"}, {"noise", "0"}, {"resolution", "0"}};
  make();
  EXPECT_FALSE(arm_->set_signal(3, 0.1));
  EXPECT_NEAR(move(0.5, 1000).measured.qd[0], 0.2, 0.02);
}

}  // namespace
}  // namespace hecaton::device
