#include "services/arm_driver/device_choice.hpp"

#include <filesystem>
#include <optional>

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include "services/arm_driver/device_plugin.hpp"
#include "services/arm_driver/devices/socket.hpp"
#include "services/arm_driver/taken_ports.hpp"
#include "services/config/yaml_tree.hpp"
#include "tests/support/temporary_folder.hpp"

namespace hecaton::services {
namespace {

config::CellFile cell(const std::string& device) {
  const std::string text =
      "name: tiny\n"
      "arms:\n"
      "  - name: left\n"
      "    urdf: urdf/puma560.urdf\n" +
      device + "    poses: {home: [0, -1.9, 2.6, 0, 0.6, 0]}\n";
  return config::parse_cell_file(text, std::string(HECATON_SOURCE_DIR) + "/deploy/cells/tiny.yaml");
}

/// The sentence of a refusal, from the key on.
std::string refusal(const std::string& device) {
  try {
    require_known_devices(cell(device));
  } catch (const config::ConfigError& error) {
    const std::string sentence = error.what();
    return sentence.substr(sentence.find(": ") + 2);
  }
  return "nothing";
}

TEST(DeviceChoice, IsASimulatedArmByDefault) {
  EXPECT_EQ(cell("").devices.at(0).type, "simulated");
  EXPECT_EQ(refusal(""), "nothing");
  EXPECT_EQ(refusal("    device: {type: simulated}\n"), "nothing");
  EXPECT_NE(make_device(cell(""), 0, "", device::device_types()), nullptr);
}

TEST(DeviceChoice, NamesTheArmInEachStep) {
  EXPECT_TRUE(device_steps(cell("")).empty()) << "a simulated arm follows by itself";
  for (const device::DeviceType& type : device::device_types()) {
    for (const std::string_view step : type.steps) EXPECT_NE(step.find("ARM"), std::string_view::npos) << step;
  }
  const auto steps = device_steps(cell("    device: {type: abb_egm, port: 6510}\n"));
  ASSERT_EQ(steps.size(), 3U);
  EXPECT_TRUE(steps[0].starts_with("# at the FlexPendant of left: ")) << steps[0];
  EXPECT_EQ(steps[1], "hecaton resume left");
}

TEST(DeviceChoice, RefusesUnknownTypesAndKeys) {
  EXPECT_EQ(refusal("    device: {type: telepathic}\n"),
            "arms[0].device.type = telepathic must be simulated, universal_robots, abb_egm, ros2_control, program or "
            "observed");
  EXPECT_EQ(refusal("    device: {type: simulated, typ: x}\n"),
            "arms[0].device.typ is not a known key; did you mean 'type'? A device of type simulated may have type, "
            "servo, servo_period, dead_time, jitter, lag, damping, noise, resolution, protective_speed, "
            "protective_effort");
  EXPECT_EQ(refusal("    device: simulated\n"),
            "arms[0].device = simulated must be a map with the key type, such as {type: simulated}");
  EXPECT_EQ(refusal("    device: {port: /dev/ttyS0}\n"),
            "arms[0].device = {port: /dev/ttyS0} must be a map with the key type, such as {type: simulated}");
}

TEST(DeviceChoice, RefusesTwoDevicesOfOneHostOnOnePort) {
  const std::string robot = "    device: {type: universal_robots, robot_ip: 192.168.0.10, reverse_port: 50002}\n";
  EXPECT_EQ(refusal(robot), "nothing");
  EXPECT_EQ(refusal(robot + "    poses: {home: [0, -1.9, 2.6, 0, 0.6, 0]}\n"
                            "  - name: right\n"
                            "    urdf: urdf/puma560.urdf\n"
                            "    base: {xyz: [2, 0, 0]}\n"
                            "    device: {type: universal_robots, robot_ip: 192.168.0.11}\n"),
            "arms[1].device.reverse_port = 50002 must be a port of its own: the device of arm left on host localhost "
            "listens on it");
  const std::string egm = "    device: {type: abb_egm, port: 6511}\n";
  EXPECT_EQ(refusal(egm), "nothing");
  EXPECT_EQ(refusal(egm + "    poses: {home: [0, -1.9, 2.6, 0, 0.6, 0]}\n"
                          "  - name: right\n"
                          "    urdf: urdf/puma560.urdf\n"
                          "    base: {xyz: [2, 0, 0]}\n"
                          "    device: {type: abb_egm}\n"),
            "arms[1].device.port = 6511 must be a port of its own: the device of arm left on host localhost listens on "
            "it")
      << "6510 and the place of the arm";
  EXPECT_EQ(refusal("    device: {type: universal_robots}\n"),
            "arms[0].device.robot_ip is missing; it must be the IPv4 address of the robot");
}

/// A port of this machine that this process holds.
class HeldPort {
 public:
  explicit HeldPort(int type) : socket_(::socket(AF_INET, type | SOCK_CLOEXEC, 0)) {
    sockaddr_in own{};
    own.sin_family = AF_INET;
    own.sin_addr.s_addr = htonl(INADDR_LOOPBACK);  // also one address of the machine is enough
    socklen_t size = sizeof own;
    EXPECT_EQ(::bind(socket_.get(), reinterpret_cast<const sockaddr*>(&own), size), 0);
    if (type == SOCK_STREAM) {
      EXPECT_EQ(::listen(socket_.get(), 1), 0);
    }
    EXPECT_EQ(::getsockname(socket_.get(), reinterpret_cast<sockaddr*>(&own), &size), 0);
    number_ = std::to_string(ntohs(own.sin_port));
  }
  [[nodiscard]] const std::string& number() const { return number_; }

