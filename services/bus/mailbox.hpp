#pragma once
/// Where everything that happens on the bus ends up for one service loop: it blocks until something arrives, then reads
/// events here and samples from its readers. Callbacks of the middleware only copy and notify.

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

/// Identity of a writer or reader: the first 12 bytes are its participant's.
struct EndpointId {
  std::array<std::uint8_t, 16> bytes{};
  bool operator==(const EndpointId&) const = default;
  bool operator<(const EndpointId& other) const { return bytes < other.bytes; }
  [[nodiscard]] bool same_participant(const EndpointId& other) const;
  [[nodiscard]] std::string text() const;  ///< hexadecimal
};

enum class EventKind : std::uint8_t {
  kPeerMatched,       ///< an endpoint of the other direction was found
  kPeerLost,          ///< it left, or its participant's lease ran out
  kDeadlineMissed,    ///< no sample of `key` for the deadline; told once until the next sample
  kLivelinessLost,    ///< `peer` wrote nothing for its lease; `key` is one that it wrote
  kLivelinessGained,  ///< it writes again
  kIncompatible,      ///< an endpoint of this topic was refused for its quality of service: `key` names the policy
  kParticipantFound,  ///< `key` is its name
  kParticipantLost,   ///< left or its lease ran out; `key` is its name
};

struct Event {
  EventKind kind{};
  std::string_view topic;  ///< as in the table; empty for participants
  std::string key;
  EndpointId peer;
  Clock::time_point at;  ///< when this process noticed
};

class Mailbox {
 public:
  /// Throws std::system_error when the kernel has no descriptor left.
  Mailbox();
  ~Mailbox();
  Mailbox(const Mailbox&) = delete;
  Mailbox& operator=(const Mailbox&) = delete;

  /// Blocks until something has arrived since the last call that returned true, or the time-out. Afterwards read all
  /// events and all readers: what arrived meanwhile does not wake the next call if it was announced before.
  [[nodiscard]] bool wait(Clock::duration timeout);
  /// Wakes the loop. Safe in a signal handler.
  void notify();
  /// Readable when wait() would not block; for loops that poll other descriptors, too.
  [[nodiscard]] int fd() const { return fd_; }
  /// Events since the last call, oldest first; at most kCapacity, of which the oldest are dropped.
  [[nodiscard]] std::vector<Event> take_events();
  void post(Event event);

  static constexpr std::size_t kCapacity = 4096;

 private:
  int fd_;
  std::mutex mutex_;
  std::deque<Event> events_;
};

}  // namespace hecaton::bus
