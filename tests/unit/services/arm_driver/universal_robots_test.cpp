// The device of Universal Robots against the controller of tests/robots/ur_controller.py, without a cell.
#include <array>
#include <cmath>
#include <fstream>
#include <functional>
#include <iterator>
#include <random>
#include <thread>

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include "planner/model/fixed_links.hpp"
#include "planner/model/robot_model.hpp"
#include "planner/model/urdf_loader.hpp"
#include "services/arm_driver/device_session.hpp"
#include "services/arm_driver/devices/universal_robots/program.hpp"
#include "services/arm_driver/devices/universal_robots/robot_state.hpp"
#include "services/arm_driver/devices/universal_robots/robot_type.hpp"
#include "services/arm_driver/devices/universal_robots/rtde.hpp"
#include "services/arm_driver/devices/universal_robots/rtde_client.hpp"
#include "services/arm_driver/devices/universal_robots/tcp.hpp"
#include "services/arm_driver/devices/universal_robots/universal_robots_arm.hpp"
#include "tests/support/driven_robot.hpp"
#include "tests/support/temporary_folder.hpp"

namespace hecaton::services {
namespace {

using namespace std::chrono_literals;
using device::JointVector;
using msg::CauseKind;
using Clock = device::Clock;

constexpr auto kRobotPeriod = 2ms;
constexpr auto kLostAdvice =
    "is its cable out, or is its controller off? Once it works again, call 'hecaton resume north'";
constexpr double kSecondJoint = -0.4;  // speed of the second joint, as a share of the first one's

device::DeviceSetup setup_for(const std::string& address, const std::map<std::string, std::string>& keys = {}) {
  device::DeviceSetup setup;
  setup.arm = "north";
  setup.limits.lower = JointVector::Constant(6, -6.28);
  setup.limits.upper = JointVector::Constant(6, 6.28);
  setup.limits.velocity = JointVector::Constant(6, 3.0);
  setup.limits.acceleration = JointVector::Constant(6, 10.0);
  setup.period = kRobotPeriod;
  setup.command_timeout = 10s;
  setup.where = "cell.yaml: arms[0].device";
  // A busy machine may stop this process, or the robot's, for longer than the default time-outs.
  setup.values = {{"robot_ip", address}, {"timeout", "0.3"}};
  for (const auto& [key, value] : keys) setup.values[key] = value;
  return setup;
}

class UniversalRobotsTest : public test::DrivenRobot<testing::Test> {
 protected:
  UniversalRobotsTest() : DrivenRobot({.period = kRobotPeriod, .second_joint = kSecondJoint}) {}

  void begin(const std::vector<std::string>& options = {}, const std::map<std::string, std::string>& keys = {}) {
    robot_.emplace(options);
    device::DeviceSetup setup = setup_for(robot_->address(), keys);
    setup.signals = signals_;
    setup.robot_names = robot_names_;
    setup.command_timeout = command_timeout_;
    device_ = make_universal_robots_arm(setup);
    drive("north", 6, command_timeout_);
  }
  std::vector<std::string> signals_;      ///< ports
  std::vector<std::string> robot_names_;  ///< in the description
  std::chrono::milliseconds command_timeout_ = 10s;
  /// After "forget" and a resume, the first set-point is where the arm stands.
  void stays() {
    ASSERT_TRUE(until([this] { return robot_->state().at("first").is_number(); })) << text();
    const auto state = robot_->state();
    EXPECT_LT(state.at("first").get<double>(), 1e-5);
    EXPECT_LT(state.at("largest").get<double>(), 1e-5);
    EXPECT_LT(state.at("fastest").get<double>(), 0.01);
  }
  device::DeviceResult order(device::DeviceOrder what) {
    if (auto refused = device_->begin(what)) return refused;
    std::optional<device::OrderEnd> end;
    EXPECT_TRUE(until([&] { return (end = device_->order_end()).has_value(); }));
    return end ? end->result : device::DeviceFailure{"no end"};
  }
};

TEST_F(UniversalRobotsTest, BeginsAtTheMeasuredPositionAndFollowsSetPoints) {
  begin();
  ASSERT_TRUE(until([this] { return session_->active(); })) << text();
  velocity_ = 0.5;
  const double from = q_[0];
  ASSERT_TRUE(until([&] { return q_[0] > from + 0.5; })) << text();
  velocity_ = 0.0;
  ASSERT_TRUE(until([&] { return std::abs(session_->state().measured.q[0] - q_[0]) < 1e-4; })) << text();
  const auto state = robot_->state();
  EXPECT_LT(state.at("first").get<double>(), 1e-5);
  EXPECT_LT(state.at("largest").get<double>(), 0.05);
  EXPECT_EQ(state.at("ignored"), 0);
  EXPECT_EQ(state.at("programs"), 1);
}

TEST_F(UniversalRobotsTest, StopsTheRobotWhenSetPointsCease) {
  begin();
  move();
  silent_ = true;
  ASSERT_TRUE(until([this] { return kind() == CauseKind::CAUSE_PROGRAM_STOPPED; }));
  EXPECT_TRUE(until([this] { return stands(); }));
  // 0.5 rad/s for 12 ms and a cycle, then braking with 10 rad/s².
  const double beyond = robot_->state().at("q")[0].get<double>() - q_[0];
  EXPECT_GT(beyond, 0.0);
  EXPECT_LT(beyond, 0.5 * 0.014 + 0.0125 + 0.001);
  // Both joints stop together, on a straight line in joint space.
  EXPECT_NEAR(robot_->state().at("q")[1].get<double>() - q_[1], kSecondJoint * beyond, 1e-3);
}

// An arm without a driver counts as braking with the acceleration of the cell file.
class UniversalRobotsEnd : public UniversalRobotsTest {
 protected:
  static constexpr double kFast = 2.5;  // [rad/s]

