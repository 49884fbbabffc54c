/// Samples that do not have the layout of their type, and many of the largest size, at every topic and service of
/// hecaton-ros2.

#include <map>
#include <random>
#include <thread>

#include <unistd.h>

#include "tests/cell/ros2/ros2_cell.hpp"

namespace hecaton::test {
namespace {

/// Most by which the service's memory may grow, whatever it receives: docs/reference/ros2.md, limits.
constexpr std::size_t kMostGrowth = 96U << 20U;  // [bytes]

/// The largest memory in use since reset_peak_memory().
std::size_t peak_memory(pid_t pid) {
  std::ifstream file("/proc/" + std::to_string(pid) + "/status");
  std::string word;
  std::size_t kilobytes = 0;
  while (file >> word) {
    if (word == "VmHWM:") file >> kilobytes;
  }
  return kilobytes * 1024;
}

/// Where the kernel cannot, peak_memory() is that since the start of the process.
void reset_peak_memory(pid_t pid) {
  std::ofstream("/proc/" + std::to_string(pid) + "/clear_refs") << "5";
}

const std::string kAction = "control_msgs::action::dds_::FollowJointTrajectory_";

/// All services: the DDS topic of the requests, and its type.
std::map<std::string, std::string> requests() {
  std::map<std::string, std::string> topics;
  for (const std::string of : {"hecaton", "north", "west", "east"}) {
    for (const std::string order : {"hold", "resume", "stop"}) {
      topics["rq/cell/" + of + "/" + order + "Request"] = "std_srvs::srv::dds_::Trigger_Request_";
    }
    if (of == "hecaton") continue;
    const std::string action = "rq/cell/" + of + "/follow_joint_trajectory/_action/";
    topics[action + "send_goalRequest"] = kAction + "SendGoal_Request_";
    topics[action + "get_resultRequest"] = kAction + "GetResult_Request_";
    topics[action + "cancel_goalRequest"] = "action_msgs::srv::dds_::CancelGoal_Request_";
  }
  return topics;
}

/// A well-formed request with the 16 bytes that rmw_cyclonedds puts before the body.
template <class PubSub>
bus::RawBytes with_header(typename PubSub::type request) {
  PubSub type;
#if HECATON_FAST_DDS == 3
  rtps::SerializedPayload_t payload(type.calculate_serialized_size(&request, dds::XCDR_DATA_REPRESENTATION));
  EXPECT_TRUE(type.serialize(&request, payload, dds::XCDR_DATA_REPRESENTATION));
#else
  rtps::SerializedPayload_t payload(type.getSerializedSizeProvider(&request)());
  EXPECT_TRUE(type.serialize(&request, &payload));
#endif
  bus::RawBytes bytes(payload.data, payload.data + payload.length);
  bytes.insert(bytes.begin() + 4, 16, 0);
  return bytes;
}

TEST_F(Ros2Cell, RefusesRequestsWithTheHeaderOfAnotherVendorAtEachService) {
  const Cell cell = connect();
  ActionClient client(*peer_, "north");
  ASSERT_TRUE(client.wait_available());
  const auto start = home(cell, "north");
  const auto of_west = home(cell, "west");
  const auto goal_of_west = cell.arm("west").goal();
  const auto id = client.send(client.ramp(start, {0.3, 0.1, -0.1, 0.2, 0.0, 0.0}, 60.0));
  ASSERT_TRUE(id);

  control_msgs::action::FollowJointTrajectory_SendGoal_Request goal;
  goal.goal_id().uuid({1, 2, 3});
  goal.goal(ActionClient(*peer_, "west").ramp(of_west, {0.3, 0.0, 0.0, 0.0, 0.0, 0.0}, 2.0));
  const std::map<std::string, bus::RawBytes> foreign{
      {"hold", with_header<std_srvs::srv::Trigger_RequestPubSubType>({})},
      {"send", with_header<control_msgs::action::FollowJointTrajectory_SendGoal_RequestPubSubType>(goal)},
      {"get", with_header<control_msgs::action::FollowJointTrajectory_GetResult_RequestPubSubType>({})},
      {"cancel", with_header<action_msgs::srv::CancelGoal_RequestPubSubType>({})}};  // all goals
  RosPeer other(ros_domain_->number(), 101);
  for (const auto& [topic, type] : requests()) {
    RawPeerType::name = type;
    PeerWriter<RawPeerType> writer(other, topic, {true, true, 10});
    ASSERT_TRUE(writer.wait_matched()) << topic;
    const bool order = type.find("Trigger") != std::string::npos;
    const std::string name = topic.substr(topic.rfind('/') + 1);
    writer.write(foreign.at(order ? "hold" : name.substr(0, name.find('_'))));
    ASSERT_TRUE(writer.wait_acknowledged()) << topic;
  }

  // The log tells of each service, of those of the action together.
  std::vector<std::string> untold;
  for (const std::string of : {"hecaton", "north", "west", "east"}) {
    for (const std::string order : {"hold", "resume", "stop"}) untold.push_back("/cell/" + of + "/" + order);
    if (of != "hecaton") untold.push_back("/cell/" + of + "/follow_joint_trajectory/_action/");
  }
  const auto until = std::chrono::steady_clock::now() + kLong;
  while (!untold.empty() && std::chrono::steady_clock::now() < until) {
    std::ifstream file(folder_->path("ros2.log"));
    for (std::string line; std::getline(file, line);) {
      if (line.find("messages ignored") == std::string::npos) continue;
      std::erase_if(untold, [&](const std::string& name) { return line.find(name) != std::string::npos; });
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(20));  // a file announces no change
  }
  EXPECT_TRUE(untold.empty()) << untold.front();
  const CellStatus status = cell.status(kLong);
  EXPECT_EQ(status.mode, CellMode::kRun) << "no hold was carried out";
  EXPECT_TRUE(status.stopped_arms.empty());
  EXPECT_EQ(cell.arm("west").goal()->goal, goal_of_west->goal) << "no trajectory was accepted";
  EXPECT_EQ(client.cancel(*id), 0) << "it was not cancelled before";
  const auto result = client.await_result(*id);
  ASSERT_TRUE(result);
  EXPECT_EQ(result->status(), kCanceled);
}

TEST_F(Ros2Cell, IgnoresMalformedSamplesWithinItsMemory) {
  const pid_t pid = ros2_->pid();
  ActionClient client(*peer_, "north");
  ASSERT_TRUE(client.wait_available());
  std::map<std::string, std::string> topics = requests();
  for (const std::string arm : {"north", "west", "east"}) {
    topics["rt/cell/" + arm + "/goal_joints"] = "sensor_msgs::msg::dds_::JointState_";
    topics["rt/cell/" + arm + "/goal_pose"] = "geometry_msgs::msg::dds_::PoseStamped_";
    topics["rt/cell/" + arm + "/planning_scene"] = "moveit_msgs::msg::dds_::PlanningScene_";
  }
  topics["rt/cell/robot_description"] = "std_msgs::msg::dds_::String_";
  topics["rt/cell/planning_scene"] = "moveit_msgs::msg::dds_::PlanningScene_";
  topics["ros_discovery_info"] = "rmw_dds_common::msg::dds_::ParticipantEntitiesInfo_";
  reset_peak_memory(pid);
  const std::size_t before = peak_memory(pid);
  RosPeer hostile(ros_domain_->number(), 101);
  std::mt19937 random(7);
  const std::array<std::uint8_t, 4> header{0, 1, 0, 0};
  for (const auto& [topic, type] : topics) {
    RawPeerType::name = type;
    PeerWriter<RawPeerType> writer(hostile, topic, {true, true, 10});
    ASSERT_TRUE(writer.wait_matched()) << topic;
    for (int i = 0; i < 100; ++i) {
      const std::size_t most = i % 30 == 0 ? 3'000'000 : i % 30 == 10 ? 30'000 : 400;
      // An order has no content: random bytes of its length would be one.
      const std::size_t least = type.find("Trigger") == std::string::npos ? 0 : 12;
      bus::RawBytes bytes(least + random() % most);
      for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random() % 5 == 0 ? 255 : random());
      if (bytes.size() >= header.size()) std::copy(header.begin(), header.end(), bytes.begin());
      writer.write(bytes);
    }
  }
  const std::size_t random_bytes = peak_memory(pid);
  EXPECT_LT(random_bytes, before + kMostGrowth) << "bytes";

