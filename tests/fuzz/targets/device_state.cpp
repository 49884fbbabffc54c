// A serialised state of a device program: the wire's check, the decoder, and what the device relies on.

#include <cmath>

#include <idl/device.h>

#include "services/bus/recorded_sample.hpp"
#include "services/bus/topics.hpp"
#include "services/bus/wire_rules.hpp"
#include "tests/fuzz/fuzz.hpp"

extern "C" int HECATON_FUZZ_TARGET(device_state)(const std::uint8_t* data, std::size_t size) {
  using namespace hecaton;
  const fuzz::View bytes(data, size);
  const bus::TopicRule& rule = *bus::topic_rule(bus::Topic<msg::DeviceState>::kInfo.type);
  const bus::CheckedSample checked = bus::check_sample(rule, bytes);
  const auto decoded = bus::decode_recorded<msg::DeviceState>(bytes);
  if (checked.other_schema || checked.refusal) {
    if (checked.refusal) fuzz::require_sentence(*checked.refusal);
    fuzz::require(!decoded.value, "what the check refuses is not decoded");
    return 0;
  }
  fuzz::require(decoded.value.has_value(), "what the check accepts can be decoded");
  const msg::DeviceState& state = *decoded.value;
  for (const auto* values : {&state.q(), &state.qd()}) {
    fuzz::require(values->size() <= msg::MAX_JOINTS, "an arm has few joints");
    for (const double value : *values) fuzz::require(std::isfinite(value), "a measured state is finite");
  }
  fuzz::require(state.speed_scaling() >= 0.0 && state.speed_scaling() <= 1.0, "a speed scaling is a share");
  fuzz::require(state.age() >= 0.0 && state.tracking_delay() >= 0.0, "ages and delays are no negative times");
  fuzz::require(state.mode() <= msg::DeviceMode::DEVICE_FAILED, "a mode is one of the enumeration");
  fuzz::require(!bus::unprintable(state.text()) && !bus::unprintable(state.arm()), "texts are printable");
  return 0;
}
