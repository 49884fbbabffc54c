/// A cell for clients of the Foxglove WebSocket protocol, and their connections to the web server.

#include <map>
#include <random>

#include <gtest/gtest.h>

#include "services/ros2_messages/cdr.hpp"
#include "services/view/foxglove/cell_server.hpp"
#include "services/view/web_server.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/unit/services/view/foxglove_frames.hpp"
#include "tests/unit/services/view/web_client.hpp"

namespace hecaton::services::foxglove {
namespace {

using namespace std::chrono_literals;

// --- a cell

const std::string kCells = std::string(HECATON_SOURCE_DIR) + "/deploy/cells/";

/// A feed that holds what a test gives it.
class TestFeed : public CellFeed {
 public:
  explicit TestFeed(const config::CellFile& file) : cell(file, bus::Clock::now()) {}
  [[nodiscard]] const CellState& state() const override { return cell; }
  [[nodiscard]] bus::Clock::time_point now() const override { return bus::Clock::now(); }
  [[nodiscard]] std::chrono::milliseconds unix_time() const override { return 0ms; }
  [[nodiscard]] double rate() const override { return 1.0; }
  [[nodiscard]] std::uint64_t leaps() const override { return 0; }

  void set_state(const std::string& arm, double q) {
    bus::Sample<msg::ArmState> sample;
    sample.key = arm;
    sample.received = bus::Clock::now();
    sample.value.arm(arm);
    sample.value.q(std::vector<double>(6, q));
    sample.value.qd(std::vector<double>(6, 0.5));
    cell.apply(sample);
  }
  CellState cell;
};

class FoxgloveCell : public testing::Test {
 protected:
  void SetUp() override {
    client_ = server_.protocol().open({[] {}});
    static_cast<void>(client_->next());
    const Json greeting = Json::parse(bytes_of(*client_->next()));
    for (const Json& channel : greeting.at("channels")) {
      ids_[channel.at("topic")] = channel.at("id");
    }
  }
  void subscribe(const std::string& topic) {
    ASSERT_TRUE(ids_.contains(topic)) << topic;
    const Json one{{"id", ids_[topic]}, {"channelId", ids_[topic]}};
    client_->received(Json{{"op", "subscribe"}, {"subscriptions", {one}}}.dump(), true);
  }
  /// The newest message of a topic; what comes first of other topics is dropped.
  template <class Message>
  Message read(const std::string& topic) {
    while (auto frame = client_->next()) {
      if (frame->head.substr(0, 5) != message_data(ids_[topic], 0).substr(0, 5)) continue;
      const auto* data = reinterpret_cast<const std::uint8_t*>(frame->body->data());
      auto message = ros2::decoded<Message>({data, frame->body->size()});
      EXPECT_TRUE(message);
      return message ? *message : Message{};
    }
    ADD_FAILURE() << "no message of " << topic;
    return {};
  }

