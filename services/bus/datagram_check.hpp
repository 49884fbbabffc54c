#pragma once
/// Recognises RTPS datagrams that would harm the middleware. Private to services/bus; standard library only.
///
/// Fast DDS 2.9.1 handles each number of a range on its own. A datagram of 52 bytes takes a receiving thread for
/// seconds or for ever: with a GAP over 2·10⁹ samples, or a HEARTBEAT that lists 2³² of them or begins with 2⁶². Fast
/// DDS takes memory for the size that the first fragment of a sample announces. A sequence number that leaps makes a
/// reader ignore all later samples of that writer. It takes what discovery says of a participant or endpoint from any
/// sender. So the transport checks senders, ranges, sizes and leaps before the middleware sees a datagram.

#include <array>
#include <cstdint>
#include <mutex>
#include <optional>
#include <span>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "services/bus/mailbox.hpp"
#include "services/bus/participant_sources.hpp"

namespace hecaton::bus {

/// The last stall of one receiving thread. What a full receive buffer does not hold meanwhile is lost; the rest arrives
/// at once.
class ReceptionStall {
 public:
  /// A longer time between two reads is a stall. A cell at work leaves no such gap.
  static constexpr std::chrono::milliseconds kStall{50};

  /// Call it at each read.
  void read(Clock::time_point now) {
    if (last_ && now - *last_ > kStall) ended_ = now;
    last_ = now;
  }
  /// Nothing: the thread has not stalled yet.
  [[nodiscard]] std::optional<Clock::time_point> ended() const { return ended_; }

 private:
  std::optional<Clock::time_point> last_;
  std::optional<Clock::time_point> ended_;
};

/// Thread-safe. Its memory is bounded by kWriters and by the participants of ParticipantSources.
class DatagramCheck {
 public:
  using Prefix = ParticipantSources::Prefix;  ///< of a participant's GUID
  using Address = ParticipantSources::Address;

  /// Most samples that one GAP may skip beyond those that the writer has sent. Fast DDS takes 0.1 s for so many.
  static constexpr std::int64_t kMostSkipped = 1 << 17;
  /// A sequence number may exceed the last one of its writer by this, and by twice what the writer sends in the time
  /// since. An intruder that forges such a number hides a stream of 100 Hz for 0.64 s.
  static constexpr std::int64_t kLeap = 1 << 6;
  /// The average of a writer that sends rarely, or is new [1/s]: it may send many samples at once.
  static constexpr double kBurst = 500.0;
  /// The same after a silence of the writer of kPause.
  static constexpr std::int64_t kLeapAfterPause = 1 << 20;
  static constexpr std::chrono::milliseconds kPause{1000};
  /// Within this time after a stall of the receiving thread, numbers may also exceed the last one before the stall by
  /// kLeap and twice what the writer sends since then. Reads come back to back, but the buffer has lost samples.
  static constexpr std::chrono::milliseconds kBacklog{1000};
  /// Stalls that follow one another within kBacklog count as one for this long.
  static constexpr std::chrono::seconds kLongestBacklog{5};
  /// A late joiner receives old samples before the newest ones: within this time a new writer may leap up to kFirst.
  static constexpr std::chrono::seconds kSettling{2};
  /// The first number of a writer: a stream of 100 Hz reaches it in sixteen months.
  static constexpr std::int64_t kFirst = std::int64_t{1} << 32;
  /// Most samples that a reader may look for: those between the first one that the writer still has, or that has
  /// followed in its stream, and the last one. A late joiner looks for the last sample of each key: the oldest key may
  /// be that many samples behind.
  static constexpr std::int64_t kMostListed = std::int64_t{1} << 20;
  /// A fragmented sample [byte]. No topic allows more (wire_rules.hpp).
  static constexpr std::uint32_t kMostSampleBytes = 1U << 22U;
  /// Writers of a participant whose numbers are known. A further one takes the place of the most silent one. One that
  /// has sent more than kMostListed samples keeps its place: forgotten, it would be a danger.
  static constexpr std::size_t kWriters = 256;

