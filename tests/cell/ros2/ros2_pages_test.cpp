/// The pages docs/how-to/ros2.md and moveit.md, followed word by word as far as that goes without ROS 2: their cell
/// files start, and the names that they give to MoveIt and to `ros2` are those on the wire.

#include <algorithm>
#include <fstream>
#include <iterator>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <idl/ros2/ros2PubSubTypes.h>
#include <nlohmann/json.hpp>

#include "services/config/cell_file.hpp"
#include "services/config/yaml_tree.hpp"
#include "tests/cell/cli/live_cell.hpp"
#include "tests/cell/ros2/ros_peer.hpp"
#include "tests/support/temporary_folder.hpp"

namespace hecaton::test {
namespace {

using config::YamlNode;

const std::string kRoot = HECATON_SOURCE_DIR;

/// A fenced block of a page, without the indentation of its list.
struct Block {
  std::string language;
  std::string text;
};

std::vector<Block> blocks_of(const std::string& page) {
  std::ifstream file(kRoot + "/docs/how-to/" + page);
  std::vector<Block> blocks;
  std::string line;
  bool inside = false;
  std::size_t indent = 0;
  while (std::getline(file, line)) {
    const std::size_t fence = line.find("```");
    if (fence == std::string::npos) {
      if (inside) blocks.back().text += (line.size() > indent ? line.substr(indent) : "") + "\n";
      continue;
    }
    inside = !inside;
    indent = fence;
    if (inside) blocks.push_back({line.substr(fence + 3), ""});
  }
  return blocks;
}

std::string block(const std::string& page, const std::string& language, std::size_t number) {
  for (const Block& one : blocks_of(page)) {
    if (one.language == language && number-- == 0) return one.text;
  }
  ADD_FAILURE() << page << " has too few blocks of " << language;
  return "";
}

const YamlNode& at(const YamlNode& map, const std::string& key) {
  const auto found = std::find(map.keys.begin(), map.keys.end(), key);
  if (found == map.keys.end()) throw std::runtime_error("no key " + key);
  return map.items[static_cast<std::size_t>(found - map.keys.begin())];
}

std::vector<std::string> texts(const YamlNode& sequence) {
  std::vector<std::string> all;
  for (const YamlNode& item : sequence.items) all.push_back(item.text);
  return all;
}

/// "std_srvs/srv/Trigger" → "std_srvs::srv::dds_::Trigger" + `ending`.
std::string type_on_wire(const std::string& type, const std::string& ending) {
  return std::regex_replace(type, std::regex("^(\\w+)/(\\w+)/(\\w+)$"), "$1::$2::dds_::$3") + ending;
}

/// A type of that name whose samples are bytes.
struct NamedType : bus::RawSupport {
  using type = bus::RawBytes;
  NamedType() : RawSupport(name, 1 << 16) {}
  inline static thread_local std::string name;
};

/// Topics and services to which the commands of a page send.
struct Called {
  std::string topic;  ///< on the wire
  std::string type;   ///< on the wire
};

std::vector<Called> called_by(const std::string& page) {
  std::vector<Called> all;
  const std::regex topic("ros2 topic pub --once (\\S+) (\\S+)");
  const std::regex service("ros2 service call (\\S+) (\\S+)");
  for (const Block& one : blocks_of(page)) {
    for (std::sregex_iterator it(one.text.begin(), one.text.end(), topic), end; it != end; ++it) {
      all.push_back({"rt" + it->str(1), type_on_wire(it->str(2), "_")});
    }
    for (std::sregex_iterator it(one.text.begin(), one.text.end(), service), end; it != end; ++it) {
      all.push_back({"rq" + it->str(1) + "Request", type_on_wire(it->str(2), "_Request_")});
    }
  }
  return all;
}

TEST(Ros2Pages, HaveYamlThatCanBeRead) {
  const std::regex message("\"(\\{[^\"]*\\})\"");
  int yaml = 0;
  int messages = 0;
  for (const std::string page : {"ros2.md", "moveit.md"}) {
    for (const Block& one : blocks_of(page)) {
      if (one.language == "yaml") {
        EXPECT_NO_THROW(static_cast<void>(config::read_yaml_text(one.text, page))) << one.text;
        ++yaml;
      }
      for (std::sregex_iterator it(one.text.begin(), one.text.end(), message), end; it != end; ++it) {
        EXPECT_NO_THROW(static_cast<void>(config::read_yaml_text(it->str(1), page))) << it->str(1);
        ++messages;
      }
    }
  }
  EXPECT_EQ(yaml, 3);
  EXPECT_EQ(messages, 2);
  const std::string arms = "arms: [{name: north, robot: ur5e}]\n";
  const auto cell = config::parse_cell_file("name: page\n" + block("ros2.md", "yaml", 0) + arms, kRoot + "/page.yaml");
  EXPECT_EQ(cell.ros2->distribution, config::Ros2Distribution::kJazzy);
}

/// The topics of displays in deploy/ros2/hecaton.rviz, with the types that their classes take and whether they ask for
/// samples of before.
struct Displayed {
  std::string topic;
  std::string type;
  bool transient_local;
};

std::vector<Displayed> displayed_by_rviz() {
  std::ifstream file(kRoot + "/deploy/ros2/hecaton.rviz");
  const YamlNode manager =
      at(config::read_yaml_text({std::istreambuf_iterator<char>(file), {}}, "hecaton.rviz"), "Visualization Manager");
  EXPECT_EQ(at(at(manager, "Global Options"), "Fixed Frame").text, "world");
  std::vector<Displayed> all;
  for (const YamlNode& display : at(manager, "Displays").items) {
    const std::string kind = at(display, "Class").text;
    const bool robot = kind == "rviz_default_plugins/RobotModel";
    if (!robot && kind != "rviz_default_plugins/MarkerArray") continue;
    const YamlNode& topic = at(display, robot ? "Description Topic" : "Topic");
    EXPECT_EQ(at(topic, "Reliability Policy").text, "Reliable");
    all.push_back({at(topic, "Value").text, robot ? "std_msgs/msg/String" : "visualization_msgs/msg/MarkerArray",
                   at(topic, "Durability Policy").text == "Transient Local"});
  }
  return all;
}

/// The topics of the panels in deploy/ros2/foxglove.json, each of which its layout shows.
std::vector<std::string> displayed_by_foxglove() {
  std::ifstream file(kRoot + "/deploy/ros2/foxglove.json");
  const auto layout = nlohmann::json::parse(file);
  std::vector<std::string> topics;
  const std::string shown = layout.at("layout").dump();
  for (const auto& [panel, settings] : layout.at("configById").items()) {
    EXPECT_NE(shown.find(panel), std::string::npos) << panel;
    if (panel.starts_with("3D!")) {
      EXPECT_EQ(settings.at("fixedFrame"), "world");
      for (const auto& [topic, options] : settings.at("topics").items()) topics.push_back(topic);
    } else if (panel.starts_with("Plot!")) {
      for (const auto& path : settings.at("paths")) {
        const std::string value = path.at("value");
        topics.push_back(value.substr(0, value.find('.')));
      }
    } else {
      topics.push_back(settings.at("topicToRender"));
    }
  }
  return topics;
}

/// The cell of moveit.md, in a free domain of ROS 2 instead of 0.
class MoveItPage : public LiveCell {
 protected:
  void SetUp() override {
    const std::string text = block("moveit.md", "yaml", 0);
    ASSERT_NE(text.find("domain: 0,"), std::string::npos);
    std::ofstream(cell_file()) << "name: page\n"
                               << std::regex_replace(text, std::regex("domain: 0,"),
                                                     "domain: " + std::to_string(ros_domain_.number()) + ",");
    LiveCell::SetUp();
  }
  [[nodiscard]] std::string cell_file() const override { return folder_.path() / "cell.yaml"; }

