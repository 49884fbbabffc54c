/// The Foxglove WebSocket protocol without cell and network: messages, clients of a hub, malformed frames.

#include <thread>

#include <gtest/gtest.h>

#include "services/ros2_messages/cdr.hpp"
#include "services/ros2_messages/ros2_types.hpp"
#include "services/ros2_messages/schema.hpp"
#include "tests/unit/services/view/foxglove_frames.hpp"

namespace hecaton::services::foxglove {
namespace {

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

struct TestClient {
  explicit TestClient(const std::shared_ptr<Hub>& hub, const std::string& token = "")
      : session(hub->open({[this] { ++wakes; }, {1, "127.0.0.1:5"}, token})) {}

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
  EXPECT_EQ(client.session->end(), std::nullopt);
  client.send(R"({"op": "getParameters", "parameterNames": []})");
  EXPECT_TRUE(client.session->end());
  EXPECT_EQ(client.take().size(), 1U) << "only the reason";
  TestClient fetches(hub);
  fetches.take();
  for (int i = 0; i < 257; ++i) fetches.send(R"({"op": "fetchAsset", "uri": "x", "requestId": 1})");
  EXPECT_TRUE(fetches.session->end());
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
  EXPECT_EQ(client.session->end(), std::nullopt);
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

/// A client whose assets are read when the test says so.
struct SlowAssets {
  explicit SlowAssets(const std::shared_ptr<Hub>& hub, std::size_t most) {
    WebOpening opening{[this] { ++wakes; }};
    opening.background = [this, most](std::function<void()> job) {
      if (jobs.size() >= most) return false;
      jobs.push_back(std::move(job));
      return true;
    };
    session = hub->open(std::move(opening));
    while (session->next()) continue;
  }
  std::string next() const {
    const auto frame = session->next();
    return frame ? bytes_of(*frame) : "nothing";
  }

