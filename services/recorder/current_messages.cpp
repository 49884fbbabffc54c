#include "services/recorder/current_messages.hpp"

#include <algorithm>

#include <idl/common.h>

#include "services/bus/recorded_sample.hpp"
#include "services/bus/wire_rules.hpp"
#include "services/recorder/message_schema.hpp"

namespace hecaton::services::recorder {
namespace {

constexpr std::string_view kMessageNamespace = "hecaton::msg::";
constexpr std::string_view kAdvice = "; use the Hecaton that recorded it";

/// The type of the messages of a channel, without its namespace; empty: they are none of Hecaton's.
std::string_view message_type_of(const McapChannel& channel) {
  if (channel.encoding != "cdr" || !channel.schema) return {};
  const std::string_view name = channel.schema->name;
  if (!name.starts_with(kMessageNamespace)) return {};
  const std::string_view type = name.substr(kMessageNamespace.size());
  return bus::topic_rule(type) == nullptr ? std::string_view() : type;
}

/// "A.b, C.d and 3 more"; at most a few.
template <class Names>
std::string list_of(const Names& names) {
  constexpr std::size_t kMost = 5;
  std::string list;
  std::size_t listed = 0;
  for (const std::string& name : names) {
    if (listed == kMost) return list + " and " + std::to_string(names.size() - kMost) + " more";
    list += (listed++ == 0 ? "" : ", ") + name;
  }
  return list;
}

/// Of a conversion; empty: nothing is lacking.
std::string lack_of(const MessageConversion& conversion, std::uint32_t version) {
  const std::string begin = "version " + std::to_string(version);
  if (!conversion.added().empty()) return begin + " lacks " + list_of(conversion.added());
  if (!conversion.removed().empty()) return begin + " has " + list_of(conversion.removed()) + " in addition";
  return {};
}

}  // namespace

CurrentMessage CurrentMessages::of(const McapMessage& message) {
  constexpr std::size_t kVersionEnd = 8;  // the version is the first field of each message
  Track* track = track_of(message.channel);
  if (track == nullptr || message.data.size() < kVersionEnd) return {message.data, {}, {}};
  const std::uint32_t version = bus::schema_in(message.data);
  if (version == msg::SCHEMA_VERSION && track->version != version) return {message.data, {}, {}};
  const auto refuse = [&](const std::string& phrase) {
    return CurrentMessage{{}, bus::printable(message.channel->topic, bus::kLongestName) + ": " + phrase, {}};
  };
  const std::string of_version = "its messages have version " + std::to_string(version);
  if (!track->version) {
    return refuse(of_version + ", and their structure in the file cannot be read: " + track->refusal +
                  std::string(kAdvice));
  }
  if (track->version != version) {
    return refuse(of_version + ", and their structure in the file has version " + std::to_string(*track->version));
  }
  if (!track->refusal.empty()) return refuse(track->refusal + std::string(kAdvice));
  if (!track->conversion) return {message.data, {}, {}};
  try {
    const ByteSpan data = track->conversion->convert(message.data);
    note(*track);
    return {data, {}, track->lack};
  } catch (const ConversionError& error) {
    return refuse("field " + std::string(error.what()));
  }
}

CurrentMessages::Track* CurrentMessages::track_of(const std::shared_ptr<const McapChannel>& channel) {
  const auto [known, first] = channels_.try_emplace(channel);
  if (!first) return known->second;
  const std::string_view type = message_type_of(*channel);
  if (type.empty()) return nullptr;
  std::pair<std::string, std::string> key(type, channel->schema->data);
  auto track = tracks_.find(key);
  if (track == tracks_.end()) {
    if (tracks_.size() >= kMostTexts) return nullptr;
    Track made = make_track(type, key.second);
    track = tracks_.emplace(std::move(key), std::move(made)).first;
  }
  return known->second = &track->second;
}

CurrentMessages::Track CurrentMessages::make_track(std::string_view type, std::string_view text) {
  Track track;
  const std::string_view current = message_schema(type);
  if (text == current) {
    track.version = msg::SCHEMA_VERSION;
    return track;
  }
  try {
    track.from = std::make_unique<IdlTypes>(text);
    const IdlType* from = track.from->structure(type);
    const auto version = track.from->constant("SCHEMA_VERSION");
    if (from == nullptr) throw IdlError("it has no structure " + std::string(type));
    if (!version) throw IdlError("it has no constant SCHEMA_VERSION");
    track.to = std::make_unique<IdlTypes>(current);
    track.version = static_cast<std::uint32_t>(*version);
    const bus::TopicRule& rule = *bus::topic_rule(type);
    track.conversion = std::make_unique<MessageConversion>(*from, *track.to->structure(type), rule.most_bytes);
    track.lack = lack_of(*track.conversion, *track.version);
    if (track.version == msg::SCHEMA_VERSION && track.conversion->is_same()) track.conversion.reset();
  } catch (const IdlError& error) {
    track.refusal = error.what();
  } catch (const ConversionError& error) {
    track.refusal = "field " + std::string(error.what());
  }
  return track;
}

void CurrentMessages::note(Track& track) {
  if (track.noted) return;
  track.noted = true;
  versions_.insert(*track.version);
  added_.insert(track.conversion->added().begin(), track.conversion->added().end());
  removed_.insert(track.conversion->removed().begin(), track.conversion->removed().end());
}

std::vector<std::string> CurrentMessages::notes() const {
  std::vector<std::string> notes;
  for (const std::uint32_t version : versions_) {
    notes.push_back("messages of version " + std::to_string(version) + " are converted to version " +
                    std::to_string(msg::SCHEMA_VERSION) + " of this program");
  }
  if (!added_.empty()) notes.push_back("fields that they lack have their defaults: " + list_of(added_));
  if (!removed_.empty()) {
    notes.push_back("fields that this program does not know are left out: " + list_of(removed_));
  }
  return notes;
}

}  // namespace hecaton::services::recorder
