#pragma once
/// Reads all topics of topics.hpp as serialised samples, for a recorder. Each sample passes the checks of a typed
/// Reader first: the rules of the wire, the schema version, rates, terms, and second writers.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "services/bus/mailbox.hpp"
#include "services/bus/participant.hpp"
#include "services/bus/topics.hpp"

namespace hecaton::bus {

/// A sample as it came from the network.
struct RawSample {
  std::size_t topic = 0;                         ///< index in kTopics
  std::vector<std::uint8_t> bytes;               ///< CDR with its encapsulation; empty when withdrawn
  std::string key;                               ///< as key_of()
  EndpointId writer;                             ///< that sent it
  std::uint64_t number = 0;                      ///< of the sample at its writer, from 1
  std::optional<std::uint64_t> sequence_number;  ///< the message's field; empty: it has none
  std::int64_t written_ns = 0;                   ///< since 1970 on the writer's clock; 0: the writer does not tell
  Clock::time_point received;
  bool withdrawn = false;  ///< the writer has retired the key
};

/// Numbers of samples of one topic since the readers were made.
struct RawCounters {
  std::uint64_t received = 0;    ///< passed all checks
  std::uint64_t refused = 0;     ///< break a rule of the wire, come too fast, or come from a second writer
  std::uint64_t unreadable = 0;  ///< refused as well: malformed or of another schema version
  std::uint64_t overflowed = 0;  ///< dropped because take() was not called in time
  std::uint64_t lost = 0;        ///< reported by the middleware as lost on the way
};

/// take() is for one thread; the rest is thread-safe. The participant must not have a typed Reader or Writer.
/// Best-effort topics keep kDepth samples of each key until they are queued.
class RawReaders {
 public:
  static constexpr int kDepth = 64;

  /// Joins every topic. `mailbox` must outlive the readers. At most `most_bytes` wait for take(); samples in excess are
  /// dropped and counted. Throws std::runtime_error with a sentence when an endpoint cannot be created.
  RawReaders(Participant& participant, Mailbox& mailbox, std::size_t most_bytes);
  ~RawReaders();
  RawReaders(const RawReaders&) = delete;
  RawReaders& operator=(const RawReaders&) = delete;

  /// The samples since the last call, in order of arrival. Never blocks.
  [[nodiscard]] std::vector<RawSample> take();
  [[nodiscard]] std::vector<RawCounters> counters() const;  ///< one for each topic of kTopics
  [[nodiscard]] int matched() const;                        ///< number of writers of all topics

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace hecaton::bus
