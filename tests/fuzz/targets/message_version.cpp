// A message with the structure that its recording states for it. The first byte chooses the topic; the text of the
// structure follows, up to a byte 0; the rest is the message.

#include <algorithm>

#include <idl/common.h>

#include "services/bus/recorded_sample.hpp"
#include "services/recorder/cdr_columns.hpp"
#include "services/recorder/current_messages.hpp"
#include "tests/fuzz/fuzz.hpp"

extern "C" int HECATON_FUZZ_TARGET(message_version)(const std::uint8_t* data, std::size_t size) {
  using namespace hecaton;
  using namespace hecaton::services;
  fuzz::Input input(data, size);
  const bus::TopicInfo& topic = bus::kTopics[input.byte() % bus::kTopics.size()];
  const fuzz::View rest = input.rest();
  const auto end = static_cast<std::size_t>(std::find(rest.begin(), rest.end(), 0) - rest.begin());
  recorder::McapSchema schema{"hecaton::msg::" + std::string(topic.type), "omgidl", fuzz::text_of(rest.first(end))};
  recorder::McapChannel channel{std::string(topic.name), "cdr", {}, std::make_shared<recorder::McapSchema>(schema)};
  recorder::McapMessage message;
  message.channel = std::make_shared<recorder::McapChannel>(channel);
  message.data = rest.subspan(std::min(end + 1, rest.size()));
  recorder::CurrentMessages current;
  const bus::TopicRule& rule = *bus::topic_rule(topic.type);
  for (int i = 0; i < 2; ++i) {  // a conversion keeps its buffer
    const recorder::CurrentMessage converted = current.of(message);
    if (!converted.refusal.empty()) {
      fuzz::require_sentence(converted.refusal);
      fuzz::require(converted.data.empty(), "a refused message has no bytes");
      continue;
    }
    const bool same = converted.data.data() == message.data.data();
    fuzz::require(same || converted.data.size() <= rule.most_bytes,
                  "a converted message is no longer than its topic allows");
    fuzz::require(same || bus::schema_in(converted.data) == msg::SCHEMA_VERSION, "it has the version of this program");
    recorder::CdrColumns columns(rule);
    if (!columns.measure(converted.data)) static_cast<void>(columns.row(converted.data));
  }
  for (const std::string& note : current.notes()) fuzz::require_sentence(note);
  return 0;
}