  // Joint states with as many empty names as the largest sample has: these take the most memory for their bytes.
  RawPeerType::name = "sensor_msgs::msg::dds_::JointState_";
  PeerWriter<RawPeerType> positions(hostile, "rt/cell/north/goal_joints", {true, true, 10});
  ASSERT_TRUE(positions.wait_matched());
  constexpr std::size_t kNames = 262'000;
  constexpr std::size_t kCountAt = 16;  // encapsulation, stamp, length of the frame's name
  bus::RawBytes names(kCountAt + 4 * (1 + kNames + 3), 0);
  std::copy(header.begin(), header.end(), names.begin());
  for (std::size_t i = 0; i < 4; ++i) names[kCountAt + i] = static_cast<std::uint8_t>(kNames >> (8 * i));
  for (int i = 0; i < 100; ++i) positions.write(names);
  ASSERT_TRUE(positions.wait_acknowledged());

  const Cell cell = connect();
  const auto start = home(cell, "north");
  const auto id = client.send(client.ramp(start, {0.3, 0.1, -0.1, 0.2, 0.0, 0.0}, 1.0));
  ASSERT_TRUE(id) << "the service still answers";
  const auto result = client.await_result(*id);
  ASSERT_TRUE(result);
  EXPECT_EQ(result->status(), kSucceeded) << result->result().error_string();
  EXPECT_LT(peak_memory(pid), before + kMostGrowth) << "bytes";
  std::cout << "memory grew by " << (random_bytes - before) / 1024 << " KiB with random bytes, and by "
            << (peak_memory(pid) - before) / 1024 << " KiB in all\n";
}

}  // namespace
}  // namespace hecaton::test
