// The device of ABB's EGM against the controller of tests/robots/abb_controller.py, without a cell, and its messages.
#include <bit>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <numbers>
#include <random>
#include <thread>

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include "services/arm_driver/device_session.hpp"
#include "services/arm_driver/devices/abb_egm/abb_egm_arm.hpp"
#include "services/arm_driver/devices/abb_egm/messages.hpp"
#include "services/arm_driver/devices/socket.hpp"
#include "tests/support/driven_robot.hpp"

namespace hecaton::services {
namespace {

using namespace std::chrono_literals;
namespace egm = device::abb_egm;

constexpr auto kAbbPeriod = 4ms;
constexpr auto kAbbSilence = 2000ms;  // a busy machine may stop the simulated controller for some time
constexpr double kDegree = std::numbers::pi / 180.0;

device::DeviceSetup abb_setup(const std::map<std::string, std::string>& keys, int joints = 6) {
  device::DeviceSetup setup;
  setup.arm = "south";
  setup.limits.lower = device::JointVector::Constant(joints, -3.0);
  setup.limits.upper = device::JointVector::Constant(joints, 3.0);
  setup.limits.velocity = device::JointVector::Constant(joints, 1.5);
  setup.limits.acceleration = device::JointVector::Constant(joints, 10.0);
  setup.period = kAbbPeriod;
  setup.command_timeout = kAbbSilence;
  setup.where = "cell.yaml: arms[0].device";
  setup.values = {keys.begin(), keys.end()};
  return setup;
}

/// A UDP socket on a loopback address.
class UdpSocket {
 public:
  explicit UdpSocket(const std::string& address = "127.0.0.1", int port = 0)
      : socket_(::socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0)) {
    sockaddr_in own = to(address, port);
    EXPECT_EQ(::bind(socket_.get(), reinterpret_cast<const sockaddr*>(&own), sizeof own), 0);
    socklen_t size = sizeof own;
    EXPECT_EQ(::getsockname(socket_.get(), reinterpret_cast<sockaddr*>(&own), &size), 0);
    port_ = ntohs(own.sin_port);
  }
  [[nodiscard]] int port() const { return port_; }
  void send(std::string_view bytes, int port) const {
    const sockaddr_in peer = to("127.0.0.1", port);
    (void)::sendto(socket_.get(), bytes.data(), bytes.size(), 0, reinterpret_cast<const sockaddr*>(&peer), sizeof peer);
  }
  /// A datagram that has arrived; empty: none.
  [[nodiscard]] std::string receive() const {
    std::string bytes(2048, '\0');
    const ssize_t count = ::recv(socket_.get(), bytes.data(), bytes.size(), 0);
    bytes.resize(count > 0 ? static_cast<std::size_t>(count) : 0);
    return bytes;
  }

 private:
  static sockaddr_in to(const std::string& address, int port) {
    sockaddr_in result{};
    result.sin_family = AF_INET;
    result.sin_port = htons(static_cast<std::uint16_t>(port));
    ::inet_pton(AF_INET, address.c_str(), &result.sin_addr);
    return result;
  }

