#pragma once
/// Typed writers and readers of the topics in topics.hpp. Only those types exist; include their idl/*.h beside this.
/// No endpoint may be made or destroyed inside a callback; there are none in this interface.

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

struct WriterOptions {
  int strength = 0;                                   ///< on exclusive topics the strongest living writer is heard
  std::optional<std::chrono::milliseconds> deadline;  ///< instead of the table's
  std::optional<std::chrono::milliseconds> lease;     ///< instead of the table's
  Mailbox* mailbox = nullptr;                         ///< told about readers; must outlive the writer
};

/// True when the middleware took the sample (not: when somebody received it); otherwise a sentence says why not.
struct [[nodiscard]] WriteResult {
  bool accepted = false;
  std::string reason;
  explicit operator bool() const { return accepted; }
};

template <class T>
class Writer {
 public:
  /// Throws std::runtime_error with a sentence when the endpoint cannot be made.
  explicit Writer(Participant& participant, const WriterOptions& options = {});
  ~Writer();
  Writer(Writer&&) noexcept;
  Writer& operator=(Writer&&) noexcept;

  /// Thread-safe. Refusals are also logged on stderr, the first of each kind.
  WriteResult write(const T& sample);
  /// Withdraws the sample's key: readers see it disposed, late joiners not at all.
  WriteResult retire(const T& sample);
  /// Who joins from now on gets nothing of what was written so far; readers keep what they have.
  void forget();

  [[nodiscard]] int matched() const;
  [[nodiscard]] bool wait_matched(int readers, Clock::duration timeout) const;
  /// Blocks until all matched reliable readers have acknowledged everything written.
  [[nodiscard]] bool wait_acknowledged(Clock::duration timeout) const;
  void set_strength(int strength);
  [[nodiscard]] EndpointId id() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// One received sample.
template <class T>
struct Sample {
  T value;                     ///< when disposed: without contents, see `key`
  std::string key;             ///< as key_of()
  Clock::time_point received;  ///< on this process's monotonic clock: ages are measured from here
  EndpointId writer;
  bool disposed = false;  ///< the key was withdrawn

  [[nodiscard]] Clock::duration age(Clock::time_point now = Clock::now()) const { return now - received; }
};

struct ReaderOptions {
  std::optional<std::chrono::milliseconds> deadline;  ///< instead of the table's; not below the writers'; 0: none
  /// Queue only the newest sample of each key. Default: on best-effort topics.
  std::optional<bool> conflate;
  std::size_t queue = 4096;  ///< samples that wait for take(); beyond, the oldest are dropped and counted
};

struct ReaderCounters {
  std::uint64_t received = 0;
  std::uint64_t overflowed = 0;        ///< dropped because nobody took them
  std::uint64_t unreadable = 0;        ///< malformed or of another schema version: dropped
  std::uint64_t deadlines_missed = 0;  ///< silences of living keys
  std::uint64_t liveliness_lost = 0;
};

template <class T>
class Reader {
 public:
  /// Everything that happens is announced in `mailbox`, which must outlive the reader; without, in one of its own.
  /// Throws std::runtime_error with a sentence when the endpoint cannot be made.
  explicit Reader(Participant& participant, Mailbox* mailbox = nullptr, const ReaderOptions& options = {});
  ~Reader();
  Reader(Reader&&) noexcept;
  Reader& operator=(Reader&&) noexcept;

  using Latest = std::map<std::string, Sample<T>, std::less<>>;

  /// What has arrived since the last take() or latest(), oldest first. Never blocks.
  [[nodiscard]] std::vector<Sample<T>> take();
  /// The newest sample of each key that is not disposed, however long ago; consumes what take() would have returned.
  /// Valid until the next call of take() or latest(); like take(), for one thread.
  [[nodiscard]] const Latest& latest();
  /// The newest sample of one key, or null.
  [[nodiscard]] const Sample<T>* latest(std::string_view key);

  /// Blocks on the mailbox until something arrives (for whomever, when the mailbox is shared) or the time-out.
  [[nodiscard]] bool wait_for_data(Clock::duration timeout);
  [[nodiscard]] Mailbox& mailbox();

  [[nodiscard]] int matched() const;
  [[nodiscard]] bool wait_matched(int writers, Clock::duration timeout) const;
  [[nodiscard]] int alive_writers() const;  ///< matched ones whose lease is running
  [[nodiscard]] ReaderCounters counters() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace hecaton::bus
