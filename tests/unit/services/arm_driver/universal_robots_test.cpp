// The device of Universal Robots against the controller of tests/robots/ur_controller.py, without a cell.
#include <array>
#include <cmath>
#include <functional>
#include <thread>

#include <gtest/gtest.h>
#include <unistd.h>

#include "planner/model/robot_model.hpp"
#include "services/arm_driver/device_session.hpp"
#include "services/arm_driver/devices/universal_robots/tcp.hpp"
#include "services/arm_driver/devices/universal_robots/universal_robots_arm.hpp"
#include "tests/support/driven_robot.hpp"
#include "tests/unit/services/arm_driver/universal_robots_setup.hpp"

namespace hecaton::services {
namespace {

using namespace std::chrono_literals;
using device::JointVector;
using msg::CauseKind;
using Clock = device::Clock;

using test::kUrPeriod;
using test::ur_description;
using test::ur_setup;

constexpr auto kLostAdvice =
    "is its cable out, or is its controller off? Once it works again, call 'hecaton resume north'";
constexpr double kSecondJoint = -0.4;  // speed of the second joint, as a share of the first one's

class UniversalRobotsTest : public test::DrivenRobot<testing::Test> {
 protected:
  UniversalRobotsTest() : DrivenRobot({.period = kUrPeriod, .second_joint = kSecondJoint}) {}

