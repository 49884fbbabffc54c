#pragma once
/// Typed writers and readers of the topics in topics.hpp. Include the message type's idl header beside this one. The
/// interface has no callbacks; a Mailbox reports what happens.

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "services/bus/mailbox.hpp"
#include "services/bus/participant.hpp"
#include "services/bus/topics.hpp"

namespace hecaton::bus {

/// Departures of a writer from its topic.
struct WriterOptions {
  Mailbox* mailbox = nullptr;  ///< gets events about readers; must outlive the writer
  /// On a topic with Qos::partition_per_key: the only arm of which it writes. Empty: any arm, which readers of all
  /// arms get.
  std::string key = {};
};

/// True when the middleware has accepted the sample, which does not mean that a reader has received it. Otherwise
/// `reason` is a sentence.
struct [[nodiscard]] WriteResult {
  bool accepted = false;                               ///< by the middleware
  std::string reason;                                  ///< empty if accepted
  explicit operator bool() const { return accepted; }  ///< accepted
};

/// Thread-safe. The participant must outlive the constructor only.
template <class T>
class Writer {
 public:
  /// Throws std::runtime_error with a sentence when the endpoint cannot be created.
  explicit Writer(Participant& participant, const WriterOptions& options = {});
  ~Writer();
  Writer(Writer&&) noexcept;             ///< a writer from which another was moved may only be destroyed
  Writer& operator=(Writer&&) noexcept;  ///< closes the writer that it had

  /// The writer's first refusal is also printed on stderr.
  WriteResult write(const T& sample);
  /// Withdraws the sample's key: readers get it as disposed, late joiners do not get it.
  WriteResult retire(const T& sample);
  /// Readers that join later do not get what was written so far; present readers keep it.
  void clear_history();

  [[nodiscard]] int matched() const;  ///< number of readers
  /// Blocks until so many readers are matched; false after the time-out.
  [[nodiscard]] bool wait_matched(int readers, Clock::duration timeout) const;
  /// Blocks until all matched reliable readers have acknowledged all samples; false after the time-out.
  [[nodiscard]] bool wait_acknowledged(Clock::duration timeout) const;
  [[nodiscard]] EndpointId id() const;  ///< as in Sample::writer
  /// Why each node of the cell would refuse this sample, see wire_rules.hpp; nothing: none would. Costs a
  /// serialisation.
  [[nodiscard]] static std::optional<std::string> refusal_of(const T& sample);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// One received sample.
template <class T>
struct Sample {
  T value;                     ///< default when disposed, see `key`
  std::string key;             ///< as key_of()
  Clock::time_point received;  ///< on this process's monotonic clock; ages count from here
  EndpointId writer;           ///< that sent it
  bool disposed = false;       ///< the key was withdrawn

  /// Since it was received.
  [[nodiscard]] Clock::duration age(Clock::time_point now = Clock::now()) const { return now - received; }
};

/// Departures of a reader from its topic.
struct ReaderOptions {
  std::optional<std::chrono::milliseconds> deadline = {};  ///< instead of the topic's; 0: none
  /// Queue only the newest sample of each key. Default: on best-effort topics, unless writers compete for a key.
  std::optional<bool> conflate = {};
  /// On a topic with Qos::partition_per_key: the only arms of which it receives. Empty: all arms.
  std::vector<std::string> keys = {};
  /// Most samples that wait for take(), and at most 64 MiB of them; the oldest in excess are dropped and counted.
  std::size_t queue = 4096;
};

/// Numbers of samples since the reader was made.
struct ReaderCounters {
  std::uint64_t received = 0;          ///< all, also those that were dropped
  std::uint64_t overflowed = 0;        ///< dropped because the queue was full
  std::uint64_t unreadable = 0;        ///< dropped as malformed or of another schema version
  std::uint64_t refused = 0;           ///< dropped as malformed, of a second writer, or too many samples or keys
  std::uint64_t deadlines_missed = 0;  ///< of living keys, once for each silence
};

/// take() and latest() are for one thread; the rest is thread-safe. The participant must outlive the constructor only.
template <class T>
class Reader {
 public:
  /// Samples and events are announced in `mailbox`, which must outlive the reader, or in a mailbox of its own. Throws
  /// std::runtime_error with a sentence when the endpoint cannot be created.
  explicit Reader(Participant& participant, Mailbox* mailbox = nullptr, const ReaderOptions& options = {});
  ~Reader();
  Reader(Reader&&) noexcept;             ///< a reader from which another was moved may only be destroyed
  Reader& operator=(Reader&&) noexcept;  ///< closes the reader that it had

  /// Samples by their key.
  using Latest = std::map<std::string, Sample<T>, std::less<>>;

  /// The samples that have arrived since the last take() or latest(), oldest first. Never blocks.
  [[nodiscard]] std::vector<Sample<T>> take();
  /// The newest sample of each key that is not disposed, however old. Of more keys than Qos::instances, those of
  /// participants that have left are withdrawn first, then those of the participant with the most. Consumes what take()
  /// would return. Valid until the next call of take() or latest().
  [[nodiscard]] const Latest& latest();
  /// The newest sample of one key, or null. Valid as above.
  [[nodiscard]] const Sample<T>* latest(std::string_view key);

  /// Blocks on the mailbox until something arrives, for any of its readers; false after the time-out.
  [[nodiscard]] bool wait_for_data(Clock::duration timeout);
  [[nodiscard]] Mailbox& mailbox();  ///< the given one, or its own

  [[nodiscard]] int matched() const;  ///< number of writers
  /// Blocks until so many writers are matched; false after the time-out.
  [[nodiscard]] bool wait_matched(int writers, Clock::duration timeout) const;
  [[nodiscard]] ReaderCounters counters() const;  ///< a copy of now

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace hecaton::bus
