#pragma once
/// What the tests of the Foxglove protocol share: a small hub, and malformed frames.

#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "services/view/foxglove/hub.hpp"

namespace hecaton::services::foxglove {

using namespace std::string_literals;
using namespace std::string_view_literals;

inline HubOptions two_channels(bool latched = false) {
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

inline std::string bytes_of(const WebFrame& frame) {
  return frame.head + (frame.body ? *frame.body : std::string());
}

inline constexpr std::string_view kCall = "\2\1\0\0\0\7\0\0\0\3\0\0\0cdr\0\1\0\0\0"sv;  // of service 1

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

}  // namespace hecaton::services::foxglove