  TemporaryFolder folder_;
  FreeDomain ros_domain_;
};

template <class Client>
void expect_served(RosPeer& peer, const std::string& service) {
  Client client(peer, service);
  EXPECT_TRUE(client.wait_available()) << service;
}

TEST_F(MoveItPage, NamesControllersAndJointsAsTheServiceDoes) {
  namespace action = control_msgs::action;
  const YamlNode moveit = config::read_yaml_text(block("moveit.md", "yaml", 1), "moveit.md");
  const YamlNode& manager = at(moveit, "moveit_simple_controller_manager");
  const auto controllers = texts(at(manager, "controller_names"));
  ASSERT_EQ(controllers, std::vector<std::string>{"follow_joint_trajectory"});
  const YamlNode& controller = at(manager, controllers[0]);
  EXPECT_EQ(at(controller, "type").text, "FollowJointTrajectory");
  const auto joints = texts(at(controller, "joints"));
  RosPeer peer(ros_domain_.number());
  PeerReader<sensor_msgs::msg::JointStatePubSubType> all(peer, "rt/joint_states");
  std::vector<std::string> prefixed;
  for (const std::string arm : {"north", "south"}) {
    // As MoveIt names its action client, in the namespace of the arm.
    const std::string& action_ns = at(controller, "action_ns").text;
    const std::string base =
        "/" + arm + "/" + controllers[0] + (action_ns.empty() ? "" : "/" + action_ns) + "/_action/";
    expect_served<PeerClient<action::FollowJointTrajectory_SendGoal_RequestPubSubType,
                             action::FollowJointTrajectory_SendGoal_ResponsePubSubType>>(peer, base + "send_goal");
    expect_served<PeerClient<action::FollowJointTrajectory_GetResult_RequestPubSubType,
                             action::FollowJointTrajectory_GetResult_ResponsePubSubType>>(peer, base + "get_result");
    expect_served<
        PeerClient<action_msgs::srv::CancelGoal_RequestPubSubType, action_msgs::srv::CancelGoal_ResponsePubSubType>>(
        peer, base + "cancel_goal");
    PeerReader<sensor_msgs::msg::JointStatePubSubType> states(peer, "rt/" + arm + "/joint_states");
    const auto state = states.next([](const auto& message) { return !message.name().empty(); });
    ASSERT_TRUE(state) << arm;
    EXPECT_EQ(state->name(), joints) << arm;
    for (const std::string& joint : joints) prefixed.push_back(arm + "_" + joint);
  }
  const auto both = all.next([&](const auto& message) { return message.name().size() == prefixed.size(); });
  ASSERT_TRUE(both);
  EXPECT_EQ(both->name(), prefixed);

  // RViz and Foxglove find each topic that their configurations show.
  const std::vector<Displayed> rviz = displayed_by_rviz();
  EXPECT_EQ(rviz.size(), 5U);
  std::vector<std::string> published{"/joint_states", "/diagnostics"};
  for (const Displayed& one : rviz) {
    published.push_back(one.topic);
    NamedType::name = type_on_wire(one.type, "_");
    PeerReader<NamedType> reader(peer, "rt" + one.topic, {true, one.transient_local, 10});
    EXPECT_TRUE(reader.next()) << one.topic;
  }
  for (const std::string& topic : displayed_by_foxglove()) {
    EXPECT_NE(std::find(published.begin(), published.end(), topic), published.end()) << topic;
  }

  // The commands of both pages reach the service.
  std::vector<Called> called = called_by("moveit.md");
  const auto more = called_by("ros2.md");
  called.insert(called.end(), more.begin(), more.end());
  EXPECT_EQ(called.size(), 4U);
  for (const Called& one : called) {
    NamedType::name = one.type;
    PeerWriter<NamedType> writer(peer, one.topic);
    EXPECT_TRUE(writer.wait_matched()) << one.topic << " of " << one.type;
  }
}

}  // namespace
}  // namespace hecaton::test
