// A serialised sample of a topic and the wire's check alone: `samples` without decoder and services, for
// `./run fuzz --brief`. The first byte chooses the topic.

#include "services/bus/topics.hpp"
#include "services/bus/wire_rules.hpp"
#include "tests/fuzz/fuzz.hpp"

extern "C" int HECATON_FUZZ_TARGET(wire)(const std::uint8_t* data, std::size_t size) {
  using namespace hecaton;
  fuzz::Input input(data, size);
  const bus::TopicInfo& topic = bus::kTopics[input.byte() % bus::kTopics.size()];
  const bus::CheckedSample checked = bus::check_sample(*bus::topic_rule(topic.type), input.rest());
  fuzz::require(!checked.other_schema || !checked.refusal, "a sample of another schema is not judged");
  if (checked.refusal) fuzz::require_sentence(*checked.refusal);
  return 0;
}
