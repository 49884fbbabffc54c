/// The device of ros2_control against the controllers of tests/robots/ros2_controller.cpp, without a cell.

#include <algorithm>
#include <cmath>
#include <functional>
#include <thread>
#include <utility>

#include <gtest/gtest.h>

#include "services/arm_driver/device_session.hpp"
#include "services/arm_driver/devices/ros2_control/ros2_control_arm.hpp"
#include "tests/support/driven_robot.hpp"
#include "tests/support/free_domain.hpp"

namespace hecaton::services {
namespace {

using namespace std::chrono_literals;

constexpr auto kPeriod = 4ms;
constexpr auto kSilence = 1000ms;  // a busy machine may stop the simulated controller for some time
/// After a failure of its device, an arm goes no further than at its speed in this time [s]. A lookahead and the lag of
/// the servos take 0.23 s, and the stop profile 0.04 s at 0.5 rad/s. The rest is for a busy machine.
constexpr double kStopTime = 0.5;

class Ros2ControlDevice : public test::DrivenRobot<testing::TestWithParam<std::string>> {
 protected:
  // Steps of a velocity controller are in rad/s. It has no set-point to come back to: an arm may drift by the
  // correction.
  Ros2ControlDevice()
      : DrivenRobot({.period = kPeriod,
                     .counter = "commands",
                     .step = velocity() ? 2e-2 : 1e-3,
                     .place = velocity() ? 5e-3 : 1e-3}) {}

  [[nodiscard]] bool position() const { return GetParam() == "position"; }
  [[nodiscard]] static bool velocity() { return GetParam() == "velocity"; }
  [[nodiscard]] bool action() const { return GetParam() == "action"; }

  void begin(std::vector<std::string> options = {}, std::map<std::string, std::string> keys = {}) {
    const std::string domain = std::to_string(domain_.number());
    options.insert(options.end(), {"--start", "0.1,-0.2,0.3"});
    robot_.emplace(simulation(options), "ros2_controller");
    keys.insert({{"domain", domain}, {"interface", GetParam()}, {"namespace", "/cell"}});
    if (!keys.contains("joints")) keys.insert({"joint_prefix", "l_"});
    device::DeviceSetup setup;
    setup.arm = "south";
    setup.joint_names = {"base", "elbow", "wrist"};
    setup.outside_names = fingers_;
    setup.outside.assign(fingers_.size(), 0.0);
    for (const std::string& joint : fingers_) setup.fingers.push_back(joint == "finger");
    setup.limits.lower = device::JointVector::Constant(3, -3.0);
    setup.limits.upper = device::JointVector::Constant(3, 3.0);
    setup.limits.velocity = device::JointVector::Constant(3, 1.5);
    setup.limits.acceleration = device::JointVector::Constant(3, 6.0);
    setup.period = kPeriod;
    setup.command_timeout = kSilence;
    setup.where = "cell.yaml: arms[0].device";
    setup.values = {keys.begin(), keys.end()};
    device_ = make_ros2_control_arm(setup);
    drive("south", 3);
  }

  [[nodiscard]] std::vector<std::string> simulation(std::vector<std::string> options) const {
    if (fingers_.empty()) options.insert(options.end(), {"--kind", GetParam()});
    options.insert(options.end(), {"--domain", std::to_string(domain_.number()), "--namespace", "/cell", "--joints",
                                   "l_base,l_elbow,l_wrist", "--from-desired"});
    return options;
  }
  [[nodiscard]] std::string unserved() const {
    return action() ? "nothing serves the action follow_joint_trajectory of" : "nothing reads commands of";
  }
  /// Another node with joint states of the same joints.
  void begin_other() {
    other_.emplace(simulation({"--controller", "other", "--start", "0.5,0.5,0.5"}), "ros2_controller");
  }
  void run() override {
    ASSERT_TRUE(until([this] { return session_->active(); })) << text();
    ASSERT_TRUE(until([this] { return robot_->state().at("commands") > 0; }));
  }

