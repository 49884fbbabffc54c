/// Samples that do not have the layout of their type, and many of the largest size, at every topic and service of
/// hecaton-ros2.

#include <filesystem>
#include <functional>
#include <map>
#include <random>
#include <set>
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

/// The name by which the log tells of a topic or service, of those of an action together; empty: it tells of none.
std::string name_in_log(const std::string& topic) {
  if (topic == "rt/cell/robot_description" || topic == "ros_discovery_info") return "";
  const std::string name = topic.substr(2);  // without the prefix "rt" or "rq"
  const std::string action = "/_action/";
  if (const auto at = name.find(action); at != std::string::npos) return name.substr(0, at + action.size());
  return topic.starts_with("rq") ? name.substr(0, name.rfind("Request")) : name;
}

/// Waits until the log tells of ignored messages of each name, from that position of the file on. Calls `again` each
/// second with those of which it has not told: it does so at most once a minute. Returns those of which it never told.
std::set<std::string> await_ignored(const std::string& log, std::uintmax_t from, std::set<std::string> untold,
                                    const std::function<void(const std::set<std::string>&)>& again) {
  constexpr auto kLimit = 2 * kLong;
  const auto begin = std::chrono::steady_clock::now();
  for (auto next = begin + 1s; !untold.empty() && std::chrono::steady_clock::now() < begin + kLimit;) {
    std::ifstream file(log);
    file.seekg(static_cast<std::streamoff>(from));
    for (std::string line; std::getline(file, line);) {
      if (line.find("messages ignored") == std::string::npos) continue;
      std::erase_if(untold, [&](const std::string& name) { return line.find(name) != std::string::npos; });
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(20));  // a file announces no change
    if (std::chrono::steady_clock::now() < next) continue;
    again(untold);
    next += 1s;
  }
  return untold;
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

  std::set<std::string> served;
  for (const auto& [topic, type] : requests()) served.insert(name_in_log(topic));
  const auto untold = await_ignored(folder_->path("ros2.log"), 0, served, [](const auto&) {});
  EXPECT_TRUE(untold.empty()) << *untold.begin();
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
  const std::string log = folder_->path("ros2.log");
  const auto logged_before = std::filesystem::file_size(log);
  RosPeer hostile(ros_domain_->number(), 101);
  std::mt19937 random(7);
  const std::array<std::uint8_t, 4> header{0, 1, 0, 0};
  const auto draw = [&](std::size_t least, std::size_t below) {
    bus::RawBytes bytes(least + random() % below);
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random() % 5 == 0 ? 255 : random());
    if (bytes.size() >= header.size()) std::copy(header.begin(), header.end(), bytes.begin());
    return bytes;
  };
  // An order has no content: random bytes of its length would be one.
  const auto shortest = [](const std::string& type) { return type.find("Trigger") == std::string::npos ? 0U : 12U; };
  constexpr int kDepth = 10;
  std::map<std::string, std::unique_ptr<PeerWriter<RawPeerType>>> writers;
  std::set<std::string> told;
  for (const auto& [topic, type] : topics) {
    RawPeerType::name = type;
    auto& writer =
        *(writers[topic] = std::make_unique<PeerWriter<RawPeerType>>(hostile, topic, PeerPolicies{true, true, kDepth}));
    ASSERT_TRUE(writer.wait_matched()) << topic;
    constexpr int kSamples = 100;
    for (int i = 0; i < kSamples; ++i) {
      // The last samples, which the writer keeps, are small: every reader takes these.
      const bool is_kept = i >= kSamples - kDepth;
      const std::size_t below = is_kept ? 400 : i % 30 == 0 ? 3'000'000 : i % 30 == 10 ? 30'000 : 400;
      writer.write(draw(shortest(type), below));
    }
    ASSERT_TRUE(writer.wait_acknowledged()) << topic;
    if (const std::string name = name_in_log(topic); !name.empty()) told.insert(name);
  }
  const auto untold = await_ignored(log, logged_before, told, [&](const std::set<std::string>& names) {
    for (const auto& [topic, writer] : writers) {
      if (names.contains(name_in_log(topic))) writer->write(draw(shortest(topics.at(topic)), 400));
    }
  });
  EXPECT_TRUE(untold.empty()) << "the service has ignored no message of " << *untold.begin();
  writers.clear();
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
