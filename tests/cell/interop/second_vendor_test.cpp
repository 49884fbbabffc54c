/// A cell beside a program of another DDS vendor: tests/cell/interop/cyclone_peer.cpp. A third decoder, of npm, reads
/// the bytes of each message that the program has decoded. Both know messages of ROS 2 by the texts of ROS 2. What they
/// have read must be what Hecaton has sent: tests/cell/interop/ros2_values.cpp.

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <hecaton/client.hpp>
#include <nlohmann/json.hpp>

#include "tests/cell/cli/process.hpp"
#include "tests/support/free_domain.hpp"
#include "tests/support/needed_files.hpp"
#include "tests/support/temporary_folder.hpp"

namespace hecaton::test {
namespace {

using Json = nlohmann::json;

const std::string kBin = std::string(HECATON_BIN_DIR) + "/";
const std::string kIdl = std::string(HECATON_SOURCE_DIR) + "/idl/";
const std::vector<double> kReady{-0.3, -1.25, 3.5, 0.0, 0.89, 0.0};  // in three_puma.yaml

/// One cell for all tests.
class SecondVendor : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    const TemporaryFolder& folder = *(folder_ = std::make_unique<TemporaryFolder>());
    std::filesystem::create_directory_symlink(std::string(HECATON_LIVE_CELLS) + "/urdf", folder.path() / "urdf");
    std::ifstream plain(std::string(HECATON_LIVE_CELLS) + "/three_puma.yaml");
    const std::string text{std::istreambuf_iterator<char>(plain), {}};
    domain_ = std::make_unique<FreeDomain>();
    ros_domain_ = std::make_unique<FreeDomain>();
    const std::string cell =
        folder.write("cell.yaml", text + "\nros2: {domain: " + std::to_string(ros_domain_->number()) +
                                      ", namespace: /cell, period: 10ms, distribution: jazzy}\n");
    up_ = std::make_unique<Process>(std::vector<std::string>{kBin + "hecaton", "up", cell, "--headless", "--domain",
                                                             std::to_string(domain_->number()), "--start-timeout",
                                                             "100s"});
    ASSERT_TRUE(up_->wait_for_message("the cell is up")) << up_->err();
  }
  static void TearDownTestSuite() {
    if (up_) {
      up_->signal(SIGINT);
      EXPECT_EQ(up_->wait(), 0) << up_->err();
    }
    up_.reset();
    ros_domain_.reset();
    domain_.reset();
    folder_.reset();
  }

  [[nodiscard]] static Cell connect() {
    ConnectOptions options;
    options.domain = domain_->number();
    return Cell::connect(options, kPatience);
  }
  /// HECATON_MESSAGES=10000 for the long run.
  [[nodiscard]] static std::string wanted(const char* usual) {
    const char* given = std::getenv("HECATON_MESSAGES");
    return given == nullptr ? usual : given;
  }
  /// Lets the other vendor's program watch topics in a domain. Returns how a third decoder judges what it has read, and
  /// whether it is what Hecaton has sent.
  static void watch(int domain, const std::string& partition, const std::vector<std::string>& topics, Json& judged) {
    const std::string page = kBin + "../services/view/page";
    const std::string node = HECATON_NODE;
    HECATON_NEED_FILES({page + "/node_modules/@foxglove/omgidl-parser", node});
    const std::string samples = folder_->path("samples.jsonl");
    std::vector<std::string> words{kBin + "cyclone_peer", "watch", std::to_string(domain), partition, samples};
    words.insert(words.end(), topics.begin(), topics.end());
    Process peer(words);
    ASSERT_EQ(peer.wait(), 0) << peer.err();
    const std::string with_own = folder_->path("samples_with_own.jsonl");
    Process own({kBin + "ros2_values", samples, with_own});
    ASSERT_EQ(own.wait(), 0) << own.err();
    Process other({node, page + "/test/decode.mjs", with_own, HECATON_ROS2_TEXTS, kIdl + "common.idl",
                   kIdl + "cause.idl", kIdl + "arm.idl", kIdl + "goal.idl"});
    ASSERT_EQ(other.wait(), 0) << other.err();
    judged = Json::parse(other.out());
    judged["told"] = peer.err();
  }

