#pragma once
/// Decodes the samples of a recording, and encodes those that come from no network. Include the message type's idl
/// header beside this one.

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "services/bus/topics.hpp"

namespace hecaton::bus {

template <class T>
struct DecodedSample {
  std::optional<T> value;     ///< empty: the bytes break a rule of the wire, or are of another schema version
  bool other_schema = false;  ///< they are of another schema version
};

/// The schema version in the first field of each message (common.idl). `bytes`: CDR with its encapsulation; 0: cut off.
[[nodiscard]] std::uint32_t schema_in(std::span<const std::uint8_t> bytes);

/// From CDR with its encapsulation, as RawSample::bytes. For the types of topics.hpp. Thread-safe.
template <class T>
[[nodiscard]] DecodedSample<T> decode_recorded(std::span<const std::uint8_t> bytes);

/// The inverse of decode_recorded(): the bytes that a writer would send. Empty: the sample breaks a rule of the wire.
template <class T>
[[nodiscard]] std::vector<std::uint8_t> encode_recorded(const T& sample);

}  // namespace hecaton::bus