  config::CellFile file_ = config::load_cell_file(kCells + "three_puma.yaml");
  TestFeed feed_{file_};
  view::Drawings drawings_{file_};
  CellServer server_{feed_, file_, drawings_};
  std::unique_ptr<WebSession> client_;
  std::map<std::string, std::uint32_t> ids_;
};

TEST_F(FoxgloveCell, HasTheTopicsOfTheLayout) {
  for (const char* topic :
       {"/robot_description", "/joint_states", "/tf", "/tf_static", "/diagnostics", "/hecaton/obstacles",
        "/hecaton/goals", "/hecaton/plans", "/hecaton/binding_pairs", "/north/status"}) {
    EXPECT_TRUE(ids_.contains(topic)) << topic;
  }
}

TEST_F(FoxgloveCell, SendsJointStatesOfArmsThatAreKnown) {
  subscribe("/joint_states");
  server_.publish(bus::Clock::now());
  while (const auto frame = client_->next()) EXPECT_EQ(frame->head[0], '\2') << "no state is known: only the time";
  feed_.set_state("north", 0.25);
  server_.publish(bus::Clock::now() + 1s);
  const auto states = read<ros2::JointState>("/joint_states");
  ASSERT_EQ(states.name.size(), 6U);
  EXPECT_EQ(states.name[0].substr(0, 6), "north_");
  EXPECT_EQ(states.position, std::vector<double>(6, 0.25));
  EXPECT_EQ(states.velocity, std::vector<double>(6, 0.5));
}

TEST_F(FoxgloveCell, DescribesTheRobotToLateClients) {
  subscribe("/robot_description");
  EXPECT_NE(read<ros2::String>("/robot_description").data.find("<robot name=\"three_puma\">"), std::string::npos);
  subscribe("/tf_static");
  EXPECT_GE(read<ros2::TFMessage>("/tf_static").transforms.size(), 6U);
}

TEST_F(FoxgloveCell, SendsWholeMarkersSoThatMessagesMayBeMissed) {
  bus::Sample<msg::ObstacleShapes> shapes;
  shapes.key = "crate";
  shapes.value.name("crate");
  shapes.value.obstacle().name("crate");
  shapes.value.obstacle().shapes().resize(1);
  shapes.value.obstacle().shapes()[0].kind(msg::ShapeKind::SHAPE_SPHERE);
  shapes.value.obstacle().shapes()[0].dimensions().x(0.1);
  shapes.value.obstacle().shapes()[0].X_OS().qw(1.0);
  shapes.value.obstacle().X_WO().qw(1.0);
  feed_.cell.apply(shapes);
  bus::Sample<msg::ObstacleStates> states;
  states.value.states().resize(1);
  states.value.states()[0].name("crate");
  states.value.states()[0].X_WO().qw(1.0);
  feed_.cell.apply(states);
  subscribe("/hecaton/obstacles");
  auto now = bus::Clock::now();
  for (int i = 0; i < 2; ++i) {
    server_.publish(now += 1s);
    const auto message = read<ros2::MarkerArray>("/hecaton/obstacles");
    ASSERT_EQ(message.markers.size(), 2U);
    EXPECT_EQ(message.markers[0].action, ros2::marker::kDeleteAll);
    EXPECT_EQ(message.markers[1].ns, "crate");
  }
  states.value.states().clear();
  feed_.cell.apply(states);
  server_.publish(now += 1s);
  EXPECT_EQ(read<ros2::MarkerArray>("/hecaton/obstacles").markers.size(), 1U);
}

TEST_F(FoxgloveCell, ReportsNodesAndASilentSupervisor) {
  subscribe("/diagnostics");
  server_.publish(bus::Clock::now());
  const auto silent = read<ros2::DiagnosticArray>("/diagnostics");
  ASSERT_EQ(silent.status.size(), 1U);
  EXPECT_EQ(silent.status[0].level, ros2::level::kStale);
  bus::Sample<msg::CellMode> mode;
  mode.received = bus::Clock::now();
  mode.value.term(1);
  mode.value.sequence_number(1);
  mode.value.node("supervisor");
  mode.value.mode(msg::Mode::MODE_RUN);
  feed_.cell.apply(mode);
  bus::Sample<msg::Heartbeat> heartbeat;
  heartbeat.key = "world";
  heartbeat.received = bus::Clock::now();
  heartbeat.value.node("world");
  heartbeat.value.host("left");
  heartbeat.value.state(msg::NodeState::NODE_RUNNING);
  feed_.cell.apply(heartbeat);
  server_.publish(bus::Clock::now() + 2s);
  const auto message = read<ros2::DiagnosticArray>("/diagnostics");
  ASSERT_EQ(message.status.size(), 2U);
  EXPECT_EQ(message.status[0].message, "running");
  EXPECT_EQ(message.status[1].name, "hecaton: world");
  EXPECT_EQ(message.status[1].hardware_id, "left");
}

TEST(FoxgloveAssets, AreTheMeshesThatTheUrdfsName) {
  const test::TemporaryFolder folder;
  const std::string triangle =
      "solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid "
      "s\n";
  folder.write("arms/meshes/tip.stl", triangle);
  folder.write("arms/meshes/secret.txt", "secret");
  const std::string urdf = folder.write(
      "arms/urdf/r.urdf",
      R"(<robot name="r"><link name="base"/><link name="tip"><visual><geometry><mesh filename="package://arms/meshes/tip.stl"/>
         </geometry></visual><collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision></link>
         <joint name="j" type="revolute"><parent link="base"/><child link="tip"/><axis xyz="0 0 1"/>
         <limit lower="-1" upper="1" velocity="1" effort="1"/></joint></robot>)");
  const auto file = config::parse_cell_file(
      "name: one\narms:\n  - {name: arm1, urdf: " + urdf + ", allow_bare_links: true}\n", folder.path("cell.yaml"));
  const TestFeed feed(file);
  const view::Drawings drawings(file);
  const CellServer server(feed, file, drawings);
  const auto client = server.protocol().open({[] {}});
  static_cast<void>(client->next());
  const Json channels = Json::parse(bytes_of(*client->next())).at("channels");
  const auto fetch = [&](const std::string& uri) {
    client->received(Json{{"op", "fetchAsset"}, {"uri", uri}, {"requestId", 1}}.dump(), true);
    const std::string answer = bytes_of(*client->next());
    return answer.substr(0, 10) == asset(1) ? answer.substr(10) : "refused";
  };
  // The URI in the description is one of them.
  for (const Json& channel : channels) {
    if (channel.at("topic") != "/arm1/robot_description") continue;
    const Json one{{"id", 1}, {"channelId", channel.at("id")}};
    client->received(Json{{"op", "subscribe"}, {"subscriptions", {one}}}.dump(), true);
    EXPECT_NE(bytes_of(*client->next()).find("\"package://hecaton/meshes/0/tip.stl\""), std::string::npos);
  }
  EXPECT_EQ(fetch("package://hecaton/meshes/0/tip.stl"), triangle);
  EXPECT_EQ(fetch("package://arms/meshes/tip.stl"), triangle) << "as the cell's URDF names it";
  for (const std::string& uri :
       {"package://arms/meshes/secret.txt"s, "package://hecaton/meshes/0/secret.txt"s,
        "package://hecaton/meshes/0/../../urdf/r.urdf"s, "package://arms/meshes/../meshes/tip.stl"s, "file://" + urdf,
        urdf, folder.path("arms/meshes/tip.stl"), "package://hecaton/"s, "package://hecaton"s, ""s,
        "package://hecaton/meshes/0/"s}) {
    EXPECT_EQ(fetch(uri), "refused") << uri;
  }
}

TEST(FoxgloveOrigins, AreThoseOfKnownPrograms) {
  const std::vector<std::string> further{"http://vis.example:8080"};
  for (const char* origin : {"https://app.foxglove.dev", "file://", "http://localhost", "http://localhost:8080",
                             "https://localhost:8443", "http://127.0.0.1:3000", "http://vis.example:8080"}) {
    EXPECT_TRUE(is_allowed_origin(origin, further)) << origin;
  }
  for (const char* origin :
       {"", "null", "http://app.foxglove.dev", "https://app.foxglove.dev.evil.example",
        "https://evil.example/app.foxglove.dev", "http://localhost.evil.example",
        "http://localhost:", "http://localhost:80a", "http://localhost@evil.example", "http://vis.example",
        "http://evil.example", "http://127.0.0.1.evil.example", "chrome-extension://localhost"}) {
    EXPECT_FALSE(is_allowed_origin(origin, further)) << origin;
  }
}

// --- the web server

namespace asio = boost::asio;
namespace beast = boost::beast;

class SocketClient {
 public:
  /// Throws boost::system::system_error when the server refuses it.
  SocketClient(std::uint16_t port, const std::string& protocols, const std::string& origin = "",
               const std::string& target = "/") {
    stream_.next_layer().connect(test::local(port));
    stream_.set_option(beast::websocket::stream_base::decorator([&](beast::websocket::request_type& request) {
      if (!protocols.empty()) request.set(beast::http::field::sec_websocket_protocol, protocols);
      if (!origin.empty()) request.set(beast::http::field::origin, origin);
    }));
    beast::websocket::response_type response;
    stream_.handshake(response, "localhost", target);
    protocol = std::string(response[beast::http::field::sec_websocket_protocol]);
  }
  std::string read() {
    beast::flat_buffer buffer;
    stream_.read(buffer);
    return beast::buffers_to_string(buffer.data());
  }
  void write(std::string_view bytes, bool text) {
    stream_.text(text);
    stream_.write(asio::buffer(bytes.data(), bytes.size()));
  }
  /// Bytes below the WebSocket, past its framing.
  void write_raw(std::string_view bytes) {
    asio::write(stream_.next_layer(), asio::buffer(bytes.data(), bytes.size()));
  }
  /// Reads until the server closes the connection.
  beast::websocket::close_reason wait_for_close() {
    try {
      while (true) static_cast<void>(read());
    } catch (const boost::system::system_error&) {
      return stream_.reason();
    }
  }

