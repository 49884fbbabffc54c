#include "services/replay/message_feeder.hpp"

#include <charconv>
#include <cstring>
#include <optional>
#include <string_view>
#include <type_traits>
#include <utility>

#include <nlohmann/json.hpp>

#include "services/bus/recorded_sample.hpp"
#include "services/recorder/recording.hpp"

namespace hecaton::services::replay {
namespace {

using recorder::ByteSpan;
using recorder::McapChannel;
using recorder::McapMessage;

std::string_view metadata(const McapChannel& channel, const char* key) {
  const auto found = channel.metadata.find(key);
  return found == channel.metadata.end() ? std::string_view() : std::string_view(found->second);
}

/// The inverse of EndpointId::text(); zeros for anything else: an unknown writer.
bus::EndpointId endpoint_of(std::string_view text) {
  bus::EndpointId id;
  if (text.size() != 2 * id.bytes.size()) return {};
  for (std::size_t i = 0; i < id.bytes.size(); ++i) {
    const char* digits = text.data() + 2 * i;
    if (std::from_chars(digits, digits + 2, id.bytes[i], 16).ptr != digits + 2) return {};
  }
  return id;
}

}  // namespace

bool is_repeated(const McapChannel& channel) {
  return metadata(channel, "repeated") == "true";
}

bool is_of_cell(const McapChannel& channel) {
  return channel.schema != nullptr;
}

std::optional<std::string_view> key_in(ByteSpan bytes) {
  // The key is the first field behind `schema`: a length and a text with a 0 at its end.
  constexpr std::size_t kLength = 8;
  constexpr std::size_t kText = 12;
  if (bytes.size() < kText || bytes[1] != 1) return std::nullopt;
  std::uint32_t size = 0;
  for (std::size_t i = 0; i < 4; ++i) size |= static_cast<std::uint32_t>(bytes[kLength + i]) << (8 * i);
  if (size == 0 || size > bytes.size() - kText) return std::nullopt;
  return std::string_view(reinterpret_cast<const char*>(bytes.data()) + kText, size - 1);
}

const MessageFeeder::Role& MessageFeeder::role_of(const std::shared_ptr<const McapChannel>& described) {
  const auto [known, first] = roles_.try_emplace(described);
  if (!first) return known->second;
  const McapChannel& channel = *described;
  static const std::map<std::string_view, Topic> kTopics{
      {bus::Topic<msg::ArmState>::kInfo.name, Topic::kArmState},
      {bus::Topic<msg::Heartbeat>::kInfo.name, Topic::kHeartbeat},
      {bus::Topic<msg::ObstacleStates>::kInfo.name, Topic::kObstacleStates},
      {bus::Topic<msg::ContactReport>::kInfo.name, Topic::kContactReport},
      {bus::Topic<msg::GoalStatus>::kInfo.name, Topic::kGoalStatus},
      {bus::Topic<msg::ToolState>::kInfo.name, Topic::kToolState},
      {bus::Topic<msg::PlannedMotion>::kInfo.name, Topic::kPlannedMotion},
      {bus::Topic<msg::ObstacleShapes>::kInfo.name, Topic::kObstacleShapes},
      {bus::Topic<msg::Fault>::kInfo.name, Topic::kFault},
      {bus::Topic<msg::CellMode>::kInfo.name, Topic::kCellMode},
      {recorder::Recording::kWithdrawn, Topic::kWithdrawn}};
  const auto topic = kTopics.find(channel.topic);
  const bool readable = channel.encoding == (channel.schema ? "cdr" : "json");
  if (topic != kTopics.end() && readable) known->second = {topic->second, endpoint_of(metadata(channel, "writer"))};
  return known->second;
}

void MessageFeeder::take(const McapMessage& message) {
  const Role& role = role_of(message.channel);
  if (role.topic == Topic::kOther) return;
  if (role.topic == Topic::kWithdrawn) return withdraw(message.data, time_of(message));
  const recorder::CurrentMessage current = current_.of(message);
  if (!current.refusal.empty()) return refuse(current.refusal);
  switch (role.topic) {
    case Topic::kArmState:
    case Topic::kPlannedMotion:
    case Topic::kHeartbeat:
    case Topic::kObstacleStates:
    case Topic::kContactReport:
      if (defer(role, current.data, time_of(message))) return;
      break;
    default:
      break;
  }
  decode(role.topic, current.data, time_of(message), role.writer);
}

void MessageFeeder::refuse(const std::string& sentence) {
  const auto known = undecoded_.refused.find(sentence);
  if (known != undecoded_.refused.end()) {
    ++known->second;
  } else if (undecoded_.refused.size() < UndecodedMessages::kMostRefusals) {
    undecoded_.refused.emplace(sentence, 1);
  }
}

bool MessageFeeder::defer(const Role& role, ByteSpan data, bus::Clock::time_point received) {
  const bool keyed = role.topic != Topic::kObstacleStates && role.topic != Topic::kContactReport;
  const auto key = keyed ? key_in(data) : std::optional<std::string_view>("");
  if (!key) return false;
  key_.assign(1, static_cast<char>(role.topic)).append(*key);
  auto waiting = waiting_.find(key_);
  if (waiting == waiting_.end()) waiting = waiting_.emplace(key_, Waiting()).first;
  waiting->second.topic = role.topic;
  waiting->second.data.assign(data.begin(), data.end());
  waiting->second.received = received;
  waiting->second.writer = role.writer;
  waiting->second.waits = true;
  return true;
}

void MessageFeeder::flush() {
  for (auto& [key, message] : waiting_) {
    if (!std::exchange(message.waits, false)) continue;
    decode(message.topic, message.data, message.received, message.writer);
  }
}

void MessageFeeder::drop() {
  for (auto& [key, message] : waiting_) message.waits = false;
}

void MessageFeeder::decode(Topic topic, ByteSpan data, bus::Clock::time_point received, const bus::EndpointId& writer) {
  switch (topic) {
    case Topic::kArmState:
      return apply<msg::ArmState>(data, received, writer);
    case Topic::kHeartbeat:
      return apply<msg::Heartbeat>(data, received, writer);
    case Topic::kObstacleStates:
      return apply<msg::ObstacleStates>(data, received, writer);
    case Topic::kContactReport:
      return apply<msg::ContactReport>(data, received, writer);
    case Topic::kGoalStatus:
      return apply<msg::GoalStatus>(data, received, writer);
    case Topic::kToolState:
      return apply<msg::ToolState>(data, received, writer);
    case Topic::kPlannedMotion:
      return apply<msg::PlannedMotion>(data, received, writer);
    case Topic::kObstacleShapes:
      return apply<msg::ObstacleShapes>(data, received, writer);
    case Topic::kFault:
      return apply<msg::Fault>(data, received, writer);
    case Topic::kCellMode:
      return apply<msg::CellMode>(data, received, writer);
    case Topic::kOther:
    case Topic::kWithdrawn:
      return;
  }
}

template <class T>
void MessageFeeder::apply(ByteSpan data, bus::Clock::time_point received, const bus::EndpointId& writer) {
  bus::DecodedSample<T> decoded = bus::decode_recorded<T>(data);
  if (!decoded.value) {
    ++undecoded_.broken;
    return;
  }
  ++decoded_;
  bus::Sample<T> sample{std::move(*decoded.value), {}, received, writer};
  sample.key = bus::key_of(sample.value);
  state_.apply(sample);
  if (marks_ == nullptr) return;
  if constexpr (std::is_same_v<T, msg::CellMode>) {
    marks_->take_mode(state_.mode().mode(), received);
  } else if constexpr (std::is_same_v<T, msg::Fault> || std::is_same_v<T, msg::GoalStatus>) {
    marks_->take(sample);
  }
}

void MessageFeeder::withdraw(ByteSpan text, bus::Clock::time_point received) {
  const auto json = nlohmann::json::parse(text.begin(), text.end(), nullptr, false);
  if (!json.is_object()) return;
  const auto string = [&](const char* field) {
    const auto found = json.find(field);
    return found != json.end() && found->is_string() ? found->get<std::string>() : std::string();
  };
  const std::string topic = string("topic");
  const auto dispose = [&](auto sample) {
    sample.key = string("key");
    sample.received = received;
    sample.disposed = true;
    state_.apply(sample);
  };
  const auto drop_waiting = [&](Topic kind) {
    const auto waiting = waiting_.find(static_cast<char>(kind) + string("key"));
    if (waiting != waiting_.end()) waiting->second.waits = false;
  };
  if (topic == bus::Topic<msg::ArmState>::kInfo.name) {
    drop_waiting(Topic::kArmState);
    dispose(bus::Sample<msg::ArmState>());
  } else if (topic == bus::Topic<msg::Heartbeat>::kInfo.name) {
    drop_waiting(Topic::kHeartbeat);
    dispose(bus::Sample<msg::Heartbeat>());
  } else if (topic == bus::Topic<msg::PlannedMotion>::kInfo.name) {
    drop_waiting(Topic::kPlannedMotion);
    dispose(bus::Sample<msg::PlannedMotion>());
  } else if (topic == bus::Topic<msg::ToolState>::kInfo.name) {
    dispose(bus::Sample<msg::ToolState>());
  } else if (topic == bus::Topic<msg::ObstacleShapes>::kInfo.name) {
    dispose(bus::Sample<msg::ObstacleShapes>());
  } else if (topic == bus::Topic<msg::Fault>::kInfo.name) {
    dispose(bus::Sample<msg::Fault>());
  }
}

}  // namespace hecaton::services::replay