  /// Why the datagram must not reach the middleware, as a sentence; nothing: it may. Datagrams of other protocols pass,
  /// because the middleware ignores them.
  /// `source`: the socket that has sent it. `stall_ended`: of the receiving thread (ReceptionStall).
  [[nodiscard]] std::optional<std::string_view> refuse(std::span<const std::uint8_t> datagram, Address source,
                                                       Clock::time_point now,
                                                       std::optional<Clock::time_point> stall_ended = std::nullopt);
  /// True when a participant announces that it leaves (RTPS 2.2, section 8.5.3.2). The middleware must not receive it.
  /// Fast DDS 2.9.1 and 3.1 abort the process when a departure meets their check of that participant's lease. An
  /// intruder could also forge it. The lease removes a participant that has left.
  [[nodiscard]] static bool announces_departure(std::span<const std::uint8_t> datagram);
  enum class Protection : std::uint8_t {
    kNotNeeded,  ///< encrypted as a whole, or a participant's announcement or handshake, which nothing can encrypt
    kMissing,    ///< of the discovery of a participant without keys
    kForged,     ///< a sample, or what decides about samples, that is not encrypted
  };
  /// Participants with keys may receive kNotNeeded only. Fast DDS 2.9.1 encrypts what it sends, but it also takes what
  /// is not encrypted. An intruder could send a GAP in the name of any writer.
  [[nodiscard]] static Protection protection(std::span<const std::uint8_t> datagram);
  /// The participant has left or was found again: its writers may continue with any number.
  void forget(const Prefix& participant);
  /// Discovery has found the participant.
  void found(const Prefix& participant) { sources_.found(participant); }
  /// The participant has left: it may return with other sockets.
  void unbind(const Prefix& participant) { sources_.forget(participant); }

 private:
  using Entity = std::array<std::uint8_t, 4>;
  struct Guid {
    Prefix participant{};
    Entity entity{};
  };
  struct Hash {
    std::size_t operator()(const Prefix& participant) const;
  };
  /// A number of a writer and when it was received.
  struct Mark {
    std::int64_t number;
    Clock::time_point heard;
    Clock::time_point set;
  };
  struct Writer {
    Entity entity{};
    std::int64_t first = 0;
    std::int64_t last = 0;
    Clock::time_point since;
    Clock::time_point heard;
    /// A reader looks for no sample up to this one; nothing: no HEARTBEAT has told it yet.
    std::optional<std::int64_t> passed{};
    std::optional<Mark> before_stall{};  ///< nothing: the receiving thread has not stalled lately
  };
  using Writers = std::vector<Writer>;
  /// What is known of a writer; null: it is new. Hold mutex_.
  [[nodiscard]] Writer* find(const Guid& writer);
  /// False when its participant has too many writers. Hold mutex_.
  [[nodiscard]] bool add(const Guid& guid, const Writer& writer);
  /// The greatest number of this writer so far; 0: it is new.
  [[nodiscard]] std::int64_t last_of(const Guid& writer);
  /// By how much the writer's next number may exceed its last one.
  [[nodiscard]] static std::int64_t longest_leap(const Writer& writer, Clock::time_point now);
  /// By how much it may exceed the number that was received at `heard`.
  [[nodiscard]] static std::int64_t longest_leap(const Writer& writer, Clock::time_point heard, Clock::time_point now);
  /// When a datagram was read.
  struct Reading {
    Clock::time_point now;
    bool after_stall;  ///< the receiving thread stalled less than kBacklog ago
  };
  /// False when `number` leaps. `passed`: of a HEARTBEAT, the number before its first one.
  [[nodiscard]] bool follows(const Guid& writer, std::int64_t number, const Reading& reading,
                             std::optional<std::int64_t> passed = std::nullopt);
  /// True when the number follows the last one that was received before the stall. Sets that one. Hold mutex_.
  [[nodiscard]] static bool follows_stall(Writer& writer, std::int64_t number, const Reading& reading);
  /// True when a reader would look for more than kMostListed samples after a HEARTBEAT or GAP of this range.
  [[nodiscard]] bool lists_too_many(const Guid& writer, std::int64_t first, std::int64_t last);

  class Reader;
  struct Sender {
    Prefix participant;
    Address source;
  };
  struct Submessage {
    std::uint8_t id;
    std::uint8_t flags;
    std::span<const std::uint8_t> body;
  };
  /// Calls `visit` with each submessage until it returns true. False: a submessage is longer than its datagram.
  template <class Visit>
  static bool visit_submessages(std::span<const std::uint8_t> datagram, Visit visit);
  [[nodiscard]] static bool is_departure(const Submessage& submessage);
  [[nodiscard]] static Protection protection(const Submessage& submessage);
  [[nodiscard]] std::optional<std::string_view> refuse_source(const Prefix& participant, Address source,
                                                              Clock::time_point now);
  [[nodiscard]] std::optional<std::string_view> refuse(const Submessage& submessage, const Sender& sender,
                                                       const Reading& reading);
  /// Of a sample of discovery: false when it speaks of a participant for which its sender may not speak.
  [[nodiscard]] bool speaks_of_itself(const Submessage& sample, const Sender& sender, Clock::time_point now);
  /// Visits the parameters of a list until `visit` returns false. False: it has, or the list is cut off.
  template <class Visit>
  static bool visit_parameters(Reader& list, Visit visit);

  ParticipantSources sources_;
  std::mutex mutex_;
  std::unordered_map<Prefix, Writers, Hash> writers_;
};

}  // namespace hecaton::bus
