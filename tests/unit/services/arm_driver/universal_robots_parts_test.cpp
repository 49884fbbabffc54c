// Parts of the device of Universal Robots: models, texts for people, keys, and bytes of any kind.
#include <array>
#include <random>
#include <string>
#include <vector>

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include "services/arm_driver/devices/universal_robots/program.hpp"
#include "services/arm_driver/devices/universal_robots/robot_state.hpp"
#include "services/arm_driver/devices/universal_robots/robot_type.hpp"
#include "services/arm_driver/devices/universal_robots/rtde.hpp"
#include "services/arm_driver/devices/universal_robots/rtde_client.hpp"
#include "services/arm_driver/devices/universal_robots/tcp.hpp"
#include "services/arm_driver/devices/universal_robots/universal_robots_arm.hpp"
#include "tests/unit/services/arm_driver/universal_robots_setup.hpp"

namespace hecaton::services {
namespace {

using namespace std::chrono_literals;
using test::ur_setup;
using Clock = device::Clock;

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
    device::DeviceSetup setup = ur_setup("192.168.0.10", keys);
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