  /// Expects of each topic but the announcements of nodes that all messages were compared with what Hecaton has sent.
  static void expect_own_values(const Json& judged) {
    for (const auto& [topic, count] : judged.at("messages").items()) {
      if (topic.starts_with("ros_discovery_info")) continue;
      EXPECT_EQ(judged.at("own").value(topic, 0), count) << topic;
    }
  }
  /// Expects that each part of the announcements in the last watch() is what its name says, as Cyclone DDS has decoded
  /// them. The namespace begins with a slash. Identifiers have the kind that RTPS gives to them (2.2, section 9.3.1.2).
  /// Returns the nodes of the last announcement.
  static Json announced_nodes() {
    constexpr int kParticipant = 0xC1;
    constexpr int kReaderBit = 0x04;
    const auto kind = [](const Json& gid) { return gid.at("data").at(15).get<int>(); };
    std::ifstream samples(folder_->path("samples.jsonl"));
    Json nodes;
    for (std::string line; std::getline(samples, line);) {
      const Json sample = Json::parse(line);
      if (!sample.at("topic").get<std::string>().starts_with("ros_discovery_info")) continue;
      EXPECT_EQ(kind(sample.at("value").at("gid")), kParticipant);
      nodes = sample.at("value").at("node_entities_info_seq");
      EXPECT_EQ(nodes.size(), 1U);
      for (const Json& node : nodes) {
        EXPECT_TRUE(node.at("node_namespace").get<std::string>().starts_with("/"));
        EXPECT_FALSE(node.at("node_name").get<std::string>().starts_with("/"));
        for (const Json& gid : node.at("reader_gid_seq")) EXPECT_NE(kind(gid) & kReaderBit, 0);
        for (const Json& gid : node.at("writer_gid_seq")) EXPECT_EQ(kind(gid) & kReaderBit, 0);
      }
    }
    if (nodes.empty()) throw std::runtime_error("no announcement of nodes was read");
    return nodes;
  }

  inline static std::unique_ptr<TemporaryFolder> folder_;
  inline static std::unique_ptr<FreeDomain> domain_;
  inline static std::unique_ptr<FreeDomain> ros_domain_;
  inline static std::unique_ptr<Process> up_;
};

TEST_F(SecondVendor, SendsAGoalAndSeesItReached) {
  std::vector<std::string> words{kBin + "cyclone_peer", "goal", std::to_string(domain_->number()), "three_puma",
                                 "north"};
  for (const double q : kReady) words.push_back(std::to_string(q));
  Process peer(words);
  ASSERT_EQ(peer.wait(), 0) << peer.err();
  const Json seen = Json::parse(peer.out());
  ASSERT_EQ(seen.at("q").size(), kReady.size());
  const Cell cell = connect();
  const auto measured = cell.arm("north").state(kPatience).q;
  for (std::size_t j = 0; j < kReady.size(); ++j) {
    EXPECT_NEAR(seen.at("q")[j], kReady[j], 0.01) << j;
    EXPECT_NEAR(measured[j], kReady[j], 0.01) << j;
  }
}

TEST_F(SecondVendor, ReadsTheTopicsOfACell) {
  const Cell cell = connect();
  for (const char* arm : {"north", "west", "east"}) static_cast<void>(cell.arm(arm).go_to("ready"));
  Json judged;
  watch(domain_->number(), "three_puma",
        {"hecaton/ArmState,hecaton::msg::ArmState,best_effort,5000",
         "hecaton/GoalStatus,hecaton::msg::GoalStatus,latched,3"},
        judged);
  if (judged.is_null()) return;
  EXPECT_GE(judged.at("messages").at("hecaton/ArmState"), 5000);
  EXPECT_EQ(judged.at("differences"), 0) << judged.at("first");
}

TEST_F(SecondVendor, ReadsTheTopicsOfRos2) {
  const Cell cell = connect();
  std::vector<Goal> goals;
  for (const char* arm : {"north", "west", "east"}) goals.push_back(cell.arm(arm).go_to("home"));
  Json judged;
  const std::string count = wanted("1000");  // of the fast topics
  watch(ros_domain_->number(), "",
        {"rt/cell/joint_states,sensor_msgs::msg::JointState,reliable," + count,
         "rt/cell/north/joint_states,sensor_msgs::msg::JointState,reliable," + count,
         "rt/tf,tf2_msgs::msg::TFMessage,reliable," + count, "rt/tf_static,tf2_msgs::msg::TFMessage,latched,1",
         "rt/cell/robot_description,std_msgs::msg::String,latched,1",
         "rt/cell/north/robot_description,std_msgs::msg::String,latched,1",
         "rt/diagnostics,diagnostic_msgs::msg::DiagnosticArray,reliable,5",
         "rt/cell/north/status,diagnostic_msgs::msg::DiagnosticStatus,reliable,10",
         "rt/clock,rosgraph_msgs::msg::Clock,best_effort,500",
         "ros_discovery_info,rmw_dds_common::msg::ParticipantEntitiesInfo,latched,1",
         "rt/cell/hecaton/obstacles,visualization_msgs::msg::MarkerArray,reliable,50",
         "rt/cell/hecaton/goals,visualization_msgs::msg::MarkerArray,reliable,50",
         "rt/cell/hecaton/plans,visualization_msgs::msg::MarkerArray,reliable,50",
         "rt/cell/hecaton/binding_pairs,visualization_msgs::msg::MarkerArray,reliable,50"},
        judged);
  if (judged.is_null()) return;
  EXPECT_EQ(judged.at("messages").size(), 14U);
  EXPECT_GE(judged.at("messages").at("rt/cell/joint_states"), std::stoi(count));
  std::cout << judged.at("messages").dump() << '\n';
  EXPECT_EQ(judged.at("differences"), 0) << judged.at("first");
  expect_own_values(judged);
  const Json node = announced_nodes().at(0);
  EXPECT_EQ(node.at("node_name"), "hecaton");
  EXPECT_EQ(node.at("node_namespace"), "/cell");
  EXPECT_GE(node.at("writer_gid_seq").size(), 13U) << "of each topic above";
  // The hashes that ROS 2 itself has, since Iron.
  const std::string told = judged.at("told");
  for (const std::string hash :
       {"joint_states: user data typehash=RIHS01_a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e;",
        "tf: user data typehash=RIHS01_e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087;",
        "robot_description: user data "
        "typehash=RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18;",
        "obstacles: user data typehash=RIHS01_86cb8800b6fb05b5eff1abd7a56f62a5641d3ae9a1c29e78e67e704f1d067dcf;",
        "diagnostics: user data typehash=RIHS01_5a8a36efb05fb25070fa0fb3810290c0e6cd4862b54a8fb975a1ee8dc55a333e;"}) {
    EXPECT_NE(told.find(hash), std::string::npos) << hash << '\n' << told;
  }
}

