// Datagrams of an ABB controller (EGM), each behind its length in a byte.

#include <cmath>

#include "services/arm_driver/devices/abb_egm/messages.hpp"
#include "tests/fuzz/fuzz.hpp"

extern "C" int HECATON_FUZZ_TARGET(abb_egm)(const std::uint8_t* data, std::size_t size) {
  using namespace hecaton;
  using namespace hecaton::device::abb_egm;
  const auto message = decode(fuzz::text_of({data, size}));
  if (!message) return 0;
  for (const JointValues* joints : {&message->joints, &message->external}) {
    fuzz::require(joints->count <= kMostJoints, "a message has six joints at most");
    for (const double value : joints->get()) fuzz::require(std::isfinite(value), "measured positions are finite");
  }
  SensorBuffer buffer;
  const SensorMessage answer{message->sequence_number, message->sent_ms, message->joints, message->external};
  const std::string_view bytes = encode(answer, buffer);
  fuzz::require(bytes.size() <= kLargestSensorMessage, "an answer fits into its buffer");
  return 0;
}
