#pragma once
/// Messages of the Foxglove WebSocket protocol, sub-protocols foxglove.sdk.v1 and foxglove.websocket.v1, which agree in
/// all messages used here. All functions are pure. What a client sends is bounded in size, count and length of texts
/// before it is kept.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include <nlohmann/json.hpp>

namespace hecaton::services::foxglove {

using Json = nlohmann::json;

inline constexpr std::string_view kSubprotocols[] = {"foxglove.sdk.v1", "foxglove.websocket.v1"};

inline constexpr std::size_t kLongestMessage = 64 * 1024;  ///< from a client [byte]
inline constexpr std::size_t kMostItems = 1024;            ///< in a list of a client
inline constexpr std::size_t kLongestName = 256;           ///< of a parameter, an encoding or an id [byte]
inline constexpr std::size_t kLongestUri = 1024;           ///< [byte]
inline constexpr std::size_t kLongestCall = 1024;          ///< payload of a call [byte]

// --- From a client

struct Subscribe {
  struct Subscription {
    std::uint32_t id;
    std::uint32_t channel;
  };
  std::vector<Subscription> subscriptions;
};
struct Unsubscribe {
  std::vector<std::uint32_t> ids;
};
struct GetParameters {
  std::vector<std::string> names;  ///< empty: all
  std::optional<std::string> id;   ///< to repeat in the answer
};
struct SetParameters {
  std::vector<std::string> names;
  std::optional<std::string> id;
};
/// Values of parameters never change.
struct WatchParameters {};
struct FetchAsset {
  std::string uri;
  std::uint32_t request;
};
struct CallService {
  std::uint32_t service;
  std::uint32_t call;
  std::string encoding;
  std::string payload;
};
/// A well-formed message with an operation that is not offered.
struct Unsupported {
  std::string operation;  ///< printable, for people
};
/// The client does not speak the protocol.
struct Malformed {
  std::string reason;  ///< a sentence without what the client sent
};
using Request = std::variant<Malformed, Unsupported, Subscribe, Unsubscribe, GetParameters, SetParameters,
                             WatchParameters, FetchAsset, CallService>;

[[nodiscard]] Request decode_text(std::string_view message);
[[nodiscard]] Request decode_binary(std::string_view message);

// --- To a client: JSON

struct ServerInfo {
  std::string name;
  std::vector<std::string> capabilities;
  std::vector<std::string> encodings;                         ///< of calls
  std::vector<std::pair<std::string, std::string>> metadata;  ///< keys and values
  std::string session;  ///< changes when the server starts again, so that clients forget what they had
};
struct Channel {
  std::uint32_t id;
  std::string topic;
  std::string type;    ///< "sensor_msgs/msg/JointState"
  std::string schema;  ///< its definition
};
struct Service {
  std::uint32_t id;
  std::string name;
  std::string type;      ///< "std_srvs/srv/Trigger"
  std::string request;   ///< definition
  std::string response;  ///< definition
};
enum class Level : std::uint8_t { kInfo, kWarning, kError };

[[nodiscard]] std::string server_info(const ServerInfo& info);
[[nodiscard]] std::string advertise(const std::vector<Channel>& channels);
[[nodiscard]] std::string advertise_services(const std::vector<Service>& services);
[[nodiscard]] std::string status(Level level, const std::string& message);
/// `parameters`: a list of {name, value, type?}.
[[nodiscard]] std::string parameter_values(const Json& parameters, const std::optional<std::string>& id);
[[nodiscard]] std::string service_call_failure(std::uint32_t service, std::uint32_t call, const std::string& message);

// --- To a client: binary

/// The front of a message on a channel; the encoded message follows.
[[nodiscard]] std::string message_data(std::uint32_t subscription, std::uint64_t unix_ns);
[[nodiscard]] std::string time(std::uint64_t unix_ns);
[[nodiscard]] std::string service_response(std::uint32_t service, std::uint32_t call, std::string_view encoding,
                                           std::string_view payload);
/// The front of an asset; its content follows.
[[nodiscard]] std::string asset(std::uint32_t request);
[[nodiscard]] std::string asset_failure(std::uint32_t request, std::string_view reason);

}  // namespace hecaton::services::foxglove