  device::Socket socket_;
  int port_ = 0;
};

class AbbEgmTest : public test::DrivenRobot<testing::Test> {
 protected:
  AbbEgmTest() : DrivenRobot({.period = kAbbPeriod, .still = 1e-3, .count = 50, .step = 0.01, .place = 0.02}) {}
  void begin(std::vector<std::string> options = {}, std::map<std::string, std::string> keys = {}, int joints = 6) {
    const int port = UdpSocket().port();
    options.insert(options.end(), {"--to", "127.0.0.1:" + std::to_string(port), "--comm-timeout", "2"});
    robot_.emplace(options, "abb_controller.py");
    keys["port"] = std::to_string(port);
    device_ = make_abb_egm_arm(abb_setup(keys, joints));
    drive("south", joints);
  }
};

TEST_F(AbbEgmTest, BeginsAtTheMeasuredPositionAndFollowsSetPoints) {
  begin({"--start", "10,-20,30,0,60,5"});
  ASSERT_TRUE(until([this] { return session_->active(); })) << text();
  EXPECT_NEAR(q_[0], 10 * kDegree, 1e-9);
  EXPECT_NEAR(q_[1], -20 * kDegree, 1e-9);
  velocity_ = 0.5;
  const double from = q_[0];
  bool measured_velocity = false;
  ASSERT_TRUE(until([&] {
    measured_velocity |= std::abs(session_->state().measured.qd[0] - 0.5) < 0.05;
    return q_[0] > from + 0.5;
  })) << text();
  EXPECT_TRUE(measured_velocity);
  velocity_ = 0.0;
  ASSERT_TRUE(until([&] { return std::abs(session_->state().measured.q[0] - q_[0]) < 1e-4; })) << text();
  const auto state = robot_->state();
  EXPECT_LT(state.at("first").get<double>(), 1e-6);
  EXPECT_EQ(state.at("malformed"), 0) << state;
  EXPECT_EQ(state.at("old"), 0);
  EXPECT_EQ(state.at("unknown_senders"), 0);
  EXPECT_EQ(state.at("runs"), 1);
}

TEST_F(AbbEgmTest, EndsAtTheLastSetPointWhenSetPointsCease) {
  begin();
  move();
  silent_ = true;
  const double last = q_[0];
  ASSERT_TRUE(until([this] { return kind() == msg::CauseKind::CAUSE_PROGRAM_STOPPED; })) << text();
  EXPECT_TRUE(says("set-points did not arrive for CommTimeout")) << text();
  EXPECT_EQ(robot_->state().at("timeouts"), 1);
  EXPECT_LE(robot_q()[0] * kDegree, last + 1e-3);
  silent_ = false;
  resumes(msg::CauseKind::CAUSE_PROGRAM_STOPPED);
}

TEST_F(AbbEgmTest, MotorsOffHoldTheArmUntilAPersonResumes) {
  begin();
  move();
  robot_->order("motors off");
  ASSERT_TRUE(until([this] { return kind() == msg::CauseKind::CAUSE_DEVICE_NOT_READY; })) << text();
  EXPECT_TRUE(says("the motors are off") && says("'hecaton resume south'")) << text();
  ASSERT_TRUE(until([this] { return stands(); }));
  robot_->order("motors on");
  ASSERT_TRUE(until([this] { return kind() == msg::CauseKind::CAUSE_PROGRAM_STOPPED; })) << text();
  EXPECT_TRUE(says("the RAPID program has stopped")) << text();
  robot_->order("program start");
  resumes(msg::CauseKind::CAUSE_DEVICE_NOT_READY);
}

TEST_F(AbbEgmTest, ReportsEachEndOfGuidanceWithItsKind) {
  begin();
  for (const auto& [order, expected, words] :
       {std::tuple("program stop", msg::CauseKind::CAUSE_PROGRAM_STOPPED, "the RAPID program has stopped"),
        std::tuple("egm_error", msg::CauseKind::CAUSE_PROTECTIVE_STOP, "EGM reports an error"),
        std::tuple("egm_stop", msg::CauseKind::CAUSE_PROGRAM_STOPPED, "EGM has ended")}) {
    move();
    robot_->order(order);
    ASSERT_TRUE(until([&, kind = expected] { return this->kind() == kind; })) << order << ": " << text();
    EXPECT_TRUE(says(words)) << text();
    if (std::string(order) != "egm_stop") robot_->order("program start");
    resumes(expected);
  }
}

TEST_F(AbbEgmTest, NamesTheConvergenceOfTheArmAsTheReason) {
  begin();
  run();
  robot_->order("cond_time 0.1");
  ASSERT_TRUE(until([this] { return kind() == msg::CauseKind::CAUSE_PROGRAM_STOPPED; })) << text();
  EXPECT_TRUE(says("CondTime of EGMRunJoint")) << text();
  robot_->order("cond_time 86400");
  resumes(msg::CauseKind::CAUSE_PROGRAM_STOPPED);
}

TEST_F(AbbEgmTest, TakesTheSilenceOfTheRobotAsALostConnection) {
  begin();
  move();
  robot_->order("cable pulled");
  ASSERT_TRUE(until([this] { return session_->failed(); }));
  EXPECT_TRUE(says("has sent nothing for 2000 ms")) << text();
  EXPECT_EQ(kind(), msg::CauseKind::CAUSE_DEVICE_FAILED);
  ASSERT_TRUE(until([this] { return stands(); }));
  robot_->order("cable plugged");
  resumes(msg::CauseKind::CAUSE_DEVICE_FAILED);
}

TEST_F(AbbEgmTest, FollowsARestartedControllerOnlyAfterAResume) {
  begin();
  move();
  robot_->order("restart");
  ASSERT_TRUE(until([this] { return session_->failed(); })) << text();
  robot_->order("undefined on");
  robot_->order("motors on");
  robot_->order("program start");
  resumes(msg::CauseKind::CAUSE_DEVICE_FAILED);
}

TEST_F(AbbEgmTest, ReportsTheMotionOfARampDown) {
  begin({"--stop", "ramp_down"});
  move();
  robot_->order("egm_stop");
  ASSERT_TRUE(until([this] { return kind() == msg::CauseKind::CAUSE_PROGRAM_STOPPED; })) << text();
  EXPECT_TRUE(until([this] { return session_->state().measured.qd[0] < -0.01; })) << "the robot moves back by itself";
  EXPECT_FALSE(session_->active());
}

TEST_F(AbbEgmTest, SurvivesNoiseLossAndDisorder) {
  begin();
  run();
  robot_->order("twice on");
  robot_->order("reordered on");
  robot_->order("loss 0.05");
  velocity_ = 0.2;
  for (int i = 0; i < 20; ++i) {
    robot_->order("noise 50");
    const double from = q_[0];
    ASSERT_TRUE(until([&] { return q_[0] > from + 0.02; })) << text();
    ASSERT_NEAR(session_->state().measured.q[0], q_[0], 0.1);
  }
  velocity_ = 0.0;
  ASSERT_TRUE(until([&] { return std::abs(session_->state().measured.q[0] - q_[0]) < 1e-3; })) << text();
  const auto state = robot_->state();
  EXPECT_EQ(state.at("malformed"), 0);
  EXPECT_EQ(state.at("old"), 0);
  EXPECT_EQ(state.at("runs"), 0) << "since the order to forget: EGM has not begun again";
}

TEST_F(AbbEgmTest, BelievesTheFirstSenderAlone) {
  begin();
  run();
  for (int i = 0; i < 20; ++i) {
    robot_->order("impostor 127.0.0.77");
    for (int periods = 0; periods < 5; ++periods) {
      period();
      ASSERT_LT(std::abs(session_->state().measured.q[1]), 1e-3);
    }
  }
  EXPECT_TRUE(session_->active()) << text();
}

TEST_F(AbbEgmTest, NamesAnotherSenderThanTheRobot) {
  begin({}, {{"robot_ip", "127.0.0.99"}});
  ASSERT_TRUE(until([this] { return kind() == msg::CauseKind::CAUSE_DEVICE_NOT_READY; })) << text();
  EXPECT_TRUE(says("the robot at 127.0.0.99 sends no EGM messages")) << text();
  EXPECT_TRUE(says("datagrams of " + robot_->address() + " are ignored")) << text();
}

TEST_F(AbbEgmTest, SendsTheSeventhJointAsExternalAxis) {
  begin({"--start", "1,2,3,4,5,6", "--external", "-40"}, {}, 7);
  run();
  const std::vector<double> expected{1, 2, -40, 3, 4, 5, 6};
  for (int joint = 0; joint < 7; ++joint) EXPECT_NEAR(q_[joint], expected[joint] * kDegree, 1e-6);
  q_[2] += 1e-3;
  q_[3] -= 1e-3;
  ASSERT_TRUE(until([this] { return std::abs(robot_q()[6] - (-40 + 1e-3 / kDegree)) < 1e-3; })) << text();
  EXPECT_NEAR(robot_q()[2], 3 - 1e-3 / kDegree, 1e-3);
  EXPECT_EQ(robot_->state().at("malformed"), 0);
}

TEST_F(AbbEgmTest, RefusesASetPointThatJumps) {
  begin();
  run();
  q_[3] += 0.3;
  ASSERT_TRUE(until([this] { return session_->failed(); }));
  EXPECT_TRUE(says("the set-point of joint 4 jumps by 0.3000")) << text();
  EXPECT_LT(robot_->state().at("fastest").get<double>(), 0.1);
}

TEST_F(AbbEgmTest, NamesWhatItCannotUse) {
  begin({}, {}, 7);
  ASSERT_TRUE(until([this] { return session_->failed(); }));
  EXPECT_TRUE(says("reports 6 joints and 0 additional axes, but arm south needs six joints and an additional axis"))
      << text();
}

TEST_F(AbbEgmTest, RefusesARobotWithAnAxisThatTheCellFileDoesNotHave) {
  begin({"--external", "-40"});
  ASSERT_TRUE(until([this] { return session_->failed(); }));
  EXPECT_TRUE(
      says("reports an additional axis at -40.00 (degrees or mm), which arm south does not have: describe it in "
           "the cell file, or move it to 0 and leave it there"))
      << text();
  EXPECT_EQ(robot_->state().at("fastest"), 0.0);
}

TEST_F(AbbEgmTest, RefusesWrongJointsOldSoftwareAndValuesThatAreNotFinite) {
  begin();
  run();
  robot_->order("shown_joints 4");
  ASSERT_TRUE(until([this] { return says("reports 4 joints"); })) << text();
  robot_->order("shown_joints 6");
  robot_->order("old_software on");
  ASSERT_TRUE(until([this] { return says("RobotWare before 6.07"); })) << text();
  robot_->order("old_software off");
  resumes(msg::CauseKind::CAUSE_DEVICE_FAILED);
  robot_->order("not_finite on");
  ASSERT_TRUE(until([this] { return says("has sent nothing for 2000 ms"); })) << text();
  EXPECT_TRUE(says("datagrams could not be read")) << text();
}

TEST_F(AbbEgmTest, NamesATakenPort) {
  const UdpSocket other("0.0.0.0");
  device_ = make_abb_egm_arm(abb_setup({{"port", std::to_string(other.port())}}));
  session_.emplace(DeviceSessionSetup{"south", 6, 10.0}, *device_, std::nullopt);
  ASSERT_TRUE(until([this] { return session_->failed(); }));
  EXPECT_TRUE(says("cannot listen on UDP port " + std::to_string(other.port()) + " of this machine")) << text();
}

TEST(AbbEgm, RefusesWrongKeys) {
  const auto refusal = [](const std::map<std::string, std::string>& keys, int joints = 6) -> std::string {
    device::DeviceSetup setup = abb_setup(keys, joints);
    if (joints == 6) setup.prismatic = {false, false, false, false, false, false};
    if (joints == 7) setup.prismatic = {true, false, false, false, false, false, false};
    try {
      (void)make_abb_egm_arm(setup);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "nothing";
  };
  EXPECT_EQ(refusal({}), "nothing");
  EXPECT_EQ(refusal({{"external_axis", "1"}}, 7), "nothing") << "a robot on a track";
  EXPECT_EQ(refusal({{"robot_ip", "abb.local"}}),
            "cell.yaml: arms[0].device.robot_ip = abb.local must be an IPv4 address, such as 192.168.0.10");
  EXPECT_EQ(refusal({{"port", "80"}}), "cell.yaml: arms[0].device.port = 80 must be 1024 to 65535");
  EXPECT_EQ(refusal({{"external_axis", "2"}}),
            "cell.yaml: arms[0].device.external_axis = 2 must be of an arm with seven joints, but arm south has six");
  EXPECT_EQ(refusal({}, 7),
            "cell.yaml: arms[0].device.type = abb_egm must be of an arm whose joints turn, except its additional axis, "
            "but joint 1 of arm south is prismatic");
  EXPECT_EQ(refusal({}, 4),
            "cell.yaml: arms[0].device.type = abb_egm must be of an arm with six or seven joints, but arm south has 4");
}

// --- messages

/// Writes protocol buffers for tests, also wrong ones.
struct Writer {
  std::string bytes;

  Writer& varint(std::uint64_t value) {
    for (; value > 0x7FU; value >>= 7U) bytes.push_back(static_cast<char>((value & 0x7FU) | 0x80U));
    bytes.push_back(static_cast<char>(value));
    return *this;
  }
  Writer& number(unsigned field, std::uint64_t value) { return varint(field << 3U).varint(value); }
  Writer& raw(double value) {
    char part[sizeof value];
    std::memcpy(part, &value, sizeof value);
    bytes.append(part, sizeof value);
    return *this;
  }
  Writer& real(unsigned field, double value) { return varint(field << 3U | 1U).raw(value); }
  Writer& block(unsigned field, const Writer& content) {
    varint(field << 3U | 2U).varint(content.bytes.size());
    bytes += content.bytes;
    return *this;
  }
};

Writer abb_joints(int count, double first = 1.0) {
  Writer joints;
  for (int joint = 0; joint < count; ++joint) joints.real(1, first + joint);
  return joints;
}
Writer abb_feedback(const Writer& joints, const Writer& additional = abb_joints(1, -7.5)) {
  return Writer().block(1, joints).block(3, additional).block(4, Writer().number(1, 1700000000).number(2, 123456));
}
Writer abb_header(std::uint32_t number = 7) {
  return Writer().number(1, number).number(2, 4'000'000'000U).number(3, 2);
}
Writer abb_message(const Writer& feedback) {
  return Writer()
      .block(1, abb_header())
      .block(2, feedback)
      .block(4, Writer().number(1, 1))
      .block(5, Writer().number(1, 3))
      .number(6, 1)
      .block(8, Writer().number(1, 2));
}

TEST(EgmMessages, ReadsAMessageOfARobot) {
  const auto message = egm::decode(abb_message(abb_feedback(abb_joints(6))).bytes);
  ASSERT_TRUE(message);
  EXPECT_EQ(message->sequence_number, 7U);
  EXPECT_EQ(message->sent_ms, 4'000'000'000U);
  EXPECT_EQ(message->joints.count, 6U);
  EXPECT_EQ(message->joints.get()[5], 6.0);
  EXPECT_EQ(message->external.count, 1U);
  EXPECT_EQ(message->external.get()[0], -7.5);
  EXPECT_EQ(message->clock_us, 1'700'000'000'123'456U);
  EXPECT_EQ(message->motors, egm::MotorState::kOn);
  EXPECT_EQ(message->guidance, egm::GuidanceState::kRunning);
  EXPECT_EQ(message->rapid, egm::RapidState::kRunning);
  EXPECT_TRUE(message->converged);
}

TEST(EgmMessages, ReadsPackedJointsAndSkipsUnknownFields) {
  Writer packed;
  for (int joint = 0; joint < 6; ++joint) packed.raw(joint);
  Writer feedback = abb_feedback(Writer().block(1, packed));
  feedback.number(90, 5).real(91, 1.0).block(92, packed).varint(93U << 3U | 5U).bytes += "four";
  const auto message = egm::decode(abb_message(feedback).number(2000, 1).bytes);
  ASSERT_TRUE(message);
  EXPECT_EQ(message->joints.get()[5], 5.0);
}

TEST(EgmMessages, RefusesDamagedMessages) {
  const double infinite = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(egm::decode(""));
  EXPECT_FALSE(egm::decode(abb_message(abb_feedback(abb_joints(7))).bytes)) << "more joints than there is room for";
  EXPECT_FALSE(egm::decode(abb_message(abb_feedback(abb_joints(5).real(1, infinite))).bytes));
  EXPECT_FALSE(egm::decode(abb_message(abb_feedback(abb_joints(5).number(1, 3))).bytes)) << "a joint that is no double";
  EXPECT_FALSE(egm::decode(abb_message(Writer().number(1, 1)).bytes));
  EXPECT_FALSE(egm::decode(abb_message(abb_feedback(abb_joints(6))).number(0, 1).bytes)) << "field 0";
  EXPECT_FALSE(egm::decode(abb_message(abb_feedback(abb_joints(6))).varint(12U << 3U | 3U).bytes)) << "a group";
  Writer endless = abb_message(abb_feedback(abb_joints(6))).varint(12U << 3U);
  endless.bytes += std::string(10, '\xff') + "\1";
  EXPECT_FALSE(egm::decode(endless.bytes));
  Writer beyond = abb_message(abb_feedback(abb_joints(6))).varint(12U << 3U | 2U).varint(~std::uint64_t{0});
  EXPECT_FALSE(egm::decode(beyond.bytes));
  // The states of motors, EGM and RAPID come last: a message that ends before them is not believed.
  const std::string whole = abb_message(abb_feedback(abb_joints(6))).bytes;
  for (std::size_t size = 0; size < whole.size(); ++size) EXPECT_FALSE(egm::decode(whole.substr(0, size))) << size;
}

TEST(EgmMessages, TakesStatesOfLaterVersionsAsUndefined) {
  const auto message = egm::decode(abb_message(abb_feedback(abb_joints(6))).block(4, Writer().number(1, 9)).bytes);
  ASSERT_TRUE(message);
  EXPECT_EQ(message->motors, egm::MotorState::kUndefined);
}

TEST(EgmMessages, WritesSetPointsAsTheReferenceImplementationDoes) {
  egm::SensorMessage message{300, 70000, {}, {}};
  for (int joint = 0; joint < 6; ++joint) (void)message.joints.add(joint - 2.5);
  (void)message.external.add(40.0);
  egm::SensorBuffer buffer;
  const std::string_view bytes = egm::encode(message, buffer);
  std::string hex;
  for (const char byte : bytes) {
    constexpr std::string_view kDigits = "0123456789abcdef";
    hex += kDigits[static_cast<unsigned char>(byte) >> 4U];
    hex += kDigits[static_cast<unsigned char>(byte) & 15U];
  }
  EXPECT_EQ(hex,
            "0a0908ac0210f0a204180312430a360900000000000004c009000000000000f8bf09000000000000e0bf09000000000000e03f0900"
            "0000000000f83f0900000000000004401a09090000000000004440");
}

TEST(EgmMessages, HasRoomForTheLargestSetPoint) {
  egm::SensorMessage message{0xFFFFFFFFU, 0xFFFFFFFFU, {}, {}};
  while (message.joints.add(1e300)) (void)message.external.add(-1e300);
  egm::SensorBuffer buffer;
  EXPECT_LE(egm::encode(message, buffer).size(), egm::kLargestSensorMessage);
}

TEST(EgmMessages, SurvivesRandomAndTruncatedMessages) {
  std::mt19937 random(3);
  const std::string whole = abb_message(abb_feedback(abb_joints(6))).bytes;
  int read = 0;
  for (int i = 0; i < 300'000; ++i) {
    std::string bytes = whole;
    if (i % 3 == 0) {
      bytes.resize(random() % 200);
      for (char& byte : bytes) byte = static_cast<char>(random() % (i % 2 == 0 ? 256 : 32));
    } else {
      for (unsigned flips = 1 + random() % 4; flips > 0; --flips)
        bytes[random() % bytes.size()] ^= static_cast<char>(1U << random() % 8);
      if (i % 3 == 1) bytes.resize(random() % bytes.size());
    }
    // Memory of its own, of exactly this size: AddressSanitizer sees each byte that is read beyond it.
    const std::vector<char> exact(bytes.begin(), bytes.end());
    const auto message = egm::decode({exact.data(), exact.size()});
    if (!message) continue;
    ++read;
    for (const double value : message->joints.get()) ASSERT_TRUE(std::isfinite(value));
    for (const double value : message->external.get()) ASSERT_TRUE(std::isfinite(value));
  }
  EXPECT_GT(read, 1000) << "changed values alone leave a message that can be read";
}

TEST(AbbEgm, AnswersNoRandomDatagram) {
  constexpr int kDatagrams = 100'000;
  constexpr int kInAPeriod = 20;
  const int port = UdpSocket().port();
  const auto arm = make_abb_egm_arm(abb_setup({{"port", std::to_string(port)}}));
  ASSERT_FALSE(arm->configure());
  const UdpSocket robot;
  std::mt19937 random(11);
  const std::string whole = abb_message(abb_feedback(abb_joints(6), {})).bytes;
  for (int sent = 0; sent < kDatagrams; ++sent) {
    std::string bytes = whole.substr(0, random() % whole.size());
    if (random() % 2 == 0) {
      bytes.resize(random() % 600);
      for (char& byte : bytes) byte = static_cast<char>(random());
    }
    robot.send(bytes, port);
    if (sent % kInAPeriod != 0) continue;
    ASSERT_NE(arm->read(device::Clock::now()).mode, device::DeviceMode::kReady);
    ASSERT_EQ(robot.receive(), "");
  }
  robot.send(whole, port);
  EXPECT_EQ(arm->read(device::Clock::now()).mode, device::DeviceMode::kReady);
  EXPECT_NE(robot.receive(), "");
}

TEST(AbbEgm, TakesAnImpossibleStepAsNoMeasurement) {
  const int port = UdpSocket().port();
  const auto arm = make_abb_egm_arm(abb_setup({{"port", std::to_string(port)}}));
  ASSERT_FALSE(arm->configure());
  const UdpSocket robot;
  const auto now = device::Clock::now();
  robot.send(abb_message(abb_feedback(abb_joints(6), {})).bytes, port);
  const auto before = arm->read(now).measured.q;
  ASSERT_EQ(before.size(), 6);
  Writer far = abb_message(abb_feedback(abb_joints(6, 50.0), {}));
  far.block(1, abb_header(8));
  robot.send(far.bytes, port);
  EXPECT_EQ(arm->read(now + 4ms).measured.q, before);
}

}  // namespace
}  // namespace hecaton::services