  std::vector<std::string> fingers_;  ///< joints outside the chain
  test::FreeDomain domain_;
  std::optional<test::RobotSimulator> other_;
};

INSTANTIATE_TEST_SUITE_P(Interfaces, Ros2ControlDevice, testing::Values("position", "velocity", "trajectory", "action"),
                         [](const auto& test) { return test.param; });

TEST_P(Ros2ControlDevice, BeginsAtTheMeasuredPositionAndFollowsSetPoints) {
  begin();
  run();
  EXPECT_EQ(q_, Eigen::Vector3d(0.1, -0.2, 0.3));
  velocity_ = 0.5;
  ASSERT_TRUE(until([&] { return q_[0] > 0.6; })) << text();
  velocity_ = 0.0;
  ASSERT_TRUE(until([&] { return std::abs(session_->state().measured.q[0] - q_[0]) < 1e-4; })) << text();
  const auto state = robot_->state();
  EXPECT_LT(state.at("first").get<double>(), 1e-9);
  EXPECT_EQ(state.at("refused"), 0) << state;
  EXPECT_TRUE(session_->active()) << text();
}

TEST_P(Ros2ControlDevice, StopsByItselfWhenSetPointsCease) {
  begin();
  move();
  silent_ = true;
  const double last = q_[0];
  ASSERT_TRUE(until([this] { return stands(); }));
  // 0.5 rad/s with 6 rad/s² end 0.021 rad behind the last set-point. A controller of positions stays at the set-point.
  const double end = position() ? 0.0 : 0.5 * 0.5 / 6.0 / 2.0;
  const double unsent = action() ? 0.11 : velocity() ? 0.05 : 0.025;  // a set-point, or the lag of velocities [s]
  EXPECT_NEAR(robot_q()[0], last + end, 0.5 * unsent + 1e-3);
}

TEST_P(Ros2ControlDevice, FindsItsJointsInEachMessage) {
  begin({"--others", "r_base,r_elbow,finger"});
  move();
  for (const char* order : {"reverse on", "split on", "reverse off", "split off"}) {
    robot_->order(order);
    const double from = q_[0];
    ASSERT_TRUE(until([&] { return q_[0] > from + 0.1; })) << order << text();
    const auto& measured = session_->state().measured.q;
    EXPECT_NEAR(measured[0], robot_q()[0], 0.2) << order;
    EXPECT_NEAR(measured[1], -0.2, 1e-6) << order;
    EXPECT_NEAR(measured[2], 0.3, 1e-6) << order;
  }
}

TEST_P(Ros2ControlDevice, DifferentiatesPositionsWhenThereAreNoVelocities) {
  begin({"--no-velocity"});
  run();
  velocity_ = 0.5;
  EXPECT_TRUE(until([&] { return std::abs(session_->state().measured.qd[0] - 0.5) < 0.05; })) << text();
  EXPECT_TRUE(session_->active()) << text();
}

TEST_P(Ros2ControlDevice, HoldsTheArmWhenAPositionIsNoNumber) {
  begin();
  move();
  robot_->order("nan l_elbow");
  ASSERT_TRUE(until([this] { return session_->failed(); }));
  EXPECT_TRUE(says("for 1000 ms: the messages there have no number as the position of l_elbow")) << text();
  robot_->order("nan none");
  ASSERT_TRUE(until([this] { return !session_->failed(); })) << text();
  // With velocities, the unseen arm may also have left its set-points by then.
  resumes(velocity() ? kind() : msg::CauseKind::CAUSE_DEVICE_FAILED);
}

TEST_P(Ros2ControlDevice, HoldsTheArmWhenJointStatesCease) {
  begin();
  move();
  robot_->order("silence on");
  ASSERT_TRUE(until([this] { return session_->failed(); }));
  const double failed_at = robot_q()[0];
  EXPECT_TRUE(says("no state of the arm on topic /cell/joint_states")) << text();
  ASSERT_TRUE(until([this] { return stands(); }));
  EXPECT_LT(robot_q()[0] - failed_at, kStopTime * velocity_);
  robot_->order("silence off");
  resumes(msg::CauseKind::CAUSE_DEVICE_FAILED);
}

TEST_P(Ros2ControlDevice, FollowsARestartedControllerOnlyAfterAResume) {
  begin();
  move();
  robot_->order("restart 3");
  ASSERT_TRUE(until([this] { return !session_->active(); }));
  const msg::CauseKind held_by = kind();
  ASSERT_TRUE(until([this] { return robot_->state().at("running").get<bool>(); }));
  ASSERT_TRUE(until([this] { return !session_->failed(); })) << text();
  resumes(held_by);
}

TEST_P(Ros2ControlDevice, HoldsTheArmWhenTheControllerIsDeactivated) {
  begin();
  move();
  robot_->order("deactivate");
  ASSERT_TRUE(until([this] { return kind() == msg::CauseKind::CAUSE_PROGRAM_STOPPED; })) << text();
  if (action()) {
    EXPECT_TRUE(says("has cancelled the trajectory: ") || says("refuses a trajectory: activate it")) << text();
  } else {
    EXPECT_TRUE(says(position()   ? "joint l_base stands still although its set-points move"
                     : velocity() ? "from where its set-points lead (limit"
                                  : "publishes no controller_state, so it is not active"))
        << text();
  }
  EXPECT_TRUE(says("'hecaton resume south'")) << text();
  robot_->order("activate");
  resumes(msg::CauseKind::CAUSE_PROGRAM_STOPPED);
}

TEST_P(Ros2ControlDevice, HoldsTheArmWhenTheControllerIsUnloaded) {
  begin({"--key-hash"});
  move();
  robot_->order("unload");
  ASSERT_TRUE(until([this] { return kind() == msg::CauseKind::CAUSE_PROGRAM_STOPPED; })) << text();
  EXPECT_TRUE(says(unserved() + " the controller /cell/")) << text();
}

TEST_P(Ros2ControlDevice, HoldsTheArmWhenTwoNodesPublishItsJoints) {
  begin();
  move();
  velocity_ = 0.1;  // the other node may need seconds until it is found
  // It may also be found at once: not while the arm still follows faster set-points.
  ASSERT_TRUE(until([this] { return robot_qd()[0] < 1.1 * velocity_; }));
  begin_other();
  ASSERT_TRUE(until([this] { return session_->failed(); }));
  const double failed_at = robot_q()[0];
  EXPECT_TRUE(says("two nodes publish joint l_")) << text();
  ASSERT_TRUE(until([this] { return stands(); }));
  EXPECT_LT(robot_q()[0] - failed_at, kStopTime * velocity_);
  other_.reset();
  resumes(msg::CauseKind::CAUSE_DEVICE_FAILED);
}

TEST_P(Ros2ControlDevice, NeverBelievesTheSecondNode) {
  begin();
  begin_other();
  ASSERT_TRUE(until([this] { return says("two nodes publish joint l_"); })) << text();
  for (const auto end = device::Clock::now() + 4s; device::Clock::now() < end;)
    period();  // it connects again and again
  EXPECT_FALSE(session_->active());
  EXPECT_EQ(robot_->state().at("commands"), 0);
}

TEST_P(Ros2ControlDevice, NamesAnAddressThatThisMachineDoesNotHave) {
  begin({}, {{"address", "203.0.113.7"}});
  ASSERT_TRUE(until([this] { return session_->failed(); }));
  EXPECT_TRUE(says("cannot join domain " + std::to_string(domain_.number()) + " of ROS 2: ")) << text();
  EXPECT_TRUE(says("203.0.113.7")) << text();
}

TEST_P(Ros2ControlDevice, NamesAMissingJoint) {
  begin({"--others", "finger"});
  robot_->order("lack l_wrist");
  ASSERT_TRUE(until([this] { return kind() == msg::CauseKind::CAUSE_DEVICE_NOT_READY; })) << text();
  EXPECT_TRUE(says("the messages there lack l_wrist, and have l_base, finger, l_elbow")) << text();
}

TEST_P(Ros2ControlDevice, NamesAMissingController) {
  begin({"--controller", "another_controller"});
  ASSERT_TRUE(until([this] { return kind() == msg::CauseKind::CAUSE_DEVICE_NOT_READY; })) << text();
  EXPECT_TRUE(says(unserved() + " the controller /cell/")) << text();
}

TEST_P(Ros2ControlDevice, ReportsTheSpeedScaling) {
  begin({"--scaling-topic", "scaling/speed"}, {{"speed_scaling", "scaling/speed"}});
  run();
  EXPECT_DOUBLE_EQ(session_->state().speed_scaling, 1.0);
  const double delay = device_->tracking_delay();
  robot_->order("scaling 50");
  ASSERT_TRUE(until([this] { return session_->state().speed_scaling == 0.5; })) << text();
  EXPECT_TRUE(until([&] { return device_->tracking_delay() > 1.9 * delay; })) << "the lag grows";
}

TEST_P(Ros2ControlDevice, WaitsForTheSpeedScalingThatIsConfigured) {
  begin({}, {{"speed_scaling", "scaling/speed"}});
  ASSERT_TRUE(until([this] { return kind() == msg::CauseKind::CAUSE_DEVICE_NOT_READY; })) << text();
  EXPECT_TRUE(says("no speed scaling arrives on topic /cell/scaling/speed")) << text();
}

TEST_P(Ros2ControlDevice, RefusesASetPointThatJumps) {
  begin();
  run();
  q_[1] += 0.5;
  ASSERT_TRUE(until([this] { return session_->failed(); }));
  EXPECT_TRUE(says("the set-point of joint 2 jumps by 0.5000")) << text();
  EXPECT_LT(robot_->state().at("fastest").get<double>(), 1e-3);
}

// Of an action, each client learns alone that the server refuses its goal.
class Ros2ControlOverTopics : public Ros2ControlDevice {};
INSTANTIATE_TEST_SUITE_P(Interfaces, Ros2ControlOverTopics, testing::Values("position", "velocity", "trajectory"),
                         [](const auto& test) { return test.param; });

TEST_P(Ros2ControlOverTopics, GoesOnWhenTheControllerRefusesCommandsOfAnotherNode) {
  begin();
  move();
  robot_->order("command partial");
  ASSERT_TRUE(until([this] { return robot_->state().at("refused") == 1; })) << robot_->state();
  robot_->order("command name");
  ASSERT_TRUE(until([this] { return robot_->state().at("refused") == 2; })) << robot_->state();
  const double from = session_->state().measured.q[0];
  EXPECT_TRUE(until([&] { return session_->state().measured.q[0] > from + 0.1; })) << text();
  EXPECT_TRUE(session_->active()) << text();
}

class Ros2ControlVelocity : public Ros2ControlDevice {
 protected:
  bool until_stands() {
    for (const auto end = device::Clock::now() + 60s; device::Clock::now() < end;) {
      if (stands()) return true;
      std::this_thread::sleep_for(10ms);  // the simulated controller announces nothing
    }
    return false;
  }
};
INSTANTIATE_TEST_SUITE_P(Interfaces, Ros2ControlVelocity, testing::Values("velocity"),
                         [](const auto& test) { return test.param; });

TEST_P(Ros2ControlVelocity, SendsZerosUntilTheArmStands) {
  begin();
  move();
  may_move_ = false;
  device_->stop("a test");
  silent_ = true;
  ASSERT_TRUE(until([this] { return stands(); }));
  EXPECT_EQ(robot_->state().at("command").get<std::vector<double>>(), (std::vector<double>{0, 0, 0}))
      << robot_->state();
  int before = -1;  // then another node may use the controller
  ASSERT_TRUE(until([&] {
    for (int i = 0; i < 50; ++i) period();
    const int now = robot_->state().at("commands");
    return std::exchange(before, now) == now;
  }));
}

TEST_P(Ros2ControlVelocity, StopsTheArmBeforeItsProcessEnds) {
  begin();
  move();
  session_.reset();  // as the driver does when it shuts down
  device_.reset();
  EXPECT_TRUE(until_stands()) << robot_->state();
  EXPECT_EQ(robot_->state().at("command").get<std::vector<double>>(), (std::vector<double>{0, 0, 0}))
      << robot_->state();
}

TEST_P(Ros2ControlVelocity, HoldsTheArmAgainstADriftOfItsHardware) {
  begin();
  run();
  const double from = robot_q()[0];
  robot_->order("drift 0.02");
  for (int i = 0; i < 250; ++i) period();
  EXPECT_NEAR(robot_q()[0], from, 0.01);
  EXPECT_TRUE(session_->active()) << text();
}

TEST_P(Ros2ControlVelocity, HoldsAnArmWhoseJointsAreInAnotherOrder) {
  begin({}, {{"joints", "l_elbow, l_base, l_wrist"}});
  run();
  velocity_ = 0.5;
  ASSERT_TRUE(until([this] { return kind() == msg::CauseKind::CAUSE_PROGRAM_STOPPED; })) << text();
  EXPECT_TRUE(says("compare the order of its joints with that of the cell file, then call 'hecaton resume south'"))
      << text();
  ASSERT_TRUE(until([this] { return stands(); }));
  EXPECT_LT(std::abs(robot_q()[0] - 0.1), 1.0) << "it has gone this far";
}

TEST_P(Ros2ControlVelocity, StopsAnArmThatAnInactiveControllerMovesAsSoonAsItIsActive) {
  begin({"--keeps-velocity"});
  move();
  robot_->order("deactivate");
  velocity_ = 0.0;  // the arm goes on, and the driver cannot stop it
  ASSERT_TRUE(until([this] { return kind() == msg::CauseKind::CAUSE_PROGRAM_STOPPED; })) << text();
  EXPECT_FALSE(stands());
  robot_->order("activate");
  EXPECT_TRUE(until([this] { return stands(); })) << robot_->state();
}

class Ros2ControlTrajectory : public Ros2ControlDevice {};
INSTANTIATE_TEST_SUITE_P(Interfaces, Ros2ControlTrajectory, testing::Values("trajectory", "action"),
                         [](const auto& test) { return test.param; });

TEST_P(Ros2ControlTrajectory, SendsASetPointAtRestOnce) {
  begin();
  run();
  const int before = robot_->state().at("commands");
  for (int i = 0; i < 100; ++i) period();
  EXPECT_EQ(robot_->state().at("commands"), before);
}

class Ros2ControlAction : public Ros2ControlDevice {
 protected:
  /// The device has stopped for that reason; it can be resumed where it stands.
  void stops(const std::string& words) {
    ASSERT_TRUE(until([this] { return kind() == msg::CauseKind::CAUSE_PROGRAM_STOPPED; })) << text();
    EXPECT_TRUE(says(words)) << text();
    EXPECT_TRUE(says("look at the robot, then call 'hecaton resume south'")) << text();
  }
};
INSTANTIATE_TEST_SUITE_P(Interfaces, Ros2ControlAction, testing::Values("action"),
                         [](const auto& test) { return test.param; });

TEST_P(Ros2ControlAction, ReplacesEachGoalByTheNextOne) {
  begin();
  move();
  const int before = robot_->state().at("commands");
  const double from = q_[0];
  ASSERT_TRUE(until([&] { return q_[0] > from + 0.5; })) << text();
  const auto state = robot_->state();
  EXPECT_GT(state.at("commands").get<int>(), before + 3) << "a goal each 0.1 s";
  EXPECT_LT(state.at("commands").get<int>(), before + 25);
  EXPECT_EQ(state.at("cancels"), 0) << "replaced, not cancelled";
  EXPECT_EQ(state.at("refused"), 0) << state;
  EXPECT_TRUE(session_->active()) << text();
}

TEST_P(Ros2ControlAction, HoldsTheArmWhenTheServerAbortsTheGoal) {
  begin();
  move();
  robot_->order("abort -4 joint l_base deviates by 0.2");
  stops(
      "the controller /cell/joint_trajectory_controller has aborted the trajectory: the arm left its tolerance on the "
      "path: look what blocks it, and compare the limits (\"joint l_base deviates by 0.2\")");
  resumes(msg::CauseKind::CAUSE_PROGRAM_STOPPED);
}

TEST_P(Ros2ControlAction, NamesEachResultOfTheServer) {
  const std::vector<std::pair<std::string, std::string>> results{
      {"-1 bad", "it is no valid goal for the controller"},
      {"-2 bad", "the controller has other joints: set joints or joint_prefix"},
      {"-3 bad", "its start has passed: compare the clocks"},
      {"-5 bad", "did not arrive within its tolerance"},
      {"-7 no such code", "(\"no such code\")"},
      {"0", "no reason is given: see the log of the controller"},
  };
  begin();
  for (const auto& [result, words] : results) {
    move();
    robot_->order("abort " + result);
    stops(words);
    resume();
  }
}

TEST_P(Ros2ControlAction, HoldsTheArmWhenTheServerRefusesTheFirstGoal) {
  begin();
  robot_->order("deactivate");
  stops("refuses a trajectory: activate it in ROS 2");
  robot_->order("activate");
  resumes(msg::CauseKind::CAUSE_PROGRAM_STOPPED);
}

TEST_P(Ros2ControlAction, HoldsTheArmWhenTheServerDoesNotAnswer) {
  begin();
  move();
  robot_->order("deaf on");
  stops("has not answered a trajectory for 10");
}

TEST_P(Ros2ControlAction, CancelsItsGoalWhenItStops) {
  begin();
  move();
  device_->stop("a test");
  ASSERT_TRUE(until([this] { return robot_->state().at("cancels") == 1; })) << robot_->state();
  EXPECT_TRUE(stands() || until([this] { return stands(); }));
}

/// The finger of the arm is joint 1 of two outside the chain.
class Ros2ControlGripper : public Ros2ControlDevice {
 protected:
  void SetUp() override {
    fingers_ = {"lid", "finger"};
    begin(
        {"--kind", "trajectory", "--gripper", GetParam(), "--finger", "l_finger"},
        {{"interface", "trajectory"}, {"gripper_controller", "gripper_controller"}, {"gripper_interface", GetParam()}});
    ASSERT_TRUE(until([this] { return !device_->outside().empty(); }));
  }
  device::OrderEnd moved(double to, double force = -1.0) {
    std::optional<device::OrderEnd> end;
    until([&] {
      // Discovery of the controller takes a moment.
      const auto refused = device_->move_outside({0.0, to}, force);
      return !refused || refused->text.find("activate") == std::string::npos;
    });
    until([&] { return (end = device_->outside_end()).has_value(); });
    return *end;
  }
};
INSTANTIATE_TEST_SUITE_P(Interfaces, Ros2ControlGripper, testing::Values("action", "position"),
                         [](const auto& test) { return test.param; });

TEST_P(Ros2ControlGripper, MovesItsFingersAndMeasuresThem) {
  EXPECT_NEAR(device_->outside()[1], 0.05, 1e-9);
  EXPECT_FALSE(moved(0.01, 25.0).result);
  EXPECT_NEAR(robot_->state().at("finger").get<double>(), 0.01, 1.1e-3);
  EXPECT_TRUE(until([this] { return std::abs(device_->outside()[1] - 0.01) < 1.1e-3; }));
  EXPECT_EQ(robot_->state().at("effort"), action() ? 25.0 : -1.0);
  EXPECT_FALSE(moved(0.05).result);
  EXPECT_EQ(robot_->state().at("effort"), action() ? 10.0 : -1.0) << "the default";
}

TEST_P(Ros2ControlGripper, EndsWhereAnObjectStopsItsFingers) {
  robot_->order("object 0.02");
  EXPECT_FALSE(moved(0.0).result);
  EXPECT_NEAR(robot_->state().at("finger").get<double>(), 0.02, 1e-9);
}

TEST_P(Ros2ControlGripper, NamesAControllerThatDoesNotMoveIt) {
  ASSERT_FALSE(moved(0.04).result);
  robot_->order("gripper off");
  const auto end = moved(0.0);
  ASSERT_TRUE(end.result);
  EXPECT_NE(
      end.result->text.find(action() ? "refuses the order: activate it in ROS 2" : "activate /cell/gripper_controller"),
      std::string::npos)
      << end.result->text;
}

}  // namespace
}  // namespace hecaton::services
