#pragma once
/// Wakes a service's loop when something happens on the bus. The loop waits on its mailbox, then takes events from it
/// and samples from its readers. Callbacks of the middleware only copy and notify.

#include <array>
#include <chrono>
#include <cstdint>
#include <deque>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

namespace hecaton::bus {

using Clock = std::chrono::steady_clock;

/// Identity of a writer or reader (its GUID). The first 12 bytes are those of its participant.
struct EndpointId {
  std::array<std::uint8_t, 16> bytes{};
  bool operator==(const EndpointId&) const = default;
  bool operator<(const EndpointId& other) const { return bytes < other.bytes; }
  [[nodiscard]] bool same_participant(const EndpointId& other) const;
  [[nodiscard]] std::string text() const;  ///< hexadecimal
};

enum class EventKind : std::uint8_t {
  kPeerMatched,       ///< a matching endpoint of the other direction was found
  kPeerLost,          ///< it left, or the lease of its participant expired
  kDeadlineMissed,    ///< no sample of `key` within the deadline; once until the next sample
  kIncompatible,      ///< an endpoint of this topic was refused for its quality of service; `key` names the policy
  kParticipantFound,  ///< `key` is its name
  kParticipantLost,   ///< it left, or its lease expired; `key` is its name
};

struct Event {
  EventKind kind{};
  std::string_view topic;  ///< TopicInfo::name; empty for participants
  std::string key;
  EndpointId peer;
  Clock::time_point at;  ///< when this process noticed it
};

/// Thread-safe, but wait() and take_events() are for one thread.
class Mailbox {
 public:
  /// Throws std::system_error when the kernel has no descriptor left.
  Mailbox();
  ~Mailbox();
  Mailbox(const Mailbox&) = delete;
  Mailbox& operator=(const Mailbox&) = delete;

  /// Blocks until something has arrived since the last call that returned true, or until the time-out (false). Then
  /// read all events and all readers: what has already been announced does not wake the next call.
  [[nodiscard]] bool wait(Clock::duration timeout);
  /// Wakes the loop. Async-signal-safe.
  void notify();
  /// Readable when wait() would not block; for loops that poll several descriptors.
  [[nodiscard]] int fd() const { return fd_; }
  /// Events since the last call, oldest first. Of more than kCapacity the oldest are dropped.
  [[nodiscard]] std::vector<Event> take_events();
  void post(Event event);

  static constexpr std::size_t kCapacity = 4096;

 private:
  int fd_;
  std::mutex mutex_;
  std::deque<Event> events_;
};

}  // namespace hecaton::bus