 private:
  device::Socket socket_;
  std::string number_;
};

TEST(DeviceChoice, NamesTheProgramThatHoldsAPort) {
  const auto taken = [](const std::string& device) {
    return taken_ports(cell("    device: {type: " + device + "}\n"));
  };
  const std::string robot = "universal_robots, robot_ip: 192.168.0.10, reverse_port: ";
  const std::string holder = " (process " + std::to_string(::getpid()) + ") holds ";
  std::optional<HeldPort> tcp(SOCK_STREAM);
  const auto of_tcp = taken(robot + tcp->number());
  ASSERT_EQ(of_tcp.size(), 1U);
  EXPECT_NE(of_tcp[0].text.find("arms[0].device.reverse_port = " + tcp->number() +
                                " must be a free port of this machine: arm_driver_test"),
            std::string::npos)
      << of_tcp[0].text;
  EXPECT_TRUE(of_tcp[0].text.ends_with(holder + "TCP port " + tcp->number() +
                                       "; end that program, or set another port for arm left"))
      << of_tcp[0].text;
  EXPECT_FALSE(of_tcp[0].by_driver);

  const HeldPort udp(SOCK_DGRAM);
  const auto of_udp = taken("abb_egm, port: " + udp.number());
  ASSERT_EQ(of_udp.size(), 1U);
  EXPECT_NE(of_udp[0].text.find("arms[0].device.port = " + udp.number()), std::string::npos) << of_udp[0].text;
  EXPECT_NE(of_udp[0].text.find(holder + "UDP port " + udp.number()), std::string::npos) << of_udp[0].text;

  const std::string number = tcp->number();
  tcp.reset();
  EXPECT_TRUE(taken(robot + number).empty()) << "it is free again";
  EXPECT_TRUE(taken("simulated").empty());
}

TEST(DeviceChoice, LeavesPortsOfOtherHostsAlone) {
  const HeldPort port(SOCK_STREAM);
  const auto taken = [&](const std::string& host) {
    return taken_ports(config::parse_cell_file(
                           "name: tiny\n"
                           "hosts: {here: 127.0.0.1, there: 203.0.113.9}\n"
                           "world: {host: here}\n"
                           "supervision: {host: here}\n"
                           "arms:\n"
                           "  - name: left\n"
                           "    urdf: urdf/puma560.urdf\n"
                           "    host: " +
                               host +
                               "\n"
                               "    poses: {home: [0, -1.9, 2.6, 0, 0.6, 0]}\n"
                               "    device: {type: universal_robots, robot_ip: 192.168.0.10, reverse_port: " +
                               port.number() + "}\n",
                           std::string(HECATON_SOURCE_DIR) + "/deploy/cells/tiny.yaml"))
        .size();
  };
  EXPECT_EQ(taken("here"), 1U);
  EXPECT_EQ(taken("there"), 0U);
}

TEST(DeviceChoice, RefusesTwoArmsOfOneController) {
  const auto two = [](const std::string& first, const std::string& second) {
    return refusal("    device: {type: " + first +
                   "}\n"
                   "    poses: {home: [0, -1.9, 2.6, 0, 0.6, 0]}\n"
                   "  - name: right\n"
                   "    urdf: urdf/puma560.urdf\n"
                   "    base: {xyz: [2, 0, 0]}\n"
                   "    device: {type: " +
                   second + "}\n");
  };
  const std::string ros2 = "ros2_control";
  EXPECT_EQ(two(ros2, ros2 + ", namespace: /right"), "nothing");
  EXPECT_EQ(two(ros2, ros2 + ", domain: 3"), "nothing");
  EXPECT_EQ(
      two(ros2, ros2 + ", joint_prefix: right_"),
      "arms[1].device.controller must be another one: /joint_trajectory_controller in domain 0 of ROS 2 moves arm "
      "left already");
  const std::string robot = "universal_robots, robot_ip: 192.168.0.1";
  EXPECT_EQ(two(robot + "0", robot + "1"), "nothing");
  EXPECT_EQ(two(robot + "0", robot + "0"),
            "arms[1].device.robot_ip must be another one: the robot at 192.168.0.10 moves arm left already");
}

TEST(DeviceChoice, GivesTheDeviceItsKeysAndTheArm) {
  static device::DeviceSetup given;
  const device::DeviceType serial{"serial", {"port", "baud"}, [](const device::DeviceSetup& setup) {
                                    given = setup;
                                    return std::unique_ptr<device::ArmDevice>();
                                  }};
  const auto file = cell("    device: {type: serial, port: /dev/ttyS0, baud: 115200}\n");
  EXPECT_EQ(make_device(file, 0, "kept", std::span(&serial, 1)), nullptr);
  EXPECT_EQ(given.arm, "left");
  EXPECT_EQ(given.values.at("port"), "/dev/ttyS0");
  EXPECT_EQ(given.values.at("baud"), "115200");
  EXPECT_EQ(given.checkpoint, "kept");
  EXPECT_EQ(given.joint_names, file.cell.arms[0].arm.model->joint_names);
  EXPECT_EQ(given.period, std::chrono::milliseconds(2));
  EXPECT_EQ(given.start, file.cell.arms[0].arm.home());
  EXPECT_TRUE(given.where.ends_with("tiny.yaml: arms[0].device"));
  EXPECT_EQ(given.forces.reason, "link shoulder has no mass in the robot description (<inertial>)");
}

TEST(DeviceChoice, GivesTheDeviceTheForcesOfTheArmInItsPlace) {
  static device::DeviceSetup given;
  const device::DeviceType serial{"serial", {}, [](const device::DeviceSetup& setup) {
                                    given = setup;
                                    return std::unique_ptr<device::ArmDevice>();
                                  }};
  // 2 kg half a metre from an axis along y of the base.
  const test::TemporaryFolder folder;
  folder.write("arm.urdf",
               "<robot name='r'><link name='base'/><link name='arm'><inertial><origin xyz='0.5 0 0'/><mass value='2'/>"
               "<inertia ixx='0' ixy='0' ixz='0' iyy='0' iyz='0' izz='0'/></inertial>"
               "<collision><geometry><sphere radius='0.1'/></geometry></collision></link>"
               "<joint name='turn' type='revolute'><parent link='base'/><child link='arm'/><axis xyz='0 -1 0'/>"
               "<limit lower='-2' upper='2' velocity='1' effort='30'/></joint></robot>");
  const auto force_on_base = [&](const std::string& rpy) {
    const std::string text = "name: tiny\narms:\n  - {name: left, urdf: arm.urdf, base: {rpy: " + rpy +
                             "}, poses: {home: [0]}, device: {type: serial}}\n";
    (void)make_device(config::parse_cell_file(text, folder.path("tiny.yaml")), 0, "", std::span(&serial, 1));
    const auto zero = device::JointVector::Zero(1);
    return given.forces.of_motion(zero, zero, zero)[0];
  };
  EXPECT_NEAR(force_on_base("[0, 0, 0]"), 9.80665, 1e-9);
  EXPECT_NEAR(force_on_base("[3.141592653589793, 0, 0]"), -9.80665, 1e-9) << "it hangs from the ceiling";
  EXPECT_NEAR(force_on_base("[1.5707963267948966, 0, 0]"), 0.0, 1e-9) << "on a wall the axis carries it";
  EXPECT_EQ(given.forces.limits, device::JointVector::Constant(1, 30.0));
}

const std::string kPlugins = HECATON_PLUGINS;

// Other arms plan around a lost arm only where it is at rest.
TEST(DeviceChoice, KnowsWhichArmsStopWithoutTheirDriver) {
  const auto stops = [](const std::string& device) -> bool {
    return stop_without_driver(cell(device.empty() ? device : "    device: {type: " + device + "}\n")).at(0);
  };
  EXPECT_TRUE(stops(""));
  EXPECT_TRUE(stops("universal_robots, robot_ip: 192.168.0.10"));
  EXPECT_TRUE(stops("abb_egm"));
  EXPECT_TRUE(stops("program"));
  for (const char* interface : {"position", "trajectory", "action"}) {
    EXPECT_TRUE(stops(std::string("ros2_control, interface: ") + interface)) << interface;
  }
  EXPECT_FALSE(stops("ros2_control, interface: velocity"));
  EXPECT_FALSE(stops("observed, source: simulated")) << "others may move it";
  EXPECT_FALSE(stops("serial, plugin: /nowhere/libarm.so, port: can0")) << "not known, and nothing is loaded";
  EXPECT_FALSE(stops("ros2_control, interface: effort")) << "not known";
}

std::string plugin_device(const std::string& type, const std::string& plugin) {
  return "    device: {type: " + type + ", plugin: " + plugin + ", port: can0}\n";
}

TEST(DeviceChoice, TakesTheTypesOfAPlugin) {
  EXPECT_EQ(refusal(plugin_device("serial", kPlugins + "/two_types.so")), "nothing");
  EXPECT_EQ(refusal(plugin_device("can_bus", kPlugins + "/two_types.so")), "nothing");
  EXPECT_EQ(refusal(plugin_device("observed, source: serial", kPlugins + "/two_types.so")), "nothing");
  const auto device =
      make_device(cell(plugin_device("serial", kPlugins + "/two_types.so")), 0, "", device::device_types());
  ASSERT_NE(device, nullptr);
  EXPECT_EQ(device->configure()->text, "moves nothing");
}

TEST(DeviceChoice, RefusesAPluginThatCannotBeUsed) {
  EXPECT_EQ(refusal(plugin_device("serial", "/nowhere/libarm.so")),
            "arms[0].device.plugin = /nowhere/libarm.so must be a shared library with devices: there is no such file");
  const std::string text = std::string(HECATON_SOURCE_DIR) + "/README.md";
  EXPECT_TRUE(
      refusal(plugin_device("serial", text)).starts_with("arms[0].device.plugin = " + text + " cannot be loaded: "));
  EXPECT_EQ(refusal(plugin_device("serial", kPlugins + "/no_plugin.so")),
            "arms[0].device.plugin = " + kPlugins +
                "/no_plugin.so is no device plug-in: it does not export hecaton_device_plugin_interface; see "
                "HECATON_DEVICE_PLUGIN");
  const std::string other = refusal(plugin_device("serial", kPlugins + "/other_interface.so"));
  EXPECT_TRUE(other.starts_with("arms[0].device.plugin = " + kPlugins +
                                "/other_interface.so was built for another program: it has 'interface 0', this one has "
                                "'interface 7, Eigen "))
      << other;
  EXPECT_EQ(refusal(plugin_device("simulated", kPlugins + "/two_types.so")),
            "arms[0].device.type = simulated must be serial, can_bus or observed: its plug-in " + kPlugins +
                "/two_types.so has no other");
  EXPECT_EQ(
      refusal("    device: {type: serial, plugin: " + kPlugins + "/two_types.so, prt: can0}\n"),
      "arms[0].device.prt is not a known key; did you mean 'port'? A device of type serial may have type, plugin, "
      "port");
}

TEST(DeviceChoice, FindsAPluginBesideTheCellFileOrAmongTheInstalledOnes) {
  const std::filesystem::path cell_file = kPlugins + "/cell.yaml";
  EXPECT_EQ(plugin_file("two_types.so", cell_file), kPlugins + "/two_types.so");
  EXPECT_EQ(plugin_file("./two_types.so", cell_file), kPlugins + "/two_types.so");
  EXPECT_EQ(plugin_file("../other/arm.so", cell_file),
            (std::filesystem::path(kPlugins).parent_path() / "other" / "arm.so").string());
  EXPECT_EQ(plugin_file("/usr/lib/arm.so", cell_file), "/usr/lib/arm.so");
  EXPECT_TRUE(plugin_file("arm.so", cell_file).string().ends_with("/lib/hecaton/devices/arm.so"));
}

}  // namespace
}  // namespace hecaton::services
