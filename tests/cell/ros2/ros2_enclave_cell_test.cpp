/// A cell with keys whose hecaton-ros2 is in an enclave of SROS2: nodes of ROS 2 with an enclave drive it, others see
/// and move nothing.

#include <cmath>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>

#include <idl/ros2/ros2PubSubTypes.h>

#include "services/security/keystore.hpp"
#include "tests/cell/cli/live_cell.hpp"
#include "tests/cell/ros2/ros_peer.hpp"
#include "tests/support/sros2_keystore.hpp"
#include "tests/support/temporary_folder.hpp"

namespace hecaton::test {
namespace {

using JointStates = PeerReader<sensor_msgs::msg::JointStatePubSubType>;
using JointGoals = PeerWriter<sensor_msgs::msg::JointStatePubSubType>;

class Ros2Enclave : public LiveCell {
 protected:
  void SetUp() override {
    services::create_keystore(folder_.path() / "keys", std::chrono::days(2));
    services::add_host(folder_.path() / "keys", "localhost", std::chrono::days(1));
    write_cell(cell_file(), "");
    LiveCell::SetUp();
  }
  [[nodiscard]] std::string cell_file() const override { return folder_.path() / "cell.yaml"; }

  static void write_cell(const std::string& path, const std::string& ros2) {
    std::ofstream(path)
        << "name: secured\n"
           "security: {keystore: keys}\n"
        << ros2
        << "timing: {control_period: 20ms, driver_period: 4ms, world_period: 20ms, command_timeout: 400ms}\n"
           "supervision: {heartbeat_deadline: 250ms, host_lease: 1s}\n"
           "defaults: {robot: ur5e}\n"
           "arms:\n"
           "  - {name: north, base: {xyz: [0, 0.8, 0]}}\n";
  }
  /// Runs hecaton-ros2, as the agent would start it, with this section `ros2`.
  [[nodiscard]] std::unique_ptr<Process> start_ros2(const std::string& keys) const {
    const std::string file = folder_.path() / "ros2.yaml";
    write_cell(file, "ros2: {domain: " + std::to_string(ros_domain_.number()) + ", distribution: jazzy" + keys + "}\n");
    return std::make_unique<Process>(
        std::vector<std::string>{std::string(HECATON_BIN_DIR) + "/hecaton-ros2", file, "--domain", domain()});
  }
  static void end(Process& process) {
    process.signal(SIGINT);
    EXPECT_EQ(process.wait(), 0) << process.err();
  }

  TemporaryFolder folder_;
  FreeDomain ros_domain_;
};

TEST_F(Ros2Enclave, ServesOnlyNodesWithAnEnclave) {
  Sros2Keystore keystore(folder_.path() / "ros");
  keystore.add("hecaton");
  const auto ros2 = start_ros2(", control: true, enclave: ros/enclaves/hecaton");

  RosPeer tool(ros_domain_.number(), 100, keystore.add("tool"));
  RosPeer open(ros_domain_.number(), 101);
  // Keys of another authority are none.
  Sros2Keystore foreign(folder_.path() / "foreign");
  RosPeer foreign_node(ros_domain_.number(), 102, foreign.add("tool"));
  JointStates seen(tool, "rt/joint_states");
  JointGoals goals(tool, "rt/north/goal_joints");
  JointStates stolen(open, "rt/joint_states");
  JointGoals forged(open, "rt/north/goal_joints");
  JointStates foreign_states(foreign_node, "rt/joint_states");
  JointGoals foreign_goals(foreign_node, "rt/north/goal_joints");

  const auto complete = [](const auto& message) { return message.position().size() == 6; };
  const auto first = seen.next(complete);
  ASSERT_TRUE(first) << ros2->err();
  ASSERT_TRUE(goals.wait_matched());
  sensor_msgs::msg::JointState goal;
  for (const char* joint : {"shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint", "wrist_1_joint",
                            "wrist_2_joint", "wrist_3_joint"}) {
    goal.name().push_back(joint);
  }
  goal.position(first->position());

  // Goals of nodes without such keys arrive nowhere.
  goal.position()[0] = first->position()[0] - 0.4;
  forged.write(goal);
  foreign_goals.write(goal);
  double lowest = first->position()[0];
  for (int i = 0; i < 100; ++i) {
    const auto state = seen.next(complete);
    ASSERT_TRUE(state);
    lowest = std::min(lowest, state->position()[0]);
  }
  EXPECT_GT(lowest, first->position()[0] - 0.01);
  EXPECT_FALSE(forged.matched());
  EXPECT_FALSE(foreign_goals.matched());
  EXPECT_TRUE(stolen.take().empty());
  EXPECT_TRUE(foreign_states.take().empty());

  // One of a node with an enclave moves the arm.
  const double target = first->position()[0] + 0.4;
  goal.position()[0] = target;
  goals.write(goal);
  EXPECT_TRUE(seen.next([&](const auto& message) {
    return complete(message) && std::abs(message.position()[0] - target) < 0.02;
  })) << ros2->err();
  end(*ros2);

  // In an open domain of ROS 2 the open node sees the same cell.
  const auto shown = start_ros2("");
  EXPECT_TRUE(stolen.next(complete)) << shown->err();
  EXPECT_FALSE(forged.wait_matched(2s)) << "without ros2.control no node drives a cell";
  end(*shown);
}

TEST_F(Ros2Enclave, IsRefusedWithTheFileThatIsMissing) {
  Sros2Keystore keystore(folder_.path() / "ros");
  std::filesystem::remove(keystore.add("hecaton") / "governance.p7s");
  const auto ros2 = start_ros2(", control: true, enclave: ros/enclaves/hecaton");
  EXPECT_NE(ros2->wait(), 0);
  EXPECT_NE(ros2->err().find("ros/enclaves/hecaton/governance.p7s: is missing"), std::string::npos) << ros2->err();
}

}  // namespace
}  // namespace hecaton::test