// The service's own publishers, with random states instead of a cell: as many messages of the slow topics and of those
// that a cell publishes once or on request.
TEST_F(SecondVendor, ReadsRandomMessagesOfEachTopicOfRos2) {
  const FreeDomain domain;
  const std::string cell = folder_->write(
      "random.yaml",
      "name: random\nros2: {domain: " + std::to_string(domain.number()) +
          ", namespace: /cell}\narms:\n  - {name: north, urdf: urdf/planar_2r.urdf, poses: {home: [0, 1]}}\n"
          "  - {name: south, urdf: urdf/planar_3r.urdf, base: {xyz: [9, 0, 0]}, poses: {home: [0, 1, 0]}}\n");
  Process burst({kBin + "ros2_burst", cell});
  const std::string count = wanted("300");
  std::vector<std::string> topics;
  const auto add = [&](const std::string& topic, const std::string& type, const std::string& delivery = "reliable") {
    topics.push_back(topic + "," + type + "," + delivery + "," + count);
  };
  const auto add_ros = [&](const std::string& topic, const std::string& type,
                           const std::string& delivery = "reliable") { add("rt/" + topic, type, delivery); };
  add_ros("cell/joint_states", "sensor_msgs::msg::JointState");
  add_ros("tf", "tf2_msgs::msg::TFMessage");
  add_ros("tf_static", "tf2_msgs::msg::TFMessage", "latched");
  add_ros("clock", "rosgraph_msgs::msg::Clock", "best_effort");
  add_ros("diagnostics", "diagnostic_msgs::msg::DiagnosticArray");
  add_ros("cell/robot_description", "std_msgs::msg::String", "latched");
  for (const std::string arm : {"north", "south"}) {
    add_ros("cell/" + arm + "/joint_states", "sensor_msgs::msg::JointState");
    add_ros("cell/" + arm + "/status", "diagnostic_msgs::msg::DiagnosticStatus");
    add_ros("cell/" + arm + "/robot_description", "std_msgs::msg::String", "latched");
  }
  for (const std::string name : {"obstacles", "goals", "plans", "binding_pairs"}) {
    add_ros("cell/hecaton/" + name, "visualization_msgs::msg::MarkerArray");
  }
  const std::string action = "cell/north/follow_joint_trajectory/_action/";
  const std::string type = "control_msgs::action::FollowJointTrajectory_";
  add_ros(action + "feedback", type + "FeedbackMessage");
  add_ros(action + "status", "action_msgs::msg::GoalStatusArray", "latched");
  add("rr/" + action + "send_goalReply", type + "SendGoal_Response");
  add("rr/" + action + "get_resultReply", type + "GetResult_Response");
  add("rr/" + action + "cancel_goalReply", "action_msgs::srv::CancelGoal_Response");
  add("rr/cell/north/stopReply", "std_srvs::srv::Trigger_Response");
  add_ros("random/joint_states", "sensor_msgs::msg::JointState");
  add_ros("random/transforms", "tf2_msgs::msg::TFMessage");
  add_ros("random/diagnostics", "diagnostic_msgs::msg::DiagnosticArray");
  add_ros("random/markers", "visualization_msgs::msg::MarkerArray");
  add("ros_discovery_info", "rmw_dds_common::msg::ParticipantEntitiesInfo", "latched");
  add("ros_discovery_info_humble", "rmw_dds_common::humble::ParticipantEntitiesInfo", "latched");
  Json judged;
  watch(domain.number(), "", topics, judged);
  burst.signal(SIGTERM);
  EXPECT_EQ(burst.wait(), 128 + SIGTERM) << burst.err();
  if (judged.is_null()) return;
  EXPECT_EQ(judged.at("messages").size(), topics.size());
  for (const auto& [topic, seen] : judged.at("messages").items()) EXPECT_GE(seen, std::stoi(count)) << topic;
  std::cout << judged.at("messages").dump() << '\n';
  EXPECT_EQ(judged.at("differences"), 0) << judged.at("first");
  expect_own_values(judged);
  static_cast<void>(announced_nodes());
}

}  // namespace
}  // namespace hecaton::test
