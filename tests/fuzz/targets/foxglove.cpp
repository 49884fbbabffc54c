// Messages of one client of the Foxglove protocol, between blank lines. The first byte of each: 't', a text; else
// binary.

#include <vector>

#include "services/view/foxglove/hub.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace {

using namespace hecaton;
using namespace hecaton::services;
using namespace hecaton::services::foxglove;

HubOptions options() {
  HubOptions options;
  options.info.name = "cell";
  options.channels = {{"/a", "std_msgs/msg/String", "string data\n", true},
                      {"/b", "std_msgs/msg/String", "string data\n", false}};
  options.parameters = Json::array({Json{{"name", "one"}, {"value", 1}}});
  options.asset = [](std::string_view uri) -> std::shared_ptr<const std::string> {
    return uri == "package://known" ? std::make_shared<const std::string>("content") : nullptr;
  };
  options.arms = {"north"};
  options.orders = {[](std::string_view) { return true; },
                    [](const Order& order, const std::function<void(OrderResult)>& answer) {
                      fuzz::require(order.arm.empty() || order.arm == "north", "an order is for the cell or an arm");
                      answer({true, "done"});
                    }};
  return options;
}

std::vector<std::string> messages_in(const std::string& text) {
  std::vector<std::string> messages;
  for (std::size_t at = 0; at <= text.size();) {
    const std::size_t end = std::min(text.find("\n\n", at), text.size());
    messages.push_back(text.substr(at, end - at));
    at = end + 2;
  }
  return messages;
}

/// Takes what waits for the client, and returns the number of messages.
std::size_t take(WebSession& session) {
  std::size_t count = 0;
  while (const auto frame = session.next()) {
    ++count;
    fuzz::require(!frame->head.empty(), "a message is not empty");
    if (!frame->text) continue;
    const Json json = Json::parse(frame->head, nullptr, false);
    fuzz::require(json.is_object() && json.contains("op"), "a text to a client is JSON with an operation");
  }
  return count;
}

}  // namespace

extern "C" int HECATON_FUZZ_TARGET(foxglove)(const std::uint8_t* data, std::size_t size) {
  static const auto kHub = std::make_shared<Hub>(options());
  const auto session = kHub->open({[] {}});
  take(*session);
  bool ended = false;
  for (const std::string& message : messages_in(fuzz::text_of({data, size}))) {
    const bool text = message.starts_with('t');
    session->received(std::string_view(message).substr(message.empty() ? 0 : 1), text);
    kHub->publish(0, 1, "latched");
    kHub->publish(1, 2, "state");
    kHub->deliver_answers();
    const auto end = session->end();
    if (!end) {
      take(*session);
      continue;
    }
    fuzz::require_sentence(*end);
    fuzz::require(take(*session) == (ended ? 0U : 1U), "a connection ends with one status and then is silent");
    ended = true;
  }
  return 0;
}