  void begin(const std::vector<std::string>& options = {}, const std::map<std::string, std::string>& keys = {}) {
    robot_.emplace(options);
    connect(keys);
  }
  void connect(std::map<std::string, std::string> keys = {}) {
    // Tests of other processes run beside it on this machine.
    keys.try_emplace("reverse_port", std::to_string(20000 + ::getpid() % 10000));
    device::DeviceSetup setup = ur_setup(robot_->address(), keys);
    setup.signals = signals_;
    setup.robot_names = robot_names_;
    setup.model = description_;
    setup.log = [this](std::string_view event, std::string_view details) {
      if (event == "robot calibration") calibrations_.emplace_back(details);
    };
    setup.command_timeout = command_timeout_;
    device_ = make_universal_robots_arm(setup);
    drive("north", 6, command_timeout_);
  }
  std::vector<std::string> signals_;      ///< ports
  std::vector<std::string> robot_names_;  ///< in the description
  std::shared_ptr<const planner::RobotModel> description_ = ur_description("ur5e");
  std::vector<std::string> calibrations_;  ///< what the log says of them
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

TEST_F(UniversalRobotsTest, FollowsARobotWhoseKinematicsAreThoseOfItsDescription) {
  begin();
  move();
  EXPECT_EQ(calibrations_, (std::vector<std::string>{"the description has it: the flange differs by 0.0 mm"}));
}

TEST_F(UniversalRobotsTest, TellsOnceThatTheDescriptionHasNotTheCalibrationOfTheRobot) {
  begin({"--calibration", "1"});
  move();
  robot_->order("restart 0.1");
  ASSERT_TRUE(until([this] { return kind() == CauseKind::CAUSE_DEVICE_NOT_READY; })) << text();
  EXPECT_FALSE(order(device::DeviceOrder::kPowerOn));
  ASSERT_TRUE(until([this] { return session_->state().mode == device::DeviceMode::kReady; })) << text();
  resume();
  ASSERT_TRUE(until([this] { return session_->active(); })) << text();
  ASSERT_EQ(calibrations_.size(), 1U) << calibrations_.back();
  EXPECT_EQ(calibrations_[0],
            "the description does not have it: the flange is up to 2.3 mm from where the planner expects it; extract "
            "this robot's calibration, for example with the ROS package ur_calibration, and give it to the urdf of arm "
            "north");
}

TEST_F(UniversalRobotsTest, RefusesARobotOfAnotherSizeThanItsDescription) {
  begin({"--size", "ur16e"});
  ASSERT_TRUE(until([this] { return kind() == CauseKind::CAUSE_DEVICE_NOT_READY; })) << text();
  EXPECT_EQ(text(),
            "by the kinematics that the robot reports, its flange is up to 92.0 mm from where the cell file expects it "
            "(limit 10.0 mm): correct robot or urdf of arm north; it must be of this type of robot, with its "
            "calibration");
  for (const auto end = Clock::now() + 1s; Clock::now() < end;) period();
  EXPECT_FALSE(session_->active());
  EXPECT_EQ(robot_->state().at("programs"), 0) << "nothing may move";
}

TEST_F(UniversalRobotsTest, RefusesACalibrationThatIsFarFromItsDescription) {
  begin({"--calibration", "3"});
  ASSERT_TRUE(until([this] { return kind() == CauseKind::CAUSE_DEVICE_NOT_READY; })) << text();
  EXPECT_TRUE(says("its flange is up to 12.7 mm from where the cell file expects it (limit 10.0 mm)")) << text();
  EXPECT_EQ(robot_->state().at("programs"), 0);
}

TEST_F(UniversalRobotsTest, RefusesAMalformedCalibrationUntilItIsRight) {
  for (const auto& [form, what] :
       {std::pair("truncated", "a malformed calibration"), std::pair("nan", "a malformed calibration"),
        std::pair("endless", "bytes that are no state of a robot")}) {
    robot_.emplace();
    robot_->order(std::string("kinematics ") + form);
    connect();
    ASSERT_TRUE(until([this] { return session_->failed(); })) << form;
    EXPECT_EQ(text(), "the robot at " + robot_->address() + " sends " + what +
                          " on port 30001: restart its controller, and update its software");
    for (const auto end = Clock::now() + 2s; Clock::now() < end;) period();
    EXPECT_EQ(robot_->state().at("programs"), 0) << "nothing may move: " << form;
    robot_->order("kinematics sent");
    EXPECT_TRUE(until([this] { return session_->active(); })) << text();
    session_.reset();
    device_.reset();
  }
}

TEST_F(UniversalRobotsTest, FollowsARobotThatSendsNoCalibration) {
  robot_.emplace();
  robot_->order("kinematics missing");
  connect();
  const auto begin = Clock::now();
  move();
  EXPECT_GE(Clock::now() - begin, 3s) << "it may send it late";
  EXPECT_EQ(calibrations_,
            (std::vector<std::string>{"the robot has sent none within 3 s: it is not compared with the description"}));
}

TEST_F(UniversalRobotsTest, ReadsTheCalibrationInHalfPackages) {
  robot_.emplace();
  robot_->order("halves on");
  connect();
  run();
  EXPECT_EQ(calibrations_.size(), 1U);
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
  begin({"--model", "cb3", "--size", "ur5e"});
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

// A robot does not notice that a cut connection has ended, and keeps its inputs.
TEST_F(UniversalRobotsTest, WaitsForInputsOfAConnectionThatWasCut) {
  begin({}, {{"speed_slider", "0.5"}});
  robot_->order("linger 5");
  move();
  robot_->order("cable pulled");
  ASSERT_TRUE(until([this] { return session_->failed(); }));
  ASSERT_TRUE(until([this] { return stands(); }));
  robot_->order("cable plugged");
  ASSERT_TRUE(until([this] { return says("(IN_USE)"); })) << text();
  EXPECT_EQ(text(), "the robot at " + robot_->address() +
                        " has a speed slider that another program sets (IN_USE): end that program, or remove "
                        "speed_slider; after a cut the robot may keep the old connection for a minute; once it works "
                        "again, call 'hecaton resume north'");
  ASSERT_TRUE(until([this] { return session_->state().mode == device::DeviceMode::kReady; })) << text();
  EXPECT_FALSE(session_->active()) << "held until a person resumes";
  EXPECT_EQ(kind(), CauseKind::CAUSE_DEVICE_FAILED) << text();
  EXPECT_EQ(robot_->state().at("programs"), 1);
  robot_->order("forget");
  resume();
  ASSERT_TRUE(until([this] { return session_->active(); })) << text();
  stays();
}

TEST_F(UniversalRobotsTest, NamesASocketThatLingersAfterACut) {
  begin();
  robot_->order("linger 3600");
  move();
  robot_->order("cable pulled");
  ASSERT_TRUE(until([this] { return session_->failed(); }));
  ASSERT_TRUE(until([this] { return stands(); }));
  robot_->order("cable plugged");
  ASSERT_TRUE(until([this] { return session_->state().mode == device::DeviceMode::kReady; })) << text();
  EXPECT_FALSE(session_->active()) << "held until a person resumes";
  robot_->order("forget");
  resume();
  ASSERT_TRUE(until([this] { return says("does not connect to"); })) << text();
  EXPECT_TRUE(
      says(": after a cut a robot may keep the old connection for some time; wait a minute, then call 'hecaton "
           "resume north'"))
      << text();
  EXPECT_EQ(robot_->state().at("programs"), 2);
  // The robot drops the old connections.
  robot_->order("linger 0.01");
  robot_->order("cable plugged");
  ASSERT_TRUE(until([this] { return session_->state().mode == device::DeviceMode::kReady; })) << text();
  EXPECT_EQ(kind(), CauseKind::CAUSE_DEVICE_FAILED) << "held until a person resumes again";
  EXPECT_EQ(robot_->state().at("programs"), 2);
  EXPECT_TRUE(robot_->state().at("first").is_null()) << "nothing has moved";
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

}  // namespace
}  // namespace hecaton::services
