#include "services/view/foxglove/protocol.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>

namespace hecaton::services::foxglove {
namespace {

// Operation codes of binary messages.
constexpr std::uint8_t kMessageData = 1;
constexpr std::uint8_t kTime = 2;
constexpr std::uint8_t kServiceResponse = 3;
constexpr std::uint8_t kAssetResponse = 4;
constexpr std::uint8_t kClientMessage = 1;
constexpr std::uint8_t kServiceRequest = 2;

constexpr std::size_t kLongestOperation = 32;  // that is repeated to the client

/// Ends decoding; never leaves this file.
struct Refused {
  const char* reason;
};

const Json& member(const Json& object, const char* key) {
  const auto found = object.find(key);
  if (found == object.end()) throw Refused{"a field is missing"};
  return *found;
}

std::uint32_t number(const Json& value) {
  if (!value.is_number_unsigned() || value.get<std::uint64_t>() > std::numeric_limits<std::uint32_t>::max()) {
    throw Refused{"an id is not a whole number from 0 to 4294967295"};
  }
  return value.get<std::uint32_t>();
}

std::string text(const Json& value, std::size_t longest) {
  if (!value.is_string()) throw Refused{"a field that must be a text is none"};
  const auto& content = value.get_ref<const std::string&>();
  if (content.size() > longest) throw Refused{"a text is too long"};
  return content;
}

const Json& list(const Json& value) {
  if (!value.is_array()) throw Refused{"a field that must be a list is none"};
  if (value.size() > kMostItems) throw Refused{"a list has more than 1024 items"};
  return value;
}

std::optional<std::string> optional_id(const Json& message) {
  const auto found = message.find("id");
  if (found == message.end()) return std::nullopt;
  return text(*found, kLongestName);
}

std::vector<std::string> names(const Json& value) {
  std::vector<std::string> all;
  for (const Json& name : list(value)) all.push_back(text(name, kLongestName));
  return all;
}

Subscribe subscribe(const Json& message) {
  Subscribe request;
  for (const Json& one : list(member(message, "subscriptions"))) {
    if (!one.is_object()) throw Refused{"a subscription is no object"};
    request.subscriptions.push_back({number(member(one, "id")), number(member(one, "channelId"))});
  }
  return request;
}

Unsubscribe unsubscribe(const Json& message) {
  Unsubscribe request;
  for (const Json& id : list(member(message, "subscriptionIds"))) request.ids.push_back(number(id));
  return request;
}

SetParameters set_parameters(const Json& message) {
  SetParameters request;
  for (const Json& one : list(member(message, "parameters"))) {
    if (!one.is_object()) throw Refused{"a parameter is no object"};
    request.names.push_back(text(member(one, "name"), kLongestName));
  }
  request.id = optional_id(message);
  return request;
}

std::string printable(const std::string& operation) {
  std::string out = operation.substr(0, kLongestOperation);
  std::replace_if(
      out.begin(), out.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
  return out;
}

Request request_of(const Json& message) {
  const std::string operation = text(member(message, "op"), kLongestName);
  if (operation == "subscribe") return subscribe(message);
  if (operation == "unsubscribe") return unsubscribe(message);
  if (operation == "getParameters") {
    return GetParameters{names(member(message, "parameterNames")), optional_id(message)};
  }
  if (operation == "setParameters") return set_parameters(message);
  if (operation == "subscribeParameterUpdates" || operation == "unsubscribeParameterUpdates") {
    static_cast<void>(names(member(message, "parameterNames")));
    return WatchParameters{};
  }
  if (operation == "fetchAsset") {
    return FetchAsset{text(member(message, "uri"), kLongestUri), number(member(message, "requestId"))};
  }
  return Unsupported{printable(operation)};
}

std::string dumped(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

/// Appends a number, little-endian.
template <class T>
void put(std::string& out, T value) {
  for (std::size_t i = 0; i < sizeof(T); ++i) out += static_cast<char>((value >> (8 * i)) & 0xFF);
}

template <class T>
T take(std::string_view& from) {
  if (from.size() < sizeof(T)) throw Refused{"a binary message is too short"};
  T value = 0;
  for (std::size_t i = 0; i < sizeof(T); ++i) {
    value |= static_cast<T>(static_cast<T>(static_cast<std::uint8_t>(from[i])) << (8 * i));
  }
  from.remove_prefix(sizeof(T));
  return value;
}

CallService call_service(std::string_view message) {
  CallService call;
  call.service = take<std::uint32_t>(message);
  call.call = take<std::uint32_t>(message);
  const auto length = take<std::uint32_t>(message);
  if (length > message.size()) throw Refused{"a binary message is too short"};
  if (length > kLongestName) throw Refused{"the name of an encoding is too long"};
  if (message.size() - length > kLongestCall) throw Refused{"the payload of a call is too long"};
  call.encoding = message.substr(0, length);
  call.payload = message.substr(length);
  return call;
}

}  // namespace

Request decode_text(std::string_view message) {
  if (message.size() > kLongestMessage) return Malformed{"a message is longer than 65536 bytes"};
  const Json json = Json::parse(message, nullptr, false);
  if (!json.is_object()) return Malformed{"a text message is no JSON object"};
  try {
    return request_of(json);
  } catch (const Refused& refused) {
    return Malformed{refused.reason};
  }
}

Request decode_binary(std::string_view message) {
  if (message.size() > kLongestMessage) return Malformed{"a message is longer than 65536 bytes"};
  try {
    const auto operation = take<std::uint8_t>(message);
    if (operation == kServiceRequest) return call_service(message);
    if (operation == kClientMessage) return Unsupported{"message data"};
    return Unsupported{"binary operation " + std::to_string(operation)};
  } catch (const Refused& refused) {
    return Malformed{refused.reason};
  }
}

std::string server_info(const ServerInfo& info) {
  Json metadata = Json::object();
  for (const auto& [key, value] : info.metadata) metadata[key] = value;
  return dumped({{"op", "serverInfo"},
                 {"name", info.name},
                 {"capabilities", info.capabilities},
                 {"supportedEncodings", info.encodings},
                 {"metadata", metadata},
                 {"sessionId", info.session}});
}

std::string advertise(const std::vector<Channel>& channels) {
  Json all = Json::array();
  for (const Channel& channel : channels) {
    all.push_back({{"id", channel.id},
                   {"topic", channel.topic},
                   {"encoding", "cdr"},
                   {"schemaName", channel.type},
                   {"schema", channel.schema},
                   {"schemaEncoding", "ros2msg"}});
  }
  return dumped({{"op", "advertise"}, {"channels", all}});
}

std::string advertise_services(const std::vector<Service>& services) {
  const auto half = [](const Service& service, const char* suffix, const std::string& schema) -> Json {
    return {
        {"encoding", "cdr"}, {"schemaName", service.type + suffix}, {"schemaEncoding", "ros2msg"}, {"schema", schema}};
  };
  Json all = Json::array();
  for (const Service& service : services) {
    all.push_back({{"id", service.id},
                   {"name", service.name},
                   {"type", service.type},
                   {"request", half(service, "_Request", service.request)},
                   {"response", half(service, "_Response", service.response)}});
  }
  return dumped({{"op", "advertiseServices"}, {"services", all}});
}

std::string status(Level level, const std::string& message) {
  return dumped({{"op", "status"}, {"level", static_cast<int>(level)}, {"message", message}});
}

std::string parameter_values(const Json& parameters, const std::optional<std::string>& id) {
  Json json{{"op", "parameterValues"}, {"parameters", parameters}};
  if (id) json["id"] = *id;
  return dumped(json);
}

std::string service_call_failure(std::uint32_t service, std::uint32_t call, const std::string& message) {
  return dumped({{"op", "serviceCallFailure"}, {"serviceId", service}, {"callId", call}, {"message", message}});
}

std::string message_data(std::uint32_t subscription, std::uint64_t unix_ns) {
  std::string out;
  put(out, kMessageData);
  put(out, subscription);
  put(out, unix_ns);
  return out;
}

std::string time(std::uint64_t unix_ns) {
  std::string out;
  put(out, kTime);
  put(out, unix_ns);
  return out;
}

std::string service_response(std::uint32_t service, std::uint32_t call, std::string_view encoding,
                             std::string_view payload) {
  std::string out;
  put(out, kServiceResponse);
  put(out, service);
  put(out, call);
  put(out, static_cast<std::uint32_t>(encoding.size()));
  return out.append(encoding).append(payload);
}

std::string asset(std::uint32_t request) {
  std::string out;
  put(out, kAssetResponse);
  put(out, request);
  put(out, std::uint8_t{0});
  put(out, std::uint32_t{0});
  return out;
}

std::string asset_failure(std::uint32_t request, std::string_view reason) {
  std::string out;
  put(out, kAssetResponse);
  put(out, request);
  put(out, std::uint8_t{1});
  put(out, static_cast<std::uint32_t>(reason.size()));
  return out.append(reason);
}

}  // namespace hecaton::services::foxglove