  std::string protocol;

 private:
  asio::io_context context_;
  beast::websocket::stream<asio::ip::tcp::socket> stream_{context_};
};

class FoxgloveSocket : public testing::Test {
 protected:
  static WebServerOptions options(const std::shared_ptr<Hub>& hub) {
    WebServerOptions options;
    options.protocol.names.assign(std::begin(kSubprotocols), std::end(kSubprotocols));
    options.protocol.longest_message = kLongestMessage;
    options.protocol.allows = [](std::string_view origin) { return is_allowed_origin(origin, {}); };
    options.protocol.open = [hub](WebOpening opening) { return hub->open(std::move(opening)); };
    return options;
  }
  [[nodiscard]] bool accepts(const std::string& protocols, const std::string& origin = "",
                             const std::string& target = "/") {
    try {
      const SocketClient client(server_.port(), protocols, origin, target);
      return true;
    } catch (const boost::system::system_error&) {
      return false;
    }
  }

  std::shared_ptr<Hub> hub_ = std::make_shared<Hub>(two_channels(true));
  WebServer server_{options(hub_)};
};

TEST_F(FoxgloveSocket, SpeaksTheSubprotocolThatTheClientOffers) {
  EXPECT_EQ(SocketClient(server_.port(), "foxglove.sdk.v1").protocol, "foxglove.sdk.v1");
  EXPECT_EQ(SocketClient(server_.port(), "foxglove.websocket.v1").protocol, "foxglove.websocket.v1");
  EXPECT_EQ(SocketClient(server_.port(), "other, foxglove.websocket.v1, foxglove.sdk.v1").protocol, "foxglove.sdk.v1");
  EXPECT_FALSE(accepts(""));
  EXPECT_FALSE(accepts("foxglove.websocket.v2"));
  EXPECT_FALSE(accepts("foxglove.sdk.v1", "", "/other"));
}

TEST_F(FoxgloveSocket, RefusesPagesOfOtherSites) {
  EXPECT_TRUE(accepts("foxglove.sdk.v1", "https://app.foxglove.dev"));
  EXPECT_TRUE(accepts("foxglove.sdk.v1", "http://localhost:8080"));
  EXPECT_FALSE(accepts("foxglove.sdk.v1", "http://evil.example"));
  EXPECT_FALSE(accepts("", "https://app.foxglove.dev", "/live")) << "the stream of the page stays with the page";
}

TEST_F(FoxgloveSocket, SendsWhatIsPublished) {
  SocketClient client(server_.port(), "foxglove.sdk.v1");
  EXPECT_EQ(Json::parse(client.read()).at("op"), "serverInfo");
  EXPECT_EQ(Json::parse(client.read()).at("op"), "advertise");
  hub_->publish(0, 3, "latched");
  client.write(R"({"op": "subscribe", "subscriptions": [{"id": 5, "channelId": 1}]})", true);
  EXPECT_EQ(client.read(), message_data(5, 3) + "latched");
  hub_->publish(0, 4, std::string(300'000, 'x'));
  EXPECT_EQ(client.read().size(), 300'013U);
}

TEST_F(FoxgloveSocket, SkipsMessagesForAClientThatReadsSlowly) {
  SocketClient slow(server_.port(), "foxglove.sdk.v1");
  slow.write(R"({"op": "subscribe", "subscriptions": [{"id": 5, "channelId": 1}]})", true);
  SocketClient quick(server_.port(), "foxglove.sdk.v1");
  quick.write(R"({"op": "subscribe", "subscriptions": [{"id": 5, "channelId": 1}]})", true);
  for (SocketClient* client : {&slow, &quick}) {
    for (int i = 0; i < 2; ++i) static_cast<void>(client->read());
  }
  hub_->publish(0, 0, "begin");
  EXPECT_EQ(slow.read().substr(13), "begin");
  EXPECT_EQ(quick.read().substr(13), "begin");
  constexpr int kMessages = 400;
  const std::string padding(100'000, '.');
  for (int i = 1; i <= kMessages; ++i) {
    hub_->publish(0, 0, std::to_string(i) + padding);
    ASSERT_EQ(std::stoi(quick.read().substr(13)), i);
  }
  EXPECT_GT(hub_->skipped(), 0U);
  int received = 0;
  for (int last = 0; last != kMessages; ++received) {
    const int number = std::stoi(slow.read().substr(13));
    ASSERT_GT(number, last) << "messages arrive in order";
    last = number;
  }
  EXPECT_LT(received, kMessages / 2) << "40 MB do not fit into the buffers of a socket";
}

TEST_F(FoxgloveSocket, EndsMalformedConnectionsAndServesTheOthers) {
  SocketClient bystander(server_.port(), "foxglove.sdk.v1");
  bystander.write(R"({"op": "subscribe", "subscriptions": [{"id": 1, "channelId": 1}]})", true);
  for (int i = 0; i < 2; ++i) static_cast<void>(bystander.read());
  {
    SocketClient client(server_.port(), "foxglove.websocket.v1");
    client.write("no JSON", true);
    const auto reason = client.wait_for_close();
    EXPECT_EQ(reason.code, beast::websocket::close_code::policy_error);
    EXPECT_EQ(std::string_view(reason.reason.data(), reason.reason.size()), "a text message is no JSON object");
  }
  {
    SocketClient client(server_.port(), "foxglove.websocket.v1");
    client.write(std::string(kLongestMessage + 1, ' '), true);
    EXPECT_EQ(client.wait_for_close().code, beast::websocket::close_code::too_big);
  }
  FrameMutator mutator;
  std::mt19937 random(11);
  for (int i = 0; i < 500; ++i) {
    SocketClient client(server_.port(), "foxglove.websocket.v1");
    if (i % 2 == 0) {
      const auto frame = mutator.next();
      client.write(frame.bytes, frame.text);
    } else {
      std::string noise;
      for (int k = 0; k < 40; ++k) noise += static_cast<char>(random() & 0xFF);
      client.write_raw(noise);
    }
  }
  hub_->publish(0, 9, "still here");
  EXPECT_EQ(bystander.read(), message_data(1, 9) + "still here");
}

TEST_F(FoxgloveSocket, ForgetsClientsThatLeave) {
  {
    SocketClient client(server_.port(), "foxglove.sdk.v1");
    static_cast<void>(client.read());
    EXPECT_EQ(hub_->clients(), 1);
  }
  SocketClient stays(server_.port(), "foxglove.sdk.v1");
  stays.write(R"({"op": "subscribe", "subscriptions": [{"id": 1, "channelId": 2}]})", true);
  for (int i = 0; i < 2; ++i) static_cast<void>(stays.read());
  // The server notices the end of a connection when it reads or writes next.
  for (int i = 0; hub_->clients() > 1 && i < 1000; ++i) {
    stays.write(R"({"op": "getParameters", "parameterNames": []})", true);
    static_cast<void>(stays.read());
  }
  EXPECT_EQ(hub_->clients(), 1);
}

}  // namespace
}  // namespace hecaton::services::foxglove
