// The device of ros2_control without a network: keys, messages, and the watch on its motion.
#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "planner/model/robot_model.hpp"
#include "planner/trajectory/stop_profile.hpp"
#include "services/arm_driver/devices/ros2_control/commands.hpp"
#include "services/arm_driver/devices/ros2_control/joint_states.hpp"
#include "services/arm_driver/devices/ros2_control/motion_watch.hpp"
#include "services/arm_driver/devices/ros2_control/options.hpp"
#include "services/arm_driver/devices/ros2_control/ros2_control_arm.hpp"
#include "services/arm_driver/devices/ros2_control/state_watch.hpp"
#include "services/arm_driver/devices/ros2_control/velocity_commands.hpp"
#include "services/ros2_messages/cdr.hpp"
#include "services/ros2_messages/time.hpp"

namespace hecaton::services {
namespace {

using namespace std::chrono_literals;
namespace rc = device::ros2_control;

constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();

device::DeviceSetup ros2_control_setup(const std::map<std::string, std::string>& keys) {
  device::DeviceSetup setup;
  setup.arm = "south";
  setup.joint_names = {"base", "elbow", "wrist"};
  setup.limits.lower = device::JointVector::Constant(3, -3.0);
  setup.limits.upper = device::JointVector::Constant(3, 3.0);
  setup.limits.velocity = device::JointVector::Constant(3, 1.0);
  setup.limits.acceleration = device::JointVector::Constant(3, 4.0);
  setup.period = 4ms;
  setup.command_timeout = 50ms;
  setup.where = "cell.yaml: arms[0].device";
  setup.values = {keys.begin(), keys.end()};
  return setup;
}

std::string ros2_control_refusal(const std::map<std::string, std::string>& keys) {
  try {
    (void)make_ros2_control_arm(ros2_control_setup(keys));
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "nothing";
}

TEST(Ros2ControlOptions, HasTheNamesOfRos2AsDefaults) {
  const rc::Options options = rc::read_options(ros2_control_setup({}));
  EXPECT_EQ(options.domain, 0);
  EXPECT_EQ(options.interface, rc::Interface::kTrajectory);
  EXPECT_EQ(options.controller, "/joint_trajectory_controller");
  EXPECT_EQ(options.joint_states, "/joint_states");
  EXPECT_EQ(options.joints, (std::vector<std::string>{"base", "elbow", "wrist"}));
  EXPECT_FALSE(options.speed_scaling);
  EXPECT_DOUBLE_EQ(options.lookahead, 0.1);
  EXPECT_DOUBLE_EQ(options.tracking_delay, 0.15);
}

TEST(Ros2ControlOptions, PutsRelativeNamesIntoTheNamespace) {
  const rc::Options options = rc::read_options(ros2_control_setup({{"namespace", "/cell/left"},
                                                                   {"interface", "position"},
                                                                   {"joint_prefix", "left_"},
                                                                   {"joint_states", "/joint_states"},
                                                                   {"speed_scaling", "scaling"},
                                                                   {"tracking_delay", "20ms"}}));
  EXPECT_EQ(options.controller, "/cell/left/forward_position_controller");
  EXPECT_EQ(options.joint_states, "/joint_states");
  EXPECT_EQ(options.speed_scaling, "/cell/left/scaling");
  EXPECT_EQ(options.joints, (std::vector<std::string>{"left_base", "left_elbow", "left_wrist"}));
  EXPECT_DOUBLE_EQ(options.tracking_delay, 0.02);
  const rc::Options named = rc::read_options(ros2_control_setup({{"joints", "a, b c"}, {"controller", "/x/y"}}));
  EXPECT_EQ(named.joints, (std::vector<std::string>{"a", "b", "c"}));
  EXPECT_EQ(named.controller, "/x/y");
}

TEST(Ros2ControlOptions, RefusesWrongKeys) {
  const std::string where = "cell.yaml: arms[0].device.";
  EXPECT_EQ(ros2_control_refusal({}), "nothing");
  EXPECT_EQ(ros2_control_refusal({{"domain", "200"}}), where + "domain = 200 must be 0 to 199");
  EXPECT_EQ(ros2_control_refusal({{"domain", "1.5"}}), where + "domain = 1.5 must be a whole number");
  EXPECT_EQ(ros2_control_refusal({{"interface", "effort"}}),
            where + "interface = effort must be position, velocity, trajectory or action");
  EXPECT_EQ(ros2_control_refusal({{"namespace", "left"}}),
            where + "namespace = left must be a namespace of ROS 2, such as /left");
  EXPECT_EQ(ros2_control_refusal({{"controller", "my controller"}}),
            where +
                "controller = my controller must be a name of ROS 2, such as joint_trajectory_controller or "
                "/left/joint_trajectory_controller");
  EXPECT_EQ(ros2_control_refusal({{"joint_states", "//a"}}),
            where + "joint_states = //a must be a name of ROS 2, such as joint_states or /left/joint_states");
  for (const char* joints : {"a, b", "a, b, b", "a, b, c, d", ""}) {
    EXPECT_EQ(ros2_control_refusal({{"joints", joints}}),
              where + "joints = " + joints +
                  " must be 3 different names between commas, for the joints of arm south from base to tip");
  }
  EXPECT_EQ(ros2_control_refusal({{"joints", "a, b, c"}, {"joint_prefix", "p_"}}),
            where + "joint_prefix = p_ must be absent beside the key joints");
  EXPECT_EQ(ros2_control_refusal({{"lookahead", "2s"}}), where + "lookahead = 2s must be 0.02s to 0.5s");
  EXPECT_EQ(ros2_control_refusal({{"lookahead", "0.1s"}, {"interface", "position"}}),
            where + "lookahead = 0.1s must be absent beside interface: position");
  EXPECT_EQ(ros2_control_refusal({{"lookahead", "0.1s"}, {"interface", "velocity"}}),
            where + "lookahead = 0.1s must be absent beside interface: velocity");
  EXPECT_EQ(ros2_control_refusal({{"tracking_delay", "-1s"}}), where + "tracking_delay = -1s must be 0s to 1s");
  EXPECT_EQ(ros2_control_refusal({{"address", "localhost"}}),
            where + "address = localhost must be an IPv4 address, such as 192.168.0.10");
}

TEST(Ros2ControlOptions, SendsFewerGoalsOfAnAction) {
  const rc::Options options = rc::read_options(ros2_control_setup({{"interface", "action"}}));
  EXPECT_EQ(options.interface, rc::Interface::kAction);
  EXPECT_EQ(options.controller, "/joint_trajectory_controller");
  EXPECT_DOUBLE_EQ(options.lookahead, 0.2);
  EXPECT_DOUBLE_EQ(options.tracking_delay, 0.25);
}

TEST(Ros2ControlOptions, HasNoLookaheadWithVelocities) {
  const rc::Options options = rc::read_options(ros2_control_setup({{"interface", "velocity"}}));
  EXPECT_EQ(options.interface, rc::Interface::kVelocity);
  EXPECT_EQ(options.controller, "/forward_velocity_controller");
  EXPECT_DOUBLE_EQ(options.tracking_delay, 0.05);
}

TEST(Ros2ControlOptions, SaysThatAVelocityControllerGoesOnWithoutADriver) {
  const auto notes = ros2_control_notes(ros2_control_setup({{"interface", "velocity"}}), planner::RobotModel());
  EXPECT_EQ(notes.front(),
            "arm south: its driver sends to /forward_velocity_controller/commands and reads /joint_states in domain 0 "
            "of ROS 2; its joints there are base, elbow, wrist");
  EXPECT_EQ(notes.back(),
            "arm south: when its driver dies, or a cable is cut, the arm goes on at its last velocity, until a driver "
            "that was restarted stops it, or the hardware does; interface: trajectory brakes instead");
}

TEST(Ros2ControlOptions, NeedsTheControllerOfAGripper) {
  auto setup = ros2_control_setup({{"namespace", "/left"}, {"joint_prefix", "l_"}, {"gripper_controller", "hand"}});
  setup.outside_names = {"lid", "finger"};
  setup.fingers = {false, true};
  const auto gripper = rc::read_options(setup).gripper;
  ASSERT_TRUE(gripper);
  EXPECT_EQ(gripper->controller, "/left/hand");
  EXPECT_TRUE(gripper->action);
  EXPECT_EQ(gripper->joints, (std::vector<std::string>{"l_finger"}));
  EXPECT_DOUBLE_EQ(gripper->effort, 10.0);
  EXPECT_EQ(ros2_control_claims(setup).back().what, "/left/hand in domain 0 of ROS 2");

  const auto refusal = [&](const std::map<std::string, std::string>& keys) {
    setup.values = {keys.begin(), keys.end()};
    try {
      (void)rc::read_options(setup);
    } catch (const std::runtime_error& error) {
      return std::string(error.what());
    }
    return std::string("nothing");
  };
  const std::string where = "cell.yaml: arms[0].device.";
  EXPECT_EQ(refusal({}), where +
                             "gripper_controller is missing: the name of the controller in ROS 2 that moves the "
                             "gripper of arm south");
  EXPECT_EQ(refusal({{"gripper_controller", "hand"}, {"gripper_interface", "effort"}}),
            where + "gripper_interface = effort must be action or position");
  EXPECT_EQ(refusal({{"gripper_controller", "hand"}, {"gripper_joints", "a, b"}}),
            where + "gripper_joints = a, b must be 1 name, for the fingers of arm south");
  EXPECT_EQ(refusal({{"gripper_controller", "hand"}, {"gripper_interface", "position"}, {"gripper_effort", "5"}}),
            where + "gripper_effort = 5 must be absent beside gripper_interface: position");
  EXPECT_EQ(ros2_control_refusal({{"gripper_effort", "5"}}),
            where + "gripper_effort = 5 must be absent: arm south has no key gripper with a joint");
}

// --- joint states

class Ros2JointStates : public testing::Test {
 protected:
  static bus::EndpointId writer(std::uint8_t number) {
    bus::EndpointId id;
    id.bytes[0] = number;
    return id;
  }
  /// A message that was sent and received at `at` [s].
  void take(const std::vector<std::string>& names, const std::vector<double>& q, const std::vector<double>& qd,
            double at, std::uint8_t from = 1) {
    ros2::JointState message;
    message.header.stamp = {100 + static_cast<std::int32_t>(at), static_cast<std::uint32_t>(std::fmod(at, 1.0) * 1e9)};
    message.name = names;
    message.position = q;
    message.velocity = qd;
    states_.take(ros2::encoded(message), writer(from), time(at));
  }
  static device::Clock::time_point time(double at) {
    return device::Clock::time_point(
        std::chrono::duration_cast<device::Clock::duration>(std::chrono::duration<double>(1000.0 + at)));
  }
  [[nodiscard]] bool complains(const std::string& words) const {
    return states_.complaint().find(words) != std::string::npos;
  }

  rc::JointStates states_{{"base", "elbow", "wrist"}, 50ms};
};

TEST_F(Ros2JointStates, FindsItsJointsInAnyOrderBesideOthers) {
  take({"finger", "wrist", "base", "other_base", "elbow"}, {9, 3, 1, 9, 2}, {9, 0.3, 0.1, 9, 0.2}, 0.0);
  const device::JointState state = states_.measured();
  ASSERT_EQ(state.q.size(), 3);
  EXPECT_EQ(state.q, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(state.qd, Eigen::Vector3d(0.1, 0.2, 0.3));
  EXPECT_EQ(states_.received(), time(0.0));
  EXPECT_EQ(states_.complaint(), "");
}

TEST_F(Ros2JointStates, CollectsPartialMessagesAndReportsTheOldestJoint) {
  take({"base", "elbow"}, {1, 2}, {0, 0}, 0.0);
  EXPECT_EQ(states_.measured().q.size(), 0);
  take({"wrist"}, {3}, {0}, 0.01);
  EXPECT_EQ(states_.measured().q, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(states_.received(), time(0.0));
  take({"base", "elbow"}, {1.5, 2.5}, {0, 0}, 0.02);
  EXPECT_EQ(states_.measured().q, Eigen::Vector3d(1.5, 2.5, 3));
  EXPECT_EQ(states_.received(), time(0.01));
}

TEST_F(Ros2JointStates, DifferentiatesPositionsWithoutVelocities) {
  const std::vector<std::string> names{"base", "elbow", "wrist"};
  take(names, {1, 2, 3}, {}, 0.0);
  EXPECT_EQ(states_.measured().q.size(), 0) << "the velocity is not known yet";
  take(names, {1.01, 2, 2.98}, {kNoNumber, 7.0, kNoNumber}, 0.01);
  const device::JointState state = states_.measured();
  ASSERT_EQ(state.qd.size(), 3);
  EXPECT_NEAR(state.qd[0], 1.0, 1e-6);  // 0.01 rad in 10 ms
  EXPECT_EQ(state.qd[1], 7.0);
  EXPECT_NEAR(state.qd[2], -2.0, 1e-6);
  take(names, {1.5, 2, 3}, {}, 5.0);
  EXPECT_EQ(states_.measured().q.size(), 0) << "after a long gap the velocity is not known";
}

TEST_F(Ros2JointStates, KeepsTheAgeOfAJointWhosePositionIsNoNumber) {
  const std::vector<std::string> names{"base", "elbow", "wrist"};
  take(names, {1, 2, 3}, {0, 0, 0}, 0.0);
  take(names, {1, kNoNumber, 3}, {0, 0, 0}, 0.01);
  EXPECT_EQ(states_.measured().q, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(states_.received(), time(0.0));
  EXPECT_TRUE(complains("have no number as the position of elbow")) << states_.complaint();
  take(names, {1, 2, 3}, {0, 0, 0}, 0.02);
  EXPECT_EQ(states_.received(), time(0.02));
  EXPECT_EQ(states_.complaint(), "");
}

TEST_F(Ros2JointStates, NamesMissingJointsAndWhatThereIsInstead) {
  take({"base", "arm\n2", "wrist"}, {1, 2, 3}, {0, 0, 0}, 0.0);
  EXPECT_EQ(states_.measured().q.size(), 0);
  EXPECT_EQ(states_.complaint(), "the messages there lack elbow, and have base, arm?2, wrist");
}

TEST_F(Ros2JointStates, RefusesMessagesWithWrongSizesOrRepeatedNames) {
  take({"base", "elbow", "wrist"}, {1, 2}, {}, 0.0);
  EXPECT_TRUE(complains("no valid JointState")) << states_.complaint();
  take({"base", "elbow", "wrist", "base"}, {1, 2, 3, 4}, {0, 0, 0, 0}, 0.01);
  EXPECT_TRUE(complains("no valid JointState")) << states_.complaint();
  EXPECT_EQ(states_.measured().q.size(), 0);
  take({"base", "elbow", "wrist"}, {1, 2, 3}, {0, 0}, 0.02);  // velocities that belong to no joint
  take({"base", "elbow", "wrist"}, {1, 2, 3}, {0, 0}, 0.03);
  EXPECT_EQ(states_.measured().qd, Eigen::Vector3d(0, 0, 0));
}

TEST_F(Ros2JointStates, ReportsAJointOfTwoWritersAndBelievesTheFirst) {
  const std::vector<std::string> names{"base", "elbow", "wrist"};
  take(names, {1, 2, 3}, {0, 0, 0}, 0.0);
  take(names, {7, 8, 9}, {0, 0, 0}, 0.01, 2);
  EXPECT_EQ(states_.measured().q, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(states_.twice_published(time(0.02)), "wrist") << "one of them";
  EXPECT_TRUE(states_.twice_published(time(1.9)));
  EXPECT_FALSE(states_.twice_published(time(2.1)));
  take(names, {7, 8, 9}, {0, 0, 0}, 2.2, 2);
  EXPECT_EQ(states_.measured().q, Eigen::Vector3d(7, 8, 9)) << "the first writer has been silent";
  EXPECT_FALSE(states_.twice_published(time(2.2)));
}

TEST_F(Ros2JointStates, SurvivesRandomBytes) {
  std::mt19937 random(35);
  ros2::JointState message;
  message.name = {"base", "elbow", "wrist"};
  message.position = {1, 2, 3};
  message.velocity = {0, 0, 0};
  const ros2::Bytes good = ros2::encoded(message);
  for (int i = 0; i < 100'000; ++i) {
    ros2::Bytes bytes = good;
    for (int changes = 0; changes < 3; ++changes) bytes[random() % bytes.size()] = static_cast<std::uint8_t>(random());
    if (random() % 4 == 0) bytes.resize(random() % bytes.size());
    states_.take(bytes, writer(1), time(1e-3 * i));
    const device::JointState state = states_.measured();
    ASSERT_TRUE(state.q.allFinite() && state.qd.allFinite());
    for (const char c : states_.complaint()) ASSERT_TRUE(c < 0 || c >= ' ') << i;
  }
}

// --- commands

TEST(Ros2ControlCommands, EndsEachTrajectoryAtRestOnTheStopProfile) {
  const auto limits = ros2_control_setup({}).limits;
  const device::JointState moving{Eigen::Vector3d(0.1, 0.2, 0.3), Eigen::Vector3d(0.8, -0.4, 0.0)};
  const ros2::JointTrajectory message = rc::stopping_trajectory({"a", "b", "c"}, moving, 0.1, limits);
  EXPECT_EQ(message.joint_names, (std::vector<std::string>{"a", "b", "c"}));
  EXPECT_EQ(message.header.stamp.sec, 0) << "it starts when it arrives";
  ASSERT_EQ(message.points.size(), 2U);
  EXPECT_EQ(message.points[0].positions, (std::vector<double>{0.1, 0.2, 0.3}));
  EXPECT_EQ(message.points[0].velocities, (std::vector<double>{0.8, -0.4, 0.0}));
  EXPECT_NEAR(ros2::seconds_of(message.points[0].time_from_start), 0.1, 1e-8);
  // 0.8 rad/s with 4 rad/s²: 0.2 s, in which the first joint goes 0.08 rad, and the second half of it.
  EXPECT_NEAR(ros2::seconds_of(message.points[1].time_from_start), 0.3, 1e-8);
  EXPECT_NEAR(message.points[1].positions[0], 0.18, 1e-9);
  EXPECT_NEAR(message.points[1].positions[1], 0.16, 1e-9);
  EXPECT_EQ(message.points[1].velocities, (std::vector<double>{0, 0, 0}));
}

TEST(Ros2ControlCommands, StopsWithinThePositionLimits) {
  const auto limits = ros2_control_setup({}).limits;
  const device::JointState moving{Eigen::Vector3d(2.99, 0, 0), Eigen::Vector3d(0.8, 0, 0)};
  const ros2::JointTrajectory message = rc::stopping_trajectory({"a", "b", "c"}, moving, 0.1, limits);
  EXPECT_EQ(message.points.back().positions[0], 3.0);
}

TEST(Ros2ControlCommands, SendsASetPointAtRestAsOnePoint) {
  const auto limits = ros2_control_setup({}).limits;
  const device::JointState rest{Eigen::Vector3d(0.1, 0.2, 0.3), Eigen::Vector3d::Zero()};
  const ros2::JointTrajectory message = rc::stopping_trajectory({"a", "b", "c"}, rest, 0.1, limits);
  ASSERT_EQ(message.points.size(), 1U);
  EXPECT_EQ(message.points[0].velocities, (std::vector<double>{0, 0, 0}));
  EXPECT_EQ(rc::values_of(rest.q).data, (std::vector<double>{0.1, 0.2, 0.3}));
}

// --- velocities

/// A joint with limits of ±3 rad, 1 rad/s and 4 rad/s² in periods of 4 ms, whose servo of velocities has a lag.
class Ros2ControlVelocities : public testing::Test {
 protected:
  Ros2ControlVelocities() { velocities_.begin(q_, at_); }

  /// A period: the set-point goes on at `speed` [rad/s].
  void follow(double speed) { follow_to(set_point_ + speed * 4e-3, speed); }
  /// A period: the set-point is there, with this velocity.
  void follow_to(double position, double speed) {
    at_ += 4ms;
    set_point_ = position;
    const device::JointState set_point{device::JointVector::Constant(1, set_point_),
                                       device::JointVector::Constant(1, speed)};
    const double before = velocities_.last()[0];
    const double velocity = velocities_.follow(set_point, at_ + 4ms, {q_, at_}, scaling_, at_)[0];
    largest_ = std::max(largest_, std::abs(velocity));
    largest_change_ = std::max(largest_change_, std::abs(velocity - before));
    move(velocity);
  }
  void follow(double speed, double seconds) {
    for (double t = 0.0; t < seconds; t += 4e-3) follow(speed);
  }
  void move(double velocity) {
    qd_ += (executed_ * scaling_ * velocity - qd_) * (1.0 - std::exp(-4e-3 / servo_));
    q_[0] += qd_ * 4e-3;
  }
  static device::JointLimits limits() {
    device::JointLimits limits;
    limits.lower = device::JointVector::Constant(1, -3.0);
    limits.upper = device::JointVector::Constant(1, 3.0);
    limits.velocity = device::JointVector::Constant(1, 1.0);
    limits.acceleration = device::JointVector::Constant(1, 4.0);
    return limits;
  }

  rc::VelocityCommands velocities_{limits(), 0.05};
  device::Clock::time_point at_ = device::Clock::time_point(100s);
  device::JointVector q_ = device::JointVector::Zero(1);
  double qd_ = 0.0, set_point_ = 0.0, scaling_ = 1.0;
  double servo_ = 0.05;    ///< time constant [s]
  double executed_ = 1.0;  ///< share of a velocity that the arm executes in spite of its controller
  double largest_ = 0.0, largest_change_ = 0.0;
};

TEST_F(Ros2ControlVelocities, FollowWithTheLagOfTheArm) {
  follow(0.8, 2.0);
  EXPECT_NEAR(qd_, 0.8, 1e-3);
  EXPECT_NEAR(set_point_ - q_[0], 0.8 * 0.05, 0.005);
  EXPECT_LE(largest_change_, 2.0 * 4.0 * 4e-3 + 1e-12) << "twice the acceleration limit";
  follow(0.0, 2.0);
  EXPECT_NEAR(q_[0], set_point_, 1e-4);
  EXPECT_NEAR(velocities_.last()[0], 0.0, 1e-3);
  EXPECT_FALSE(velocities_.lost());
}

TEST_F(Ros2ControlVelocities, KeepTheLagOfTheArmWhenCommandsAreLate) {
  for (int period = 1; period <= 600; ++period) {
    // Each third command is late: the set-point stops at once at this speed, and is where it should be a period later.
    const double due = 0.016 * 4e-3 * period;
    if (period % 3 == 0) follow_to(set_point_, 0.0);
    if (period % 3 != 0) follow_to(due, 0.016);
  }
  EXPECT_NEAR(set_point_ - q_[0], 0.016 * 0.05, 2e-4);
}

TEST_F(Ros2ControlVelocities, BringBackAnArmThatDrifts) {
  q_[0] = 0.05;
  follow(0.0, 1.5);
  EXPECT_NEAR(q_[0], 0.0, 1e-3);
  EXPECT_LE(largest_, 0.25 + 1e-12) << "a quarter of the limit";
  EXPECT_FALSE(velocities_.lost());
}

TEST_F(Ros2ControlVelocities, MakeUpForHardwareThatSlowsTheArm) {
  scaling_ = 0.5;
  follow(0.4, 3.0);
  EXPECT_NEAR(qd_, 0.4, 1e-3);
  EXPECT_NEAR(set_point_ - q_[0], 0.4 * rc::VelocityCommands::delay(0.05, 0.5), 0.01);
  EXPECT_FALSE(velocities_.lost());
}

TEST_F(Ros2ControlVelocities, NeverExceedTheVelocityLimit) {
  q_[0] = -0.05;  // behind its set-points
  follow(1.0, 0.5);
  EXPECT_LE(largest_, 1.0);
}

TEST_F(Ros2ControlVelocities, StopBeforeThePositionLimit) {
  q_[0] = set_point_ = 2.9;
  velocities_.begin(q_, at_);
  follow(1.0, 0.3);  // leads beyond the limit
  EXPECT_LT(q_[0], 3.0 + 0.02) << "within the lag of the servo";
}

TEST_F(Ros2ControlVelocities, FindAnArmThatDoesNotFollow) {
  executed_ = 0.0;
  follow(0.5, 0.3);
  EXPECT_FALSE(velocities_.lost()) << "it may be late";
  follow(0.5, 0.7);
  ASSERT_TRUE(velocities_.lost());
  EXPECT_EQ(velocities_.lost()->joint, 0);
  EXPECT_NEAR(velocities_.lost()->limit, 0.05, 1e-9);  // the correction of a quarter of 1 rad/s
  EXPECT_GT(velocities_.lost()->distance, 0.05);
  velocities_.begin(q_, at_);
  EXPECT_FALSE(velocities_.lost());
}

TEST_F(Ros2ControlVelocities, FindAnArmThatMovesTheOtherWay) {
  executed_ = -1.0;
  for (double t = 0.0; t < 2.0 && !velocities_.lost(); t += 4e-3) follow(0.5);
  EXPECT_TRUE(velocities_.lost());
  EXPECT_LT(std::abs(q_[0]), 0.3);
}

TEST_F(Ros2ControlVelocities, BringBackAnArmThatWentOnWhileTheDriverStalled) {
  q_[0] = 0.3;
  follow(0.0, 4.0);
  EXPECT_FALSE(velocities_.lost()) << "it comes nearer";
  EXPECT_NEAR(q_[0], 0.0, 1e-3);
}

TEST_F(Ros2ControlVelocities, BrakeOnTheStopProfile) {
  follow(0.8, 1.0);
  double time = 0.0;
  for (double v = velocities_.last()[0]; v > 0.0 && time < 1.0; time += 4e-3) {
    at_ += 4ms;
    const double next = velocities_.brake(at_)[0];
    EXPECT_NEAR(v - next, std::min(v, 4.0 * 4e-3), 1e-9);
    v = next;
  }
  EXPECT_NEAR(time, 0.2, 0.01);
}

// --- motion

/// The longest silence after a second of states in this period, for a controller that may be late for 50 ms.
std::chrono::milliseconds longest_silence(std::chrono::milliseconds period, std::chrono::milliseconds late = 50ms) {
  rc::StateWatch watch(late);
  device::Clock::time_point at{100s};
  EXPECT_TRUE(watch.is_silent(at)) << "nothing has come yet";
  for (int states = 0; states < 20; ++states) watch.add(at += period);
  std::chrono::milliseconds silence{0};
  while (!watch.is_silent(at + silence)) ++silence;
  return silence - 1ms;
}

TEST(Ros2ControlStates, NoticeAPauseOfSomePeriods) {
  EXPECT_EQ(longest_silence(20ms), 200ms) << "the usual rate; a shorter pause may be a busy machine";
  EXPECT_EQ(longest_silence(4ms), 200ms);
  EXPECT_EQ(longest_silence(100ms), 500ms);
  EXPECT_EQ(longest_silence(500ms), 1000ms);
  EXPECT_EQ(longest_silence(20ms, 300ms), 300ms) << "the cell allows later states";
}

TEST(Ros2ControlStates, ForgiveLateStatesAndKnowTheRateAfterAPause) {
  rc::StateWatch watch(50ms);
  device::Clock::time_point at{100s};
  watch.add(at);
  EXPECT_EQ(watch.limit(), 1s) << "the rate is not known yet";
  for (int states = 0; states < 200; ++states) {
    watch.add(at += states % 10 == 0 ? 150ms : 5ms);
    ASSERT_FALSE(watch.is_silent(at + 150ms)) << states;
  }
  EXPECT_TRUE(watch.is_silent(at + 600ms)) << "a deactivation of less than a second";
  watch.add(at += 10s);
  EXPECT_FALSE(watch.is_silent(at + 100ms));
  EXPECT_TRUE(watch.is_silent(at + 600ms));
}

/// Runs two seconds of a joint whose set-point moves at `speed` [rad/s]; the arm follows with `delay` [s], or not at
/// all.
std::optional<Eigen::Index> watched(double speed, double delay, bool follows) {
  rc::MotionWatch watch;
  std::optional<Eigen::Index> idle;
  for (double t = 0.0; t < 2.0 && !idle; t += 0.004) {
    const double measured = follows ? std::max(0.0, speed * (t - delay)) : 0.0;
    watch.add(device::Clock::time_point(
                  std::chrono::duration_cast<device::Clock::duration>(std::chrono::duration<double>(t))),
              Eigen::Vector2d(1.0, speed * t), Eigen::Vector2d(1.0, measured), 0.1);
    idle = watch.idle_joint();
  }
  return idle;
}

TEST(Ros2ControlMotion, ReportsAJointThatStandsAlthoughItsSetPointMoves) {
  EXPECT_EQ(watched(0.3, 0.0, false), 1);
  EXPECT_EQ(watched(3.0, 0.0, false), 1);
}

TEST(Ros2ControlMotion, AcceptsAJointThatLagsOrWhoseSetPointStands) {
  EXPECT_FALSE(watched(0.3, 0.15, true));
  EXPECT_FALSE(watched(3.0, 0.15, true));
  EXPECT_FALSE(watched(0.0, 0.0, false));
  EXPECT_FALSE(watched(0.01, 0.0, false)) << "too little to judge";
}

}  // namespace
}  // namespace hecaton::services
