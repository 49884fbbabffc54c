/// The Foxglove WebSocket protocol: messages, clients of a hub, a cell's channels, and the web server.

#include <cstring>
#include <random>
#include <thread>

#include <gtest/gtest.h>

#include "services/ros2_messages/cdr.hpp"
#include "services/ros2_messages/schema.hpp"
#include "services/view/foxglove/cell_server.hpp"
#include "services/view/web_server.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/unit/services/view/web_client.hpp"

namespace hecaton::services::foxglove {
namespace {

using namespace std::chrono_literals;
using namespace std::string_literals;
using namespace std::string_view_literals;

// --- messages

template <class T>
T decoded_as(std::string_view message, bool text = true) {
  const Request request = text ? decode_text(message) : decode_binary(message);
  const T* as = std::get_if<T>(&request);
  EXPECT_NE(as, nullptr) << message << ": alternative " << request.index();
  return as == nullptr ? T{} : *as;
}

std::string refusal_of(std::string_view message, bool text = true) {
  const Request request = text ? decode_text(message) : decode_binary(message);
  const auto* malformed = std::get_if<Malformed>(&request);
  return malformed == nullptr ? "accepted" : malformed->reason;
}

TEST(FoxgloveMessages, DecodesWhatClientsSend) {
  const auto subscribe = decoded_as<Subscribe>(
      R"({"op": "subscribe", "subscriptions": [{"id": 0, "channelId": 4294967295}, {"id": 7, "channelId": 2}]})");
  ASSERT_EQ(subscribe.subscriptions.size(), 2U);
  EXPECT_EQ(subscribe.subscriptions[0].channel, 4294967295U);
  EXPECT_EQ(subscribe.subscriptions[1].id, 7U);
  EXPECT_EQ(decoded_as<Unsubscribe>(R"({"op": "unsubscribe", "subscriptionIds": [3]})").ids,
            std::vector<std::uint32_t>{3});
  const auto get = decoded_as<GetParameters>(R"({"op": "getParameters", "parameterNames": ["a"], "id": "x"})");
  EXPECT_EQ(get.names, std::vector<std::string>{"a"});
  EXPECT_EQ(get.id, "x");
  EXPECT_FALSE(decoded_as<GetParameters>(R"({"op": "getParameters", "parameterNames": []})").id);
  EXPECT_EQ(decoded_as<FetchAsset>(R"({"op": "fetchAsset", "uri": "package://a/b", "requestId": 1})").uri,
            "package://a/b");
  const auto call = decoded_as<CallService>("\2\1\0\0\0\2\0\0\0\3\0\0\0cdr\0\1\0\0"sv, false);
  EXPECT_EQ(call.service, 1U);
  EXPECT_EQ(call.call, 2U);
  EXPECT_EQ(call.encoding, "cdr");
  EXPECT_EQ(call.payload, "\0\1\0\0"sv);
  EXPECT_EQ(decoded_as<Unsupported>(R"({"op": "advertise", "channels": 3})").operation, "advertise");
  EXPECT_EQ(decoded_as<Unsupported>(R"({"op": "\u001b[2J"})").operation, "?[2J") << "it goes to people";
  EXPECT_EQ(decoded_as<Unsupported>("\x7f"sv, false).operation, "binary operation 127");
}

TEST(FoxgloveMessages, RefusesMalformedOnesWithAReason) {
  for (const char* text : {"", "[", "[]", "1", "\xff", "{\"op\": 1}", "{}"})
    EXPECT_NE(refusal_of(text), "accepted") << text;
  EXPECT_EQ(refusal_of(R"({"op": "subscribe"})"), "a field is missing");
  constexpr const char* kNumber = "an id is not a whole number from 0 to 4294967295";
  for (const char* id : {"-1", "4294967296", "1.5", "1e400", "\"1\"", "null", "[]", "99999999999999999999"}) {
    const std::string reason = refusal_of(R"({"op": "unsubscribe", "subscriptionIds": [)"s + id + "]}");
    EXPECT_TRUE(reason == kNumber || reason == "a text message is no JSON object") << id << ": " << reason;
  }
  EXPECT_EQ(refusal_of(R"({"op": "fetchAsset", "requestId": 1, "uri": ")" + std::string(1025, 'a') + "\"}"),
            "a text is too long");
  std::string many = R"({"op": "unsubscribe", "subscriptionIds": [0)";
  for (int i = 0; i < 1024; ++i) many += ",1";
  EXPECT_EQ(refusal_of(many + "]}"), "a list has more than 1024 items");
  EXPECT_EQ(refusal_of(std::string(65537, ' ')), "a message is longer than 65536 bytes");
  EXPECT_NE(refusal_of(std::string(60000, '[')), "accepted") << "deep nesting";
  EXPECT_NE(refusal_of("{\"op\":" + std::string(30000, '[') + std::string(30000, ']') + "}"), "accepted");
  EXPECT_EQ(refusal_of("", false), "a binary message is too short");
  EXPECT_EQ(refusal_of("\2\1\0\0"sv, false), "a binary message is too short");
  EXPECT_EQ(refusal_of("\2\1\0\0\0\2\0\0\0\xff\xff\xff\xff"sv, false), "a binary message is too short");
  EXPECT_EQ(refusal_of("\2\1\0\0\0\2\0\0\0\0\0\0\0"s + std::string(1025, 'x'), false),
            "the payload of a call is too long");
}

TEST(FoxgloveMessages, EncodesAsTheSpecificationSays) {
  EXPECT_EQ(message_data(0x04030201, 0x0102030405060708), "\1\1\2\3\4\x8\7\6\5\4\3\2\1"s);
  EXPECT_EQ(time(1), "\2\1\0\0\0\0\0\0\0"s);
  EXPECT_EQ(service_response(1, 2, "cdr", "xy"), "\3\1\0\0\0\2\0\0\0\3\0\0\0cdrxy"s);
  EXPECT_EQ(asset(5), "\4\5\0\0\0\0\0\0\0\0"s);
  EXPECT_EQ(asset_failure(5, "no"), "\4\5\0\0\0\1\2\0\0\0no"s);
  EXPECT_EQ(Json::parse(status(Level::kError, "\xff")).at("level"), 2) << "a text that is no UTF-8";
}

TEST(FoxgloveMessages, DefinesMessagesInTheNotationOfRos2) {
  EXPECT_EQ(ros2::message_definition("std_msgs/msg/String"), "string data\n");
  EXPECT_EQ(ros2::message_definition("std_srvs/srv/Trigger_Request"), "") << "the byte of an empty message is no field";
  const std::string line(80, '=');
  EXPECT_EQ(ros2::message_definition("sensor_msgs/msg/JointState"),
            "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort\n" + line +
                "\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n" + line +
                "\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n");
  EXPECT_EQ(ros2::message_definition("diagnostic_msgs/msg/DiagnosticStatus").substr(0, 11), "byte level\n");
  EXPECT_NE(ros2::message_definition("shape_msgs/msg/SolidPrimitive").find("float64[<=3] dimensions"),
            std::string::npos);
  EXPECT_NE(ros2::message_definition("shape_msgs/msg/MeshTriangle").find("uint32[3] vertex_indices"),
            std::string::npos);
  EXPECT_THROW(static_cast<void>(ros2::message_definition("std_msgs/msg/Missing")), std::invalid_argument);
}

// --- clients of a hub

HubOptions two_channels(bool latched = false) {
  HubOptions options;
  options.info.name = "cell";
  options.channels = {{"/a", "std_msgs/msg/String", "string data\n", latched},
                      {"/b", "std_msgs/msg/String", "string data\n", false}};
  options.parameters = Json::array({Json{{"name", "one"}, {"value", 1}}, Json{{"name", "two"}, {"value", "2"}}});
  options.asset = [](std::string_view uri) -> std::shared_ptr<const std::string> {
    return uri == "package://known" ? std::make_shared<const std::string>("content") : nullptr;
  };
  return options;
}

std::string bytes_of(const WebFrame& frame) {
  return frame.head + (frame.body ? *frame.body : std::string());
}

struct TestClient {
  explicit TestClient(const std::shared_ptr<Hub>& hub) : session(hub->open([this] { ++wakes; })) {}

  void send(const std::string& text) { session->received(text, true); }
  void subscribe(std::uint32_t id, std::uint32_t channel) {
    send(Json{{"op", "subscribe"}, {"subscriptions", {{{"id", id}, {"channelId", channel}}}}}.dump());
  }
  /// All that waits for the client.
  std::vector<std::string> take() {
    std::vector<std::string> frames;
    while (auto frame = session->next()) frames.push_back(bytes_of(*frame));
    return frames;
  }

  int wakes = 0;
  std::unique_ptr<WebSession> session;
};

TEST(FoxgloveHub, GreetsWithItsNameAndChannels) {
  const auto hub = std::make_shared<Hub>(two_channels());
  TestClient client(hub);
  const auto frames = client.take();
  ASSERT_EQ(frames.size(), 2U);
  const Json info = Json::parse(frames[0]);
  EXPECT_EQ(info.at("op"), "serverInfo");
  EXPECT_EQ(info.at("capabilities"), Json({"time", "parameters", "assets"}));
  const Json channels = Json::parse(frames[1]).at("channels");
  EXPECT_EQ(channels.size(), 2U);
  EXPECT_EQ(channels[1].at("id"), 2);
  EXPECT_EQ(channels[1].at("topic"), "/b");
  EXPECT_EQ(channels[1].at("schema"), "string data\n");
}

TEST(FoxgloveHub, SendsMessagesOfSubscribedChannelsOnly) {
  const auto hub = std::make_shared<Hub>(two_channels());
  TestClient client(hub);
  client.take();
  EXPECT_FALSE(hub->wanted(0));
  client.subscribe(9, 1);
  EXPECT_TRUE(hub->wanted(0));
  EXPECT_FALSE(hub->wanted(1));
  hub->publish(0, 5, "first");
  hub->publish(1, 5, "other");
  EXPECT_EQ(client.wakes, 1);
  EXPECT_EQ(client.take(), std::vector{message_data(9, 5) + "first"});
  client.send(R"({"op": "unsubscribe", "subscriptionIds": [9]})");
  EXPECT_FALSE(hub->wanted(0));
  hub->publish(0, 6, "second");
  EXPECT_TRUE(client.take().empty());
}

TEST(FoxgloveHub, ForgetsTheSubscriptionsOfAClientThatLeaves) {
  const auto hub = std::make_shared<Hub>(two_channels());
  {
    TestClient client(hub);
    client.subscribe(1, 1);
    EXPECT_TRUE(hub->wanted(0));
    EXPECT_EQ(hub->clients(), 1);
  }
  EXPECT_FALSE(hub->wanted(0));
  EXPECT_EQ(hub->clients(), 0);
}

TEST(FoxgloveHub, GivesLateSubscribersTheLastLatchedMessage) {
  const auto hub = std::make_shared<Hub>(two_channels(true));
  hub->publish(0, 1, "old");
  hub->publish(0, 2, "robot");
  hub->publish(1, 2, "state");
  TestClient client(hub);
  client.take();
  client.subscribe(1, 1);
  client.subscribe(2, 2);
  EXPECT_EQ(client.take(), std::vector{message_data(1, 2) + "robot"});
}

TEST(FoxgloveHub, KeepsOneMessageOfEachChannelForASlowClient) {
  const auto hub = std::make_shared<Hub>(two_channels());
  TestClient slow(hub);
  TestClient quick(hub);
  slow.take();
  quick.take();
  slow.subscribe(1, 1);
  slow.subscribe(2, 2);
  quick.subscribe(1, 1);
  hub->publish(1, 0, "rare");
  for (int i = 1; i <= 1000; ++i) {
    hub->publish(0, static_cast<std::uint64_t>(i), std::to_string(i));
    EXPECT_EQ(quick.take(), std::vector{message_data(1, static_cast<std::uint64_t>(i)) + std::to_string(i)});
  }
  EXPECT_EQ(hub->skipped(), 999U);
  EXPECT_EQ(slow.take(), (std::vector{message_data(1, 1000) + "1000", message_data(2, 0) + "rare"}));
}

TEST(FoxgloveHub, LetsNoBusyChannelStarveAnother) {
  const auto hub = std::make_shared<Hub>(two_channels());
  TestClient client(hub);
  client.take();
  client.subscribe(1, 1);
  client.subscribe(2, 2);
  hub->publish(1, 0, "rare");
  std::vector<std::string> frames;
  for (int i = 0; i < 2; ++i) {
    hub->publish(0, 0, "busy");
    frames.push_back(bytes_of(*client.session->next()));
  }
  EXPECT_EQ(frames[1], message_data(2, 0) + "rare");
}

TEST(FoxgloveHub, ClosesAClientThatLeavesAnswersUnread) {
  const auto hub = std::make_shared<Hub>(two_channels());
  TestClient client(hub);
  client.take();
  for (int i = 0; i < 256; ++i) client.send(R"({"op": "getParameters", "parameterNames": []})");
  EXPECT_EQ(client.session->end(), "");
  client.send(R"({"op": "getParameters", "parameterNames": []})");
  EXPECT_NE(client.session->end(), "");
  EXPECT_EQ(client.take().size(), 1U) << "only the reason";
  TestClient fetches(hub);
  fetches.take();
  for (int i = 0; i < 257; ++i) fetches.send(R"({"op": "fetchAsset", "uri": "x", "requestId": 1})");
  EXPECT_NE(fetches.session->end(), "");
}

TEST(FoxgloveHub, WarnsOfSubscriptionsThatCannotBe) {
  const auto hub = std::make_shared<Hub>(two_channels());
  TestClient client(hub);
  client.take();
  client.subscribe(1, 1);
  const auto warning = [&] {
    const auto frames = client.take();
    return frames.size() == 1 ? Json::parse(frames[0]).at("message").get<std::string>() : std::to_string(frames.size());
  };
  client.subscribe(2, 1);
  EXPECT_EQ(warning(), "subscription 2: channel 1 has subscription 1 already");
  client.subscribe(1, 2);
  EXPECT_EQ(warning(), "subscription 1 is in use");
  client.subscribe(3, 3);
  EXPECT_EQ(warning(), "subscription 3: there is no channel 3");
  client.subscribe(3, 0);
  EXPECT_EQ(warning(), "subscription 3: there is no channel 0");
  client.send(R"({"op": "unsubscribe", "subscriptionIds": [4]})");
  EXPECT_EQ(warning(), "there is no subscription 4");
  EXPECT_EQ(client.session->end(), "");
}

TEST(FoxgloveHub, AnswersQuestionsForParametersAndAssets) {
  const auto hub = std::make_shared<Hub>(two_channels());
  TestClient client(hub);
  client.take();
  client.send(R"({"op": "getParameters", "parameterNames": ["two", "three"], "id": "q"})");
  client.send(R"({"op": "fetchAsset", "uri": "package://known", "requestId": 3})");
  client.send(R"({"op": "fetchAsset", "uri": "file:///etc/passwd", "requestId": 4})");
  const auto frames = client.take();
  ASSERT_EQ(frames.size(), 3U);
  const Json values = Json::parse(frames[0]);
  EXPECT_EQ(values.at("id"), "q");
  EXPECT_EQ(values.at("parameters"), Json::array({Json{{"name", "two"}, {"value", "2"}}}));
  EXPECT_EQ(frames[1], asset(3) + "content");
  EXPECT_EQ(frames[2].substr(0, 6), asset_failure(4, "").substr(0, 6));
}

// --- orders

constexpr std::string_view kCall = "\2\1\0\0\0\7\0\0\0\3\0\0\0cdr\0\1\0\0\0"sv;  // of service 1
std::string call(char service) {
  std::string frame(kCall);
  frame[1] = service;
  return frame;
}

TEST(FoxgloveOrders, AreRefusedUnlessTheServerTakesThem) {
  const auto hub = std::make_shared<Hub>(two_channels());
  TestClient client(hub);
  client.take();
  client.session->received(kCall, false);
  const Json failure = Json::parse(client.take().at(0));
  EXPECT_EQ(failure.at("op"), "serviceCallFailure");
  EXPECT_EQ(failure.at("callId"), 7);
}

TEST(FoxgloveOrders, GoToTheirSinkAndComeBackToTheirClient) {
  HubOptions options = two_channels();
  options.arms = {"north", "west"};
  std::vector<Order> orders;
  std::vector<std::function<void(OrderResult)>> answers;
  options.orders = [&](const Order& order, std::function<void(OrderResult)> answer) {
    orders.push_back(order);
    answers.push_back(std::move(answer));
  };
  const auto hub = std::make_shared<Hub>(std::move(options));
  auto client = std::make_unique<TestClient>(hub);
  TestClient other(hub);
  const Json services = Json::parse(client->take().at(2)).at("services");
  ASSERT_EQ(services.size(), 9U);
  other.take();
  std::vector<std::string> names;
  for (const Json& service : services) names.push_back(service.at("name"));
  EXPECT_EQ(names[0], "/hecaton/hold");
  EXPECT_EQ(names[5], "/north/stop");
  client->session->received(call(1), false);
  client->session->received(call(6), false);
  ASSERT_EQ(orders.size(), 2U);
  EXPECT_EQ(orders[0].kind, OrderKind::kHold);
  EXPECT_EQ(orders[0].arm, "");
  EXPECT_EQ(orders[1].kind, OrderKind::kStop);
  EXPECT_EQ(orders[1].arm, "north");
  std::thread([&] { answers[1]({true, "north stops"}); }).join();
  hub->deliver_answers();
  const auto frames = client->take();
  ASSERT_EQ(frames.size(), 1U);
  const std::string head = service_response(6, 7, "cdr", "");
  ASSERT_EQ(frames[0].substr(0, head.size()), head);
  const auto* payload = reinterpret_cast<const std::uint8_t*>(frames[0].data() + head.size());
  const auto response = ros2::decoded<ros2::TriggerResponse>({payload, frames[0].size() - head.size()});
  ASSERT_TRUE(response);
  EXPECT_TRUE(response->success);
  EXPECT_EQ(response->message, "north stops");
  EXPECT_TRUE(other.take().empty());
  client.reset();
  answers[0]({true, "too late"});
  hub->deliver_answers();
  EXPECT_TRUE(other.take().empty());
}

TEST(FoxgloveOrders, RefusesUnknownServicesAndTooManyCalls) {
  HubOptions options = two_channels();
  int orders = 0;
  options.orders = [&](const Order&, const std::function<void(OrderResult)>&) { ++orders; };
  const auto hub = std::make_shared<Hub>(std::move(options));
  TestClient client(hub);
  client.take();
  for (const char service : {'\0', '\4', '\x7f'}) client.session->received(call(service), false);
  EXPECT_EQ(client.take().size(), 3U);
  for (int i = 0; i < 17; ++i) client.session->received(kCall, false);
  EXPECT_EQ(orders, 16);
  EXPECT_EQ(Json::parse(client.take().at(0)).at("message"), "16 calls wait for an answer already");
}

// --- malformed messages

/// Frames near valid ones, and noise.
class FrameMutator {
 public:
  struct Frame {
    std::string bytes;
    bool text;
  };
  Frame next() {
    static const std::vector<std::string> kTexts{
        R"({"op":"subscribe","subscriptions":[{"id":0,"channelId":1},{"id":1,"channelId":2}]})",
        R"({"op":"unsubscribe","subscriptionIds":[0,1]})",
        R"({"op":"getParameters","parameterNames":["one"],"id":"x"})",
        R"({"op":"setParameters","parameters":[{"name":"one","value":[1,2]}],"id":"x"})",
        R"({"op":"fetchAsset","uri":"package://known","requestId":1})",
        R"({"op":"advertise","channels":[]})"};
    Frame frame;
    frame.text = below(4) != 0;
    frame.bytes = frame.text ? kTexts[below(kTexts.size())] : std::string(kCall);
    const std::size_t changes = 1 + below(4);
    for (std::size_t i = 0; i < changes; ++i) change(frame.bytes);
    return frame;
  }

 private:
  std::size_t below(std::size_t limit) { return std::uniform_int_distribution<std::size_t>(0, limit - 1)(random_); }
  void change(std::string& bytes) {
    static const std::vector<std::string> kParts{
        "-1", "1e999", "4294967296", "\"", "{", "[[[[", "null", "\\ud800", "\xff", "\0"s, "\xff\xff\xff\xff"};
    const std::size_t at = below(bytes.size() + 1);
    switch (below(6)) {
      case 0:
        bytes.resize(at);
        break;
      case 1:
        bytes.insert(at, kParts[below(kParts.size())]);
        break;
      case 2:
        bytes.erase(at, below(8));
        break;
      case 3:
        bytes.insert(at, std::string(below(3000), static_cast<char>(below(256))));
        break;
      default:
        if (at < bytes.size()) bytes[at] = static_cast<char>(below(256));
    }
  }

  std::mt19937 random_{7};
};

TEST(FoxgloveMalformed, EndEachOneItsOwnConnection) {
  constexpr int kMalformed = 100'000;
  HubOptions options = two_channels(true);
  int orders = 0;
  options.orders = [&](const Order&, const std::function<void(OrderResult)>& answer) { ++orders, answer({}); };
  const auto hub = std::make_shared<Hub>(std::move(options));
  hub->publish(0, 1, "latched");
  TestClient bystander(hub);
  bystander.take();
  bystander.subscribe(1, 1);
  auto client = std::make_unique<TestClient>(hub);
  client->take();
  FrameMutator mutator;
  int ended = 0;
  int accepted = 0;
  while (ended < kMalformed) {
    const auto frame = mutator.next();
    client->session->received(frame.bytes, frame.text);
    hub->deliver_answers();
    const auto answers = client->take();
    if (client->session->end().empty()) {
      ++accepted;
      continue;
    }
    ++ended;
    ASSERT_EQ(answers.size(), 1U);
    ASSERT_EQ(Json::parse(answers[0]).at("level"), 2);
    // What comes after the end is ignored.
    client->session->received(frame.bytes, frame.text);
    ASSERT_TRUE(client->take().empty());
    client = std::make_unique<TestClient>(hub);
    client->take();
  }
  EXPECT_GT(accepted, 1000) << "some changed frames are still well-formed";
  EXPECT_EQ(hub->clients(), 2);
  EXPECT_EQ(bystander.session->end(), "");
  bystander.take();
  hub->publish(0, 2, "still here");
  EXPECT_EQ(bystander.take(), std::vector{message_data(1, 2) + "still here"});
}

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
    client_ = server_.protocol().open([] {});
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
  const auto client = server.protocol().open([] {});
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
    options.protocol.open = [hub](std::function<void()> wake) { return hub->open(std::move(wake)); };
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
