#pragma once
/// Binds each key of a topic to the participant that writes it. Private to services/bus; standard library only.
///
/// A participant holds a key from its first sample until it has been silent on the key for the topic's `hold`. Samples
/// of another participant are refused meanwhile. A successor of a process that has ended waits for `hold` at most,
/// which is shorter than the start of a process.

#include <chrono>
#include <cstdint>
#include <optional>
#include <utility>

#include "services/bus/mailbox.hpp"

namespace hecaton::bus {

/// Of one key. For one thread.
class StreamHolder {
 public:
  /// A sample arrived at `now`. Returns false when another participant holds the key.
  [[nodiscard]] bool admits(const EndpointId& writer, Clock::time_point now, Clock::duration hold) {
    const bool free = !holder_ || now - heard_ > hold;
    if (!free && !holder_->same_participant(writer)) {
      challenger_ = writer;
      return false;
    }
    if (free && holder_ && !holder_->same_participant(writer)) challenger_.reset();  // a successor
    holder_ = writer;
    heard_ = now;
    return true;
  }
  /// The participant whose samples were refused since the last call, once the holder has written again: both write at
  /// one time. A successor that came early is none.
  [[nodiscard]] std::optional<EndpointId> take_challenger() { return std::exchange(challenger_, std::nullopt); }
  [[nodiscard]] const std::optional<EndpointId>& holder() const { return holder_; }

 private:
  std::optional<EndpointId> holder_;
  std::optional<EndpointId> challenger_;
  Clock::time_point heard_;
};

/// Notices that two participants write one key at a time, where terms or a supervisor decide between them and no sample
/// is refused. A change of the writer alone is a failover. A supervisor that hears no other host goes on writing under
/// its term until it hears its successor. It is no second writer either, because every reader follows the higher term.
class WriterChanges {
 public:
  static constexpr int kMany = 12;                   ///< changes between two writers that are no failover
  static constexpr std::chrono::seconds kWindow{1};  ///< without a pause this long

  /// `term`: by which readers choose between the writers; 0 where they choose otherwise. True when the key has had many
  /// changes of its writer.
  [[nodiscard]] bool note(const EndpointId& writer, std::uint64_t term, Clock::time_point now) {
    if (term < term_ && replaced_ && replaced_->same_participant(writer)) return false;
    if (now - changed_ > kWindow) changes_ = 0;
    const bool changed = last_ && !last_->same_participant(writer);
    if (changed) {
      ++changes_;
      changed_ = now;
    }
    if (term > term_) {
      if (changed) replaced_ = last_;
      term_ = term;
    }
    last_ = writer;
    return changes_ >= kMany;
  }

 private:
  std::optional<EndpointId> last_;
  std::optional<EndpointId> replaced_;  ///< wrote last under the term before
  std::uint64_t term_ = 0;              ///< the highest one
  Clock::time_point changed_;
  int changes_ = 0;
};

/// Counts samples of one writer in windows of a second. For one thread.
class SampleRate {
 public:
  /// True while the writer has sent at most `most` samples in this window. `most` 0: no limit.
  [[nodiscard]] bool admits(Clock::time_point now, std::uint32_t most) {
    if (now - began_ > std::chrono::seconds(1)) {
      began_ = now;
      count_ = 0;
    }
    return ++count_ <= most || most == 0;
  }

 private:
  Clock::time_point began_;
  std::uint32_t count_ = 0;
};

}  // namespace hecaton::bus
