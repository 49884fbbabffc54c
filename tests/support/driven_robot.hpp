#pragma once
/// A device in periods of a driver, against a robot that a program of tests/robots plays. The first joint follows the
/// velocity that a test sets.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "services/arm_driver/device_session.hpp"
#include "tests/support/robot_simulator.hpp"

namespace hecaton::test {

/// `Base`: testing::Test or one with parameters.
template <class Base>
class DrivenRobot : public Base {
 protected:
  using Clock = device::Clock;
  using JointVector = device::JointVector;

  struct Setup {
    std::chrono::milliseconds period;  ///< of the driver
    double still = 1e-4;               ///< speed of a joint that stands, in the unit of the robot's controller
    double second_joint = 0.0;         ///< speed of the second joint, as a share of the first one's
    // After a resumption:
    std::string counter = "accepted";  ///< of set-points, in the state of the robot
    int count = 0;                     ///< set-points after which the robot is looked at
    double step = 0.0;                 ///< largest step of the set-points, in the unit of the controller
    double place = 0.0;                ///< largest way of a joint, in the unit of the controller
  };
  explicit DrivenRobot(Setup setup) : setup_(std::move(setup)) {}

  /// Starts driving `device_`, which has that many joints. `state_age_limit`: by default long, for a busy machine.
  void drive(const std::string& arm, int joints,
             std::chrono::duration<double> state_age_limit = std::chrono::seconds(10)) {
    session_.emplace(services::DeviceSessionSetup{arm, joints, state_age_limit.count()}, *device_, std::nullopt);
    q_ = JointVector::Zero(joints);
  }
  /// Runs periods of a driver until `event` holds; false after kLimit.
  bool until(const std::function<bool()>& event) {
    for (const auto end = Clock::now() + kLimit; Clock::now() < end;) {
      period();
      if (event()) return true;
    }
    return false;
  }
  void period() {
    due_ = std::max<Clock::time_point>(due_ + setup_.period, Clock::now());
    std::this_thread::sleep_until(due_);
    const bool was_active = session_->active();
    session_->read(Clock::now(), may_move_);
    if (session_->active() && !was_active) q_ = session_->state().measured.q;
    if (!session_->active() || silent_) return;
    JointVector qd = JointVector::Zero(q_.size());
    qd[0] = velocity_;
    if (qd.size() > 1) qd[1] = setup_.second_joint * velocity_;
    q_ += qd * std::chrono::duration<double>(setup_.period).count();
    session_->write({q_, qd}, kValidFor);
  }
  /// The device follows set-points.
  virtual void run() {
    ASSERT_TRUE(until([this] { return session_->active(); })) << text();
    robot_->order("forget");
  }
  void move() {
    run();
    velocity_ = 0.5;
    const double from = q_[0];
    ASSERT_TRUE(until([&] { return session_->state().measured.q[0] > from + 0.1; })) << text();
    ASSERT_TRUE(session_->active()) << text();
  }
  [[nodiscard]] std::vector<double> robot_q() { return robot_->state().at("q").template get<std::vector<double>>(); }
  [[nodiscard]] std::vector<double> robot_qd() { return robot_->state().at("qd").template get<std::vector<double>>(); }
  /// The arm stands on the robot's side.
  bool stands() {
    const auto qd = robot_qd();
    return std::all_of(qd.begin(), qd.end(), [this](double v) { return std::abs(v) < setup_.still; });
  }
  /// The supervisor has taken over the hold, and a person resumes.
  void resume() {
    velocity_ = 0.0;
    session_->release();
  }
  /// The robot is ready, and the arm still held. Then a person resumes: the arm stays where it is.
  void resumes(msg::CauseKind held_by) {
    ASSERT_TRUE(until([this] { return session_->state().mode == device::DeviceMode::kReady; })) << text();
    ASSERT_TRUE(until([this] { return stands(); }));
    EXPECT_FALSE(session_->active());
    EXPECT_EQ(kind(), held_by) << text();
    const auto before = robot_q();
    robot_->order("forget");
    resume();
    ASSERT_TRUE(until([this] { return session_->active(); })) << text();
    ASSERT_TRUE(until([this] {
      const auto state = robot_->state();
      return state.at(setup_.counter) > setup_.count && state.at("first").is_number();
    }));
    EXPECT_LT(robot_->state().at("first").template get<double>(), setup_.step);
    EXPECT_LT(robot_->state().at("largest").template get<double>(), setup_.step);
    const auto after = robot_q();
    for (std::size_t joint = 0; joint < after.size(); ++joint) {
      EXPECT_NEAR(after[joint], before[joint], setup_.place) << joint;
    }
  }
  [[nodiscard]] msg::CauseKind kind() const { return session_->cause().kind(); }
  [[nodiscard]] std::string text() const { return session_->cause().text(); }
  [[nodiscard]] bool says(const std::string& words) const { return text().find(words) != std::string::npos; }

  std::optional<RobotSimulator> robot_;
  std::unique_ptr<device::ArmDevice> device_;
  std::optional<services::DeviceSession> session_;
  JointVector q_;
  double velocity_ = 0.0;  ///< of the first joint [rad/s]
  bool may_move_ = true;
  bool silent_ = false;  ///< no set-points are sent

 private:
  static constexpr std::chrono::seconds kLimit{60};  // for any machine
  static constexpr std::chrono::milliseconds kValidFor{12};

  Setup setup_;
  Clock::time_point due_ = Clock::now();
};

}  // namespace hecaton::test