  int wakes = 0;
  std::vector<std::function<void()>> jobs;
  std::unique_ptr<WebSession> session;
};

TEST(FoxgloveHub, SendsMessagesAndAnswersWhileAnAssetIsRead) {
  const auto hub = std::make_shared<Hub>(two_channels());
  SlowAssets client(hub, 2);
  client.session->received(R"({"op": "subscribe", "subscriptions": [{"id": 1, "channelId": 1}]})", true);
  client.session->received(R"({"op": "fetchAsset", "uri": "package://known", "requestId": 3})", true);
  client.session->received(R"({"op": "fetchAsset", "uri": "package://known", "requestId": 4})", true);
  hub->publish(0, 1, "a");
  EXPECT_EQ(client.next(), message_data(1, 1) + "a");
  client.session->received(R"({"op": "getParameters", "parameterNames": ["two"], "id": "q"})", true);
  EXPECT_EQ(Json::parse(client.next()).at("id"), "q");
  EXPECT_EQ(client.next(), "nothing");
  ASSERT_EQ(client.jobs.size(), 1U) << "of one client, one asset is read at a time";
  const int wakes = client.wakes;
  client.jobs[0]();
  EXPECT_EQ(client.wakes, wakes + 1);
  EXPECT_EQ(client.next(), asset(3) + "content");
  EXPECT_EQ(client.next(), "nothing");
  ASSERT_EQ(client.jobs.size(), 2U);
  client.session.reset();
  client.jobs[1]();  // its client has gone
}

TEST(FoxgloveHub, RefusesAnAssetWhileTooManyWait) {
  const auto hub = std::make_shared<Hub>(two_channels());
  SlowAssets client(hub, 0);
  client.session->received(R"({"op": "fetchAsset", "uri": "package://known", "requestId": 3})", true);
  EXPECT_EQ(client.next().substr(0, 6), asset_failure(3, "").substr(0, 6));
  EXPECT_EQ(client.next(), "nothing");
}

TEST(FoxgloveHub, SendsNoAssetToAClientThatItEnds) {
  const auto hub = std::make_shared<Hub>(two_channels());
  SlowAssets client(hub, 1);
  client.session->received(R"({"op": "fetchAsset", "uri": "package://known", "requestId": 3})", true);
  EXPECT_EQ(client.next(), "nothing");
  client.jobs[0]();
  client.session->received("{", true);
  EXPECT_NE(client.next(), asset(3) + "content");
  EXPECT_EQ(client.next(), "nothing");
}

// --- orders

std::string call(char service) {
  std::string frame(kCall);
  frame[1] = service;
  return frame;
}

const std::string kToken = "right";

OrderReceiver for_token(std::function<void(const Order&, std::function<void(OrderResult)>)> carry_out) {
  return {[](std::string_view token) { return token == kToken; }, std::move(carry_out)};
}

TEST(FoxgloveOrders, AreRefusedWithoutTheToken) {
  HubOptions options = two_channels();
  int orders = 0;
  options.orders = for_token([&](const Order&, const std::function<void(OrderResult)>&) { ++orders; });
  const auto hub = std::make_shared<Hub>(std::move(options));
  for (const std::string token : {"", "wrong", "righ", "right "}) {
    TestClient client(hub, token);
    const auto greeting = client.take();
    ASSERT_EQ(greeting.size(), token.empty() ? 2U : 3U);
    EXPECT_EQ(Json::parse(greeting[0]).at("capabilities"), Json({"time", "parameters", "assets"}));
    if (!token.empty()) {
      EXPECT_EQ(Json::parse(greeting[2]).at("op"), "status");
    }
    client.session->received(kCall, false);
    const Json failure = Json::parse(client.take().at(0));
    EXPECT_EQ(failure.at("op"), "serviceCallFailure");
    EXPECT_EQ(failure.at("callId"), 7);
  }
  EXPECT_EQ(orders, 0);
}

TEST(FoxgloveOrders, OfAServerThatTakesNoneAreRefused) {
  const auto hub = std::make_shared<Hub>(two_channels());
  TestClient client(hub, kToken);
  client.take();
  client.session->received(kCall, false);
  EXPECT_EQ(Json::parse(client.take().at(0)).at("op"), "serviceCallFailure");
}

TEST(FoxgloveOrders, GoToTheirSinkAndComeBackToTheirClient) {
  HubOptions options = two_channels();
  options.arms = {"north", "west"};
  std::vector<Order> orders;
  std::vector<std::function<void(OrderResult)>> answers;
  options.orders = for_token([&](const Order& order, std::function<void(OrderResult)> answer) {
    orders.push_back(order);
    answers.push_back(std::move(answer));
  });
  const auto hub = std::make_shared<Hub>(std::move(options));
  auto client = std::make_unique<TestClient>(hub, kToken);
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
  EXPECT_EQ(orders[1].client.address, "127.0.0.1:5");
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
  options.orders = for_token([&](const Order&, const std::function<void(OrderResult)>&) { ++orders; });
  const auto hub = std::make_shared<Hub>(std::move(options));
  TestClient client(hub, kToken);
  client.take();
  for (const char service : {'\0', '\4', '\x7f'}) client.session->received(call(service), false);
  EXPECT_EQ(client.take().size(), 3U);
  for (int i = 0; i < 17; ++i) client.session->received(kCall, false);
  EXPECT_EQ(orders, 16);
  EXPECT_EQ(Json::parse(client.take().at(0)).at("message"), "16 calls wait for an answer already");
}

// --- malformed messages

TEST(FoxgloveMalformed, EndEachOneItsOwnConnection) {
  constexpr int kMalformed = 100'000;
  HubOptions options = two_channels(true);
  int orders = 0;
  options.orders =
      for_token([&](const Order&, const std::function<void(OrderResult)>& answer) { ++orders, answer({}); });
  const auto hub = std::make_shared<Hub>(std::move(options));
  hub->publish(0, 1, "latched");
  TestClient bystander(hub);
  bystander.take();
  bystander.subscribe(1, 1);
  auto client = std::make_unique<TestClient>(hub, kToken);
  client->take();
  FrameMutator mutator;
  int ended = 0;
  int accepted = 0;
  while (ended < kMalformed) {
    const auto frame = mutator.next();
    client->session->received(frame.bytes, frame.text);
    hub->deliver_answers();
    const auto answers = client->take();
    if (!client->session->end()) {
      ++accepted;
      continue;
    }
    ++ended;
    ASSERT_EQ(answers.size(), 1U);
    ASSERT_EQ(Json::parse(answers[0]).at("level"), 2);
    // What comes after the end is ignored.
    client->session->received(frame.bytes, frame.text);
    ASSERT_TRUE(client->take().empty());
    client = std::make_unique<TestClient>(hub, kToken);
    client->take();
  }
  EXPECT_GT(accepted, 1000) << "some changed frames are still well-formed";
  EXPECT_EQ(hub->clients(), 2);
  EXPECT_EQ(bystander.session->end(), std::nullopt);
  bystander.take();
  hub->publish(0, 2, "still here");
  EXPECT_EQ(bystander.take(), std::vector{message_data(1, 2) + "still here"});
}

}  // namespace
}  // namespace hecaton::services::foxglove