  /// The arm is fast when the driver's connection to the program ends.
  void stops_after(const std::function<void()>& end) {
    begin();
    run();
    velocity_ = kFast;
    const double from = q_[0];
    ASSERT_TRUE(until([&] { return session_->state().measured.q[0] > from + 0.5; })) << text();
    ASSERT_GT(robot_->state().at("fastest").get<double>(), 0.9 * kFast);
    period();  // the set-point is new
    end();
    ASSERT_TRUE(until_stands()) << robot_->state();
    // Valid for 12 ms, then from 2.5 rad/s with 10 rad/s². The servo lags, and never passes the set-points.
    const double beyond = robot_->state().at("q")[0].get<double>() - q_[0];
    EXPECT_LT(beyond, kFast * 0.016 + kFast * kFast / 20.0);
    EXPECT_GT(beyond, 0.8 * kFast * kFast / 20.0) << "no joint brakes harder than its limit";
    EXPECT_NEAR(robot_->state().at("q")[1].get<double>() - q_[1], kSecondJoint * beyond, 2e-3) << "a straight line";
    EXPECT_EQ(robot_->state().at("messages").size(), messages_) << robot_->state();
  }
  bool until_stands() {
    for (const auto end = Clock::now() + 60s; Clock::now() < end;) {
      const auto state = robot_->state();
      if (stands() && state.at("runtime_state") == kStopped) return true;
      std::this_thread::sleep_for(10ms);  // the simulated controller announces nothing
    }
    return false;
  }
  static constexpr int kStopped = 1;
  std::size_t messages_ = 0;  ///< of the program
};

TEST_F(UniversalRobotsEnd, StopsOnTheStopProfileWhenItsConnectionCloses) {
  messages_ = 1;  // set-points ceased
  stops_after([this] { robot_->order("drop_connections hecaton"); });
}

TEST_F(UniversalRobotsEnd, StopsOnTheStopProfileWhenTheDriverEnds) {
  stops_after([this] {
    session_.reset();
    device_.reset();
  });
}

TEST_F(UniversalRobotsTest, ProtectiveStopNeedsAnUnlockAndAResume) {
  begin({"--unlock-after", "1"});
  move();
  robot_->order("protective_stop");
  ASSERT_TRUE(until([this] { return kind() == CauseKind::CAUSE_PROTECTIVE_STOP; })) << text();
  EXPECT_NE(text().find("'hecaton device north unlock'"), std::string::npos) << text();
  ASSERT_TRUE(until([this] { return stands(); }));
  const auto early = order(device::DeviceOrder::kUnlock);
  if (early) {
    EXPECT_NE(early->text.find("Cannot unlock protective stop"), std::string::npos) << early->text;
  }
  ASSERT_TRUE(until([this] { return robot_->state().at("safety_mode") == 1 || !order(device::DeviceOrder::kUnlock); }));
  ASSERT_TRUE(until([this] { return session_->state().mode == device::DeviceMode::kReady; }));
  EXPECT_FALSE(session_->active());
  EXPECT_EQ(kind(), CauseKind::CAUSE_PROTECTIVE_STOP) << "held until a person resumes";
  EXPECT_EQ(robot_->state().at("programs"), 1);
  robot_->order("forget");
  resume();
  ASSERT_TRUE(until([this] { return session_->active(); })) << text();
  stays();
}

TEST_F(UniversalRobotsTest, UnlocksAfterItsDashboardHasClosedOrIsSilent) {
  begin({"--unlock-after", "0"});
  for (const auto& [lost, again] : {std::pair("drop_connections dashboard", "dashboard answers"),
                                    std::pair("dashboard silent", "dashboard answers")}) {
    move();
    const auto before = robot_->state();
    robot_->order("protective_stop");
    ASSERT_TRUE(until([this] { return kind() == CauseKind::CAUSE_PROTECTIVE_STOP; })) << text();
    robot_->order(lost);
    ASSERT_TRUE(until([&] { return robot_->state().at("dashboards") > before.at("dashboards"); })) << lost;
    robot_->order(again);
    ASSERT_TRUE(until([this] { return !order(device::DeviceOrder::kUnlock); })) << lost;
    ASSERT_TRUE(until([this] { return session_->state().mode == device::DeviceMode::kReady; })) << text();
    EXPECT_EQ(kind(), CauseKind::CAUSE_PROTECTIVE_STOP) << "the arm has not failed";
    robot_->order("forget");
    resume();
    ASSERT_TRUE(until([this] { return session_->active(); })) << text();
    stays();
  }
}

TEST_F(UniversalRobotsTest, KeepsThatRemoteControlIsOffWhileItsDashboardIsClosed) {
  begin();
  robot_->order("remote_control off");
  may_move_ = false;
  ASSERT_TRUE(until([this] { return kind() == CauseKind::CAUSE_REMOTE_CONTROL_OFF; })) << text();
  const auto before = robot_->state();
  robot_->order("drop_connections dashboard");
  bool known = true;
  ASSERT_TRUE(until([&] {
    known = known && kind() == CauseKind::CAUSE_REMOTE_CONTROL_OFF;
    return robot_->state().at("dashboards") > before.at("dashboards");
  }));
  EXPECT_TRUE(known) << text();
  may_move_ = true;
  robot_->order("remote_control on");
  resume();
  EXPECT_TRUE(until([this] { return session_->active(); })) << text();
}

TEST_F(UniversalRobotsTest, ReportsEachStopWithItsKind) {
  begin();
  run();
  for (const auto& [stop, expected, undo] :
       {std::tuple("safeguard open", CauseKind::CAUSE_SAFEGUARD_STOP, "safeguard closed"),
        std::tuple("pause_program", CauseKind::CAUSE_PROGRAM_STOPPED, "play_program"),
        std::tuple("stop_program", CauseKind::CAUSE_PROGRAM_STOPPED, "play_program")}) {
    robot_->order(stop);
    ASSERT_TRUE(until([&, kind = expected] { return this->kind() == kind; })) << stop << ": " << text();
    EXPECT_NE(text().find("'hecaton resume north'"), std::string::npos) << text();
    robot_->order(undo);
    ASSERT_TRUE(until([this] { return session_->state().mode == device::DeviceMode::kReady; })) << stop << text();
    resume();
    ASSERT_TRUE(until([this] { return session_->active(); })) << stop << ": " << text();
  }
}

TEST_F(UniversalRobotsTest, EmergencyStopNeedsPowerAndAResume) {
  begin();
  move();
  robot_->order("emergency_stop");
  ASSERT_TRUE(until([this] { return kind() == CauseKind::CAUSE_EMERGENCY_STOP; })) << text();
  robot_->order("release_emergency_stop");
  ASSERT_TRUE(until([this] { return kind() == CauseKind::CAUSE_DEVICE_NOT_READY; })) << text();
  EXPECT_FALSE(order(device::DeviceOrder::kPowerOn)) << "taken";
  ASSERT_TRUE(until([this] { return session_->state().mode == device::DeviceMode::kReady; })) << text();
  EXPECT_FALSE(session_->active());
  resume();
  EXPECT_TRUE(until([this] { return session_->active(); })) << text();
}

TEST_F(UniversalRobotsTest, ReleasesTheBrakesOnlyOnAnOrderAfterAStop) {
  begin({"--off", "--boots-never"});
  ASSERT_TRUE(until([this] { return kind() == CauseKind::CAUSE_DEVICE_NOT_READY; })) << text();
  ASSERT_FALSE(order(device::DeviceOrder::kPowerOn)) << "taken; the robot boots";
  robot_->order("emergency_stop");
  ASSERT_TRUE(until([this] { return kind() == CauseKind::CAUSE_EMERGENCY_STOP; })) << text();
  robot_->order("release_emergency_stop");
  robot_->order("booted");
  ASSERT_TRUE(until([this] { return says("the brakes are on"); })) << text();
  // The dashboard answers in the order of its commands.
  ASSERT_FALSE(order(device::DeviceOrder::kPowerOff));
  EXPECT_EQ(robot_->state().at("brake_releases"), 0);
  ASSERT_TRUE(until([this] { return says("the robot is off"); })) << text();
  ASSERT_FALSE(order(device::DeviceOrder::kPowerOn));
  robot_->order("booted");
  EXPECT_TRUE(until([this] { return robot_->state().at("brake_releases") == 1; })) << text();
}

TEST_F(UniversalRobotsTest, EndsAnOrderWhenItsConnectionIsLost) {
  begin();
  run();
  robot_->order("cable pulled");
  ASSERT_FALSE(device_->begin(device::DeviceOrder::kPowerOff));
  std::optional<device::OrderEnd> end;
  ASSERT_TRUE(until([&] { return (end = device_->order_end()).has_value(); })) << "the driver takes no other order";
  ASSERT_TRUE(end->result);
  EXPECT_EQ(end->result->text,
            "the connection to its robot was lost before the robot answered: look at the robot, then call again");
}

TEST_F(UniversalRobotsTest, WaitsForPowerRemoteControlAndTheEndOfOtherPrograms) {
  begin({"--off"});
  ASSERT_TRUE(until([this] { return kind() == CauseKind::CAUSE_DEVICE_NOT_READY; })) << text();
  robot_->order("remote_control off");
  EXPECT_FALSE(order(device::DeviceOrder::kPowerOn));
  ASSERT_TRUE(until([this] { return kind() == CauseKind::CAUSE_REMOTE_CONTROL_OFF; })) << text();
  EXPECT_EQ(robot_->state().at("programs"), 0);
  may_move_ = false;
  robot_->order("remote_control on");
  robot_->order("foreign_program");
  ASSERT_TRUE(until([this] { return text().find("another program runs") != std::string::npos; })) << text();
  robot_->order("stop_program");
  may_move_ = true;
  resume();
  EXPECT_TRUE(until([this] { return session_->active(); })) << text();
  const auto refused = device_->begin(device::DeviceOrder::kUnlock);
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->text, "its robot is in no protective stop");
}

TEST_F(UniversalRobotsTest, RefusesAnotherModelThanItsDescription) {
  robot_names_ = {"ur10e_robot"};
  begin();
  ASSERT_TRUE(until([this] { return kind() == CauseKind::CAUSE_DEVICE_NOT_READY; })) << text();
  EXPECT_EQ(text(),
            "the controller says that its robot is a UR5e, but the cell file describes a ur10e: connect that robot, or "
            "correct robot or urdf of arm north, or the key model of its device if only the name there is wrong");
  for (const auto end = Clock::now() + 1s; Clock::now() < end;) period();
  EXPECT_FALSE(session_->active());
  EXPECT_EQ(robot_->state().at("programs"), 0) << "nothing may move";
}

TEST_F(UniversalRobotsTest, RefusesAnotherSeriesThanItsDescription) {
  begin({"--model", "cb3"}, {{"model", "ur5e"}});
  ASSERT_TRUE(until([this] { return kind() == CauseKind::CAUSE_DEVICE_NOT_READY; })) << text();
  // The series is known by RTDE, the model by the dashboard: whichever answers first refuses.
  const std::string said = "the controller says that its robot is a ";
  const std::string rest = ", but the cell file describes a ur5e: ";
  EXPECT_TRUE(text().starts_with(said + "UR5" + rest) || text().starts_with(said + "robot of the CB3 series" + rest))
      << text();
  EXPECT_EQ(robot_->state().at("programs"), 0);
}

TEST_F(UniversalRobotsTest, KnowsTheSeriesOfAControllerWithoutAModel) {
  begin({"--model", "cb3", "--robot", ""}, {{"model", "ur5e"}});
  ASSERT_TRUE(until([this] { return kind() == CauseKind::CAUSE_DEVICE_NOT_READY; })) << text();
  EXPECT_TRUE(says("its robot is a robot of the CB3 series, but the cell file describes a ur5e: ")) << text();
}

TEST_F(UniversalRobotsTest, FollowsTheModelOfItsDescription) {
  robot_names_ = {"ur", "ur5e"};  // a name and an argument of xacro
  begin();
  move();
}

TEST_F(UniversalRobotsTest, FollowsARobotThatDoesNotNameItsModel) {
  robot_names_ = {"ur5e"};
  begin({"--robot", ""});
  move();
}

TEST_F(UniversalRobotsTest, TakesTheKeyModelBeforeTheNameOfTheDescription) {
  robot_names_ = {"ur5"};  // of a CB3
  begin({}, {{"model", "ur7e"}});
  move();
}

TEST_F(UniversalRobotsTest, ReadsAndSetsInputsAndOutputs) {
  signals_ = {"digital_input 3", "tool_input 1",        "tool_output 0",   "configurable_output 7",
              "analog_input 1",  "tool_analog_input 0", "analog_output 1", "digital_output 3"};
  begin();
  run();
  const auto shows = [this](std::size_t index, double value) {
    return until([&] { return std::abs(device_->signal(index).value_or(-1.0) - value) < 1e-9; });
  };
  EXPECT_TRUE(shows(0, 0.0));
  robot_->order("digital_input 3 1");
  robot_->order("digital_input 17 1");
  EXPECT_TRUE(shows(0, 1.0));
  EXPECT_TRUE(shows(1, 1.0));
  robot_->order("analog_input 1 4.25");
  robot_->order("analog_input 2 0.012");
  EXPECT_TRUE(shows(4, 4.25));
  EXPECT_TRUE(shows(5, 0.012));

  for (const std::size_t output : {2U, 3U}) EXPECT_FALSE(device_->set_signal(output, 1.0));
  EXPECT_FALSE(device_->set_signal(6, 2.5));
  for (const std::size_t output : {2U, 3U}) EXPECT_TRUE(shows(output, 1.0));
  EXPECT_TRUE(shows(6, 2.5));
  EXPECT_TRUE(shows(7, 0.0)) << "the mask leaves other outputs alone";
  const auto outputs = robot_->order("outputs");
  EXPECT_EQ(outputs.at("digital"), (1 << 16) + (1 << 15));
  EXPECT_DOUBLE_EQ(outputs.at("analog")[1], 2.5);
  EXPECT_DOUBLE_EQ(outputs.at("analog")[0], 0.0);
  EXPECT_FALSE(device_->set_signal(2, 0.0));
  EXPECT_TRUE(shows(2, 0.0));
  EXPECT_TRUE(shows(3, 1.0));

  EXPECT_EQ(device_->set_signal(0, 1.0)->text, "an input of its robot cannot be set");
  EXPECT_EQ(device_->set_signal(6, 10.5)->text, "an analog output must be 0 to 10 V");
}

TEST_F(UniversalRobotsTest, NamesOutputsThatAnotherProgramSets) {
  signals_ = {"tool_output 0", "tool_analog_input 1"};
  begin();
  robot_->order("in_use tool_digital_output");
  ASSERT_TRUE(until([this] { return text().find("(IN_USE)") != std::string::npos; })) << text();
  EXPECT_NE(text().find("has the output tool_digital_output that another program sets"), std::string::npos) << text();
  robot_->order("in_use");
  robot_->order("not_found tool_analog_input1");
  ASSERT_TRUE(until([this] { return session_->active(); })) << text();
  EXPECT_FALSE(device_->signal(1)) << "an input that the controller does not have is not known";
}

TEST_F(UniversalRobotsTest, SurvivesHalfPackagesAndReportsTheSpeedSlider) {
  begin({}, {{"speed_slider", "0.5"}});
  robot_->order("halves on");
  run();
  EXPECT_DOUBLE_EQ(session_->state().speed_scaling, 0.5);
  EXPECT_TRUE(until([this] { return std::abs(device_->tracking_delay() - 0.06) < 1e-3; }));
  robot_->order("slider 0.1");
  EXPECT_TRUE(until([this] { return session_->state().speed_scaling < 0.11; })) << text();
}

TEST_F(UniversalRobotsTest, NamesMissingOutputsAndSlidersInUse) {
  begin({}, {{"speed_slider", "0.5"}});
  robot_->order("in_use speed_slider_mask");
  ASSERT_TRUE(until([this] { return text().find("(IN_USE)") != std::string::npos; })) << text();
  EXPECT_TRUE(session_->failed());
  robot_->order("in_use");
  robot_->order("not_found safety_mode");
  ASSERT_TRUE(until([this] { return text().find("does not have the RTDE output safety_mode") != std::string::npos; }))
      << text();
  robot_->order("not_found target_speed_fraction");
  EXPECT_TRUE(until([this] { return session_->active(); })) << text();
}

TEST_F(UniversalRobotsTest, SpeaksVersion1AndTheSlowCycleOfACb3) {
  begin({"--model", "cb3"});
  robot_->order("not_found version_2");
  move();
}

TEST_F(UniversalRobotsTest, StopsTheRobotWhenTheCableIsPulled) {
  begin();
  move();
  robot_->order("cable pulled");
  ASSERT_TRUE(until([this] { return session_->failed(); }));
  const std::string lost = "the robot at " + robot_->address() + " has sent no data for 500 ms: " + kLostAdvice;
  EXPECT_EQ(text(), lost);
  EXPECT_TRUE(until([this] { return stands(); }));
  ASSERT_TRUE(until([&] { return text() != lost; })) << "it connects again, and fails again";
  EXPECT_EQ(text(),
            "the robot at " + robot_->address() + " does not complete the RTDE handshake within 3 s: " + kLostAdvice);
  robot_->order("drop_connections");
  robot_->order("cable plugged");
  ASSERT_TRUE(until([this] { return session_->state().mode == device::DeviceMode::kReady; })) << text();
  EXPECT_FALSE(session_->active());
  robot_->order("forget");
  resume();
  ASSERT_TRUE(until([this] { return session_->active(); })) << text();
  stays();
}

TEST_F(UniversalRobotsTest, NamesAPulledCableWithTheDefaultTimeout) {
  command_timeout_ = 50ms;
  begin();
  // On a busy machine the data may be late before.
  ASSERT_TRUE(until([this] {
    if (!session_->active()) resume();
    return session_->active();
  })) << text();
  robot_->order("cable pulled");
  ASSERT_TRUE(until([this] { return session_->failed(); }));
  const std::string robot = "the robot at " + robot_->address();
  // This process may have stopped for so long that RTDE notices first.
  EXPECT_TRUE(text().starts_with("the newest data of " + robot + " are ") ||
              text().starts_with(robot + " has sent no data for 500 ms: "))
      << text();
  EXPECT_TRUE(text().ends_with(kLostAdvice)) << text();
  robot_->order("drop_connections");
  robot_->order("cable plugged");
  ASSERT_TRUE(until([this] { return session_->state().mode == device::DeviceMode::kReady; })) << text();
  EXPECT_FALSE(session_->active());
  EXPECT_TRUE(text().ends_with(kLostAdvice)) << "also once it works again: " << text();
}

TEST_F(UniversalRobotsTest, EndsTheProgramOnASetPointTooFarAway) {
  begin();
  run();
  q_[3] += 0.5;  // in one period
  ASSERT_TRUE(until([this] { return kind() == CauseKind::CAUSE_PROGRAM_STOPPED; })) << text();
  EXPECT_LT(robot_->state().at("fastest").get<double>(), 1e-6);
}

TEST_F(UniversalRobotsTest, NamesATakenPort) {
  device::universal_robots::TcpListener other;
  ASSERT_FALSE(other.listen(50217));
  begin({}, {{"reverse_port", "50217"}});
  ASSERT_TRUE(until([this] { return session_->failed(); }));
  EXPECT_NE(text().find("cannot listen on port 50217 of this machine"), std::string::npos) << text();
}

TEST(UniversalRobots, NamesAWrongAddress) {
  device::universal_robots::RtdeSetup setup;
  setup.address = "127.0.0.99";
  device::universal_robots::RtdeClient client(setup, [](const auto&, const auto&) {});
  client.open(Clock::now());
  const auto until = Clock::now() + 10s;
  while (!client.failed() && Clock::now() < until) client.update(Clock::now());
  EXPECT_EQ(client.error(),
            "the robot at 127.0.0.99 cannot be reached on port 30004: Connection refused; is it on, and is robot_ip "
            "right?");
}

TEST(UniversalRobots, KnowsTheModelThatADescriptionNames) {
  using device::universal_robots::mentioned_type;
  EXPECT_EQ(mentioned_type({"ur5e"}), "ur5e");
  EXPECT_EQ(mentioned_type({"My_UR10e-cell"}), "ur10e");
  EXPECT_EQ(mentioned_type({"dual_ur5e", "ur5e"}), "ur5e");
  EXPECT_EQ(mentioned_type({"ur", "robot"}), std::nullopt);
  EXPECT_EQ(mentioned_type({"ur5eleven"}), std::nullopt) << "a word of its own";
  EXPECT_EQ(mentioned_type({"ur5e_and_ur10e"}), std::nullopt) << "which one?";
}

TEST(UniversalRobots, ComparesModelsOfEachSeries) {
  using device::universal_robots::FoundRobot;
  const auto fits = [](const char* model, std::uint32_t version, const char* expected) {
    return FoundRobot{model, version}.may_be(expected);
  };
  EXPECT_TRUE(fits("UR5", 5, "ur5e"));
  EXPECT_TRUE(fits("UR5e", 5, "ur5e"));
  EXPECT_TRUE(fits("UR5", 5, "ur7e")) << "derived from it";
  EXPECT_TRUE(fits("UR10", 5, "ur12e"));
  EXPECT_TRUE(fits("UR5", 3, "ur5"));
  EXPECT_TRUE(fits("UR16", 5, "ur16e"));
  EXPECT_TRUE(fits("UR20", 5, "ur20"));
  EXPECT_TRUE(fits("UR30", 10, "ur30"));
  EXPECT_TRUE(fits("", 5, "ur10e")) << "it does not say";
  EXPECT_TRUE(fits("UR99", 5, "robot")) << "nothing is expected";
  EXPECT_FALSE(fits("UR5", 5, "ur5"));
  EXPECT_FALSE(fits("UR5", 3, "ur5e"));
  EXPECT_FALSE(fits("UR10", 5, "ur5e"));
  EXPECT_FALSE(fits("UR3", 5, "ur30"));
  EXPECT_FALSE(fits("UR10", 3, "ur10e"));
  EXPECT_FALSE(fits("", 3, "ur10e"));
  EXPECT_EQ((FoundRobot{"UR5", 5}.name()), "UR5e");
  EXPECT_EQ((FoundRobot{"UR10e", 5}.name()), "UR10e");
  EXPECT_EQ((FoundRobot{"UR10", 3}.name()), "UR10");
  EXPECT_EQ((FoundRobot{"UR20", 5}.name()), "UR20");
  EXPECT_EQ((FoundRobot{"", 0}.name()), "");
}

TEST(UniversalRobots, SaysThatADescriptionHasNoCalibration) {
  planner::RobotModel model;
  model.links.resize(2);
  for (int joint = 0; joint < 2; ++joint) model.links[joint].joint = joint;
  const auto notes = [&] { return universal_robots_notes(setup_for("192.168.0.10", {{"model", "ur5e"}}), model); };
  ASSERT_EQ(notes().size(), 2U);
  EXPECT_NE(notes()[0].find("without the calibration of this robot"), std::string::npos) << notes()[0];
  model.links[1].X_PJ.rotate(Eigen::AngleAxisd(1e-3, Eigen::Vector3d::UnitX()));
  EXPECT_EQ(notes().size(), 1U) << "a calibration turns the frames by a little";
  EXPECT_EQ(universal_robots_notes(setup_for("192.168.0.10"), model).front(),
            "arm north: its description does not name a model of Universal Robots, so that a wrong robot is not found; "
            "the key model of its device names it");
}

// Where a robot has many links, the mount is a part of the first joint's frame.
TEST(UniversalRobots, CountsATiltedMountAsNoCalibration) {
  const test::TemporaryFolder folder;
  std::ifstream file(HECATON_SOURCE_DIR "/deploy/robots/ur5e.urdf");
  std::string text{std::istreambuf_iterator<char>(file), {}};
  const std::string base = "<link name=\"base_link\">";
  ASSERT_NE(text.find(base), std::string::npos);
  text.insert(text.find(base),
              "<link name='floor'/><joint name='mount' type='fixed'><parent link='floor'/><child link='base_link'/>"
              "<origin rpy='0.785398163397 0 0'/></joint>");
  planner::RobotModel model = *planner::load_urdf(folder.write("mounted.urdf", text));
  planner::merge_fixed_links(static_cast<int>(model.links.size()) - 1, model);
  ASSERT_EQ(model.links[1].joint, 0);
  ASSERT_NEAR(model.links[1].X_PJ.linear()(1, 1), std::sqrt(0.5), 1e-9);
  EXPECT_NE(universal_robots_notes(setup_for("192.168.0.10"), model).front().find("without the calibration"),
            std::string::npos);
}

TEST(UniversalRobots, SaysForEachSafetyModeWhatAPersonDoes) {
  using device::DeviceMode;
  const std::string resume = "'hecaton resume north'";
  const std::string on_and_resume = "call 'hecaton device north on' and " + resume;
  const std::string clear = ": clear the safeguarded space and reset the safeguard, then call " + resume;
  const std::string enabling =
      "stops the robot: switch the robot to automatic mode, or hold the device in its middle position, then call " +
      resume;
  const std::string machine = "by the injection moulding machine (IMMI)";
  const std::string plc = "the safety PLC (PROFIsafe)";
  const std::string fault =
      "safety violation or fault: read the log at the teach pendant and restart the safety system there, then " +
      on_and_resume;
  const std::string not_ready = "the safety system is not ready: act at the teach pendant, then call " + resume;
  const std::string emergency = "emergency stop: release the emergency stop button, then " + on_and_resume;
  const std::vector<std::tuple<int, DeviceMode, std::string>> modes{
      {1, DeviceMode::kReady, ""},
      {2, DeviceMode::kReady, ""},
      {3, DeviceMode::kProtectiveStop,
       "protective stop: look at the arm, then call 'hecaton device north unlock', 5 s after the stop or later, and " +
           resume},
      {4, DeviceMode::kNotReady,
       "recovery mode: move the arm into its safety limits at the teach pendant, then call " + resume},
      {5, DeviceMode::kSafeguardStop, "safeguard stop" + clear},
      {6, DeviceMode::kEmergencyStop, emergency},
      {7, DeviceMode::kEmergencyStop, emergency},
      {8, DeviceMode::kNotReady, fault},
      {9, DeviceMode::kNotReady, fault},
      {10, DeviceMode::kNotReady, not_ready},
      {11, DeviceMode::kNotReady, not_ready},
      {12, DeviceMode::kSafeguardStop, "safeguard stop of the automatic mode" + clear},
      {13, DeviceMode::kSafeguardStop, "an enabling device " + enabling},
      {14, DeviceMode::kSafeguardStop, "an enabling device of the teach pendant " + enabling},
      {15, DeviceMode::kEmergencyStop,
       "emergency stop " + machine + ": end the emergency stop there, then " + on_and_resume},
      {16, DeviceMode::kSafeguardStop, "safeguard stop " + machine + clear},
      {17, DeviceMode::kNotReady,
       "the safety system waits for parameters of " + plc + ": start it and check its connection, then call " + resume},
      {18, DeviceMode::kSafeguardStop, "safeguard stop by " + plc + clear},
      {19, DeviceMode::kSafeguardStop, "safeguard stop by " + plc + clear},
      {20, DeviceMode::kEmergencyStop,
       "emergency stop by " + plc + ": end the emergency stop there, then " + on_and_resume},
      {21, DeviceMode::kSafeguardStop,
       "the safety system stops the robot (safety mode 21): read the reason at the teach pendant, then call " + resume},
      {22, DeviceMode::kSafeguardStop, "safeguard stop by a program of the safety interface" + clear},
      {23, DeviceMode::kSafeguardStop,
       "the safety system stops the robot (safety mode 23): read the reason at the teach pendant, then call " + resume},
  };
  for (const auto& [mode, expected, text] : modes) {
    device::universal_robots::RobotData data;
    data.robot_mode = 7;  // running
    data.safety_mode = mode;
    const auto condition = condition_of(data, "north");
    EXPECT_EQ(condition.mode, expected) << mode;
    EXPECT_EQ(condition.text, text) << mode;
  }
}

TEST(UniversalRobots, SaysForEachRobotModeWhatAPersonDoes) {
  const std::string on = "call 'hecaton device north on' and 'hecaton resume north'";
  const std::string unconnected = "the controller has no connection to its arm: look at the teach pendant";
  const std::vector<std::pair<int, std::string>> modes{
      {-1, unconnected},
      {0, unconnected},
      {1, "the safety configuration waits for its confirmation at the teach pendant"},
      {2, "the robot boots: wait, then " + on},
      {3, "the robot is off: " + on},
      {4, "the robot boots: wait, then " + on},
      {5, "the brakes are on: " + on},
      {6, "the robot is in backdrive mode: end it at the teach pendant"},
      {7, ""},
      {8, "the robot updates its firmware: wait"},
      {99, unconnected}};
  for (const auto& [mode, text] : modes) {
    device::universal_robots::RobotData data;
    data.robot_mode = mode;
    data.safety_mode = 1;  // normal
    const auto condition = condition_of(data, "north");
    EXPECT_EQ(condition.mode, mode == 7 ? device::DeviceMode::kReady : device::DeviceMode::kNotReady) << mode;
    EXPECT_EQ(condition.text, text) << mode;
  }
}

TEST(UniversalRobots, CancelsTheReleaseOfBrakesByTimeAndBySafetyMode) {
  using device::universal_robots::BrakeRelease;
  const Clock::time_point ordered{1h};
  device::universal_robots::RobotData booting, idle;
  booting.safety_mode = idle.safety_mode = 1;  // normal
  booting.robot_mode = 2;
  idle.robot_mode = 5;
  BrakeRelease brakes;
  EXPECT_FALSE(brakes.due(idle, ordered)) << "no order";
  brakes.begin(ordered);
  EXPECT_FALSE(brakes.due(booting, ordered + 10s));
  EXPECT_TRUE(brakes.due(idle, ordered + 30s));
  EXPECT_FALSE(brakes.due(idle, ordered + 31s));
  EXPECT_FALSE(brakes.due(idle, ordered + 30s)) << "it is cancelled";
  for (int mode = 0; mode < 24; ++mode) {
    brakes.begin(ordered);
    booting.safety_mode = mode;
    EXPECT_FALSE(brakes.due(booting, ordered + 1s));
    EXPECT_EQ(brakes.due(idle, ordered + 2s), mode == 1 || mode == 2) << mode;
  }
}

TEST(UniversalRobots, RefusesWrongKeys) {
  const auto refusal = [](const std::map<std::string, std::string>& keys, int joints = 6) -> std::string {
    device::DeviceSetup setup = setup_for("192.168.0.10", keys);
    setup.limits.lower.conservativeResize(joints);
    try {
      (void)make_universal_robots_arm(setup);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "nothing";
  };
  EXPECT_EQ(refusal({}), "nothing");
  EXPECT_EQ(refusal({{"robot_ip", "ur5.local"}}),
            "cell.yaml: arms[0].device.robot_ip = ur5.local must be an IPv4 address, such as 192.168.0.10");
  EXPECT_EQ(refusal({{"model", "UR6"}}),
            "cell.yaml: arms[0].device.model = UR6 must be ur3, ur5, ur10, ur3e, ur5e, ur7e, ur8long, ur10e, ur12e, "
            "ur15, ur16e, ur18, ur20 or ur30");
  EXPECT_EQ(refusal({{"gain", "5"}}), "cell.yaml: arms[0].device.gain = 5 must be 100 to 2000");
  EXPECT_EQ(refusal({{"timeout", "5s"}}), "cell.yaml: arms[0].device.timeout = 5s must be 0.004s to 1s");
  EXPECT_EQ(refusal({}, 7),
            "cell.yaml: arms[0].device.type = universal_robots must be of an arm with six joints, but arm north has 7");
}

TEST(UniversalRobots, FramingSurvivesRandomBytes) {
  std::mt19937 random(1);
  std::string bytes;
  int packages = 0;
  for (int i = 0; i < 200'000; ++i) {
    bytes.push_back(static_cast<char>(random() % (i % 3 == 0 ? 16 : 256)));
    const auto next = device::universal_robots::next_package(bytes);
    if (next.broken) bytes.clear();
    if (!next.package) continue;
    ++packages;
    (void)device::universal_robots::text_message(next.package->payload, 1 + packages % 2);
    bytes.erase(0, next.size);
  }
  EXPECT_GT(packages, 10);
}

/// A server on the RTDE port that sends what a robot would not.
class BrokenRobot {
 public:
  BrokenRobot() {
    sockaddr_in own{};
    own.sin_family = AF_INET;
    own.sin_port = htons(30004);
    ::inet_pton(AF_INET, kAddress, &own.sin_addr);
    const int yes = 1;
    ::setsockopt(listener_, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    EXPECT_EQ(::bind(listener_, reinterpret_cast<const sockaddr*>(&own), sizeof own), 0);
    EXPECT_EQ(::listen(listener_, 4), 0);
  }
  ~BrokenRobot() {
    ::close(connection_);
    ::close(listener_);
  }
  BrokenRobot(const BrokenRobot&) = delete;
  BrokenRobot& operator=(const BrokenRobot&) = delete;

  void accept() {
    ::close(connection_);
    connection_ = ::accept(listener_, nullptr, nullptr);
  }
  void send(const std::string& bytes) const { (void)!::send(connection_, bytes.data(), bytes.size(), MSG_NOSIGNAL); }

  static constexpr const char* kAddress = "127.240.17.1";

 private:
  int listener_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  int connection_ = -1;
};

TEST(UniversalRobots, SurvivesRandomPackages) {
  using device::universal_robots::PackageType;
  constexpr int kPackages = 100'000;
  constexpr int kInABatch = 20;
  const std::array types{PackageType::kProtocolVersion,
                         PackageType::kControllerVersion,
                         PackageType::kOutputs,
                         PackageType::kInputs,
                         PackageType::kStart,
                         PackageType::kData,
                         PackageType::kText};
  const std::array<std::string, 5> answers{std::string(1, '\1'), std::string(16, '\5'),
                                           "\1DOUBLE,VECTOR6D,VECTOR6D,INT32,INT32,UINT32,DOUBLE,DOUBLE",
                                           "\1UINT32,DOUBLE", std::string(1, '\1')};
  std::mt19937 random(7);
  BrokenRobot robot;
  device::universal_robots::RtdeClient client({BrokenRobot::kAddress, 500.0, 0.5}, {});
  Clock::time_point now = Clock::now();
  int failures = 0, handshakes = 0;
  for (int sent = 0; sent < kPackages; sent += kInABatch) {
    if (sent == 0 || client.failed()) {
      client.open(now);
      robot.accept();
      ++failures;
      // Half of the connections get as far as the data.
      for (std::size_t step = 0; random() % 8 != 0 && step < answers.size(); ++step) {
        robot.send(device::universal_robots::package(types[step], answers[step]));
        for (int i = 0; i < 3; ++i) client.update(now += 1ms);
        handshakes += step + 1 == answers.size() ? 1 : 0;
      }
    }
    std::string bytes;
    for (int i = 0; i < kInABatch; ++i) {
      std::string payload(random() % 5 == 0 ? 137 : random() % 40, '\0');
      for (char& byte : payload) byte = static_cast<char>(random());
      bytes += device::universal_robots::package(types[random() % types.size()], payload);
    }
    if (random() % 16 == 0) bytes[random() % bytes.size()] = '\0';
    robot.send(bytes);
    client.update(now += 1ms);
    if (client.failed()) {
      EXPECT_FALSE(client.error().empty());
    }
  }
  EXPECT_GT(failures, 20);
  EXPECT_GT(handshakes, 10);
}

}  // namespace
}  // namespace hecaton::services
