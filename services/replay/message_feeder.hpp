#pragma once
/// Applies the messages of a recording to the state of its cell.

#include <algorithm>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "services/recorder/current_messages.hpp"
#include "services/recorder/mcap_reader.hpp"
#include "services/replay/marks.hpp"
#include "services/view/cell_state.hpp"

namespace hecaton::services::replay {

/// The time of a message on the clock of CellState: when its recorder received it, since 1970. Later times than the
/// year 2116 count as this year, so that sums and differences of times do not overflow.
[[nodiscard]] inline bus::Clock::time_point time_of(const recorder::McapMessage& message) {
  constexpr std::uint64_t kLast = std::uint64_t{1} << 62U;  // [ns]
  return bus::Clock::time_point(std::chrono::nanoseconds(std::min(message.log_time, kLast)));
}

/// A message that also stands in the file before, or is older.
[[nodiscard]] bool is_repeated(const recorder::McapChannel& channel);
/// A message of the cell, not of its recorder.
[[nodiscard]] bool is_of_cell(const recorder::McapChannel& channel);

/// The key of a sample of ArmState, PlannedMotion or Heartbeat; empty: it has another byte order, or is cut off. Valid
/// as long as the bytes.
[[nodiscard]] std::optional<std::string_view> key_in(recorder::ByteSpan bytes);

/// What could not be decoded.
struct UndecodedMessages {
  static constexpr std::size_t kMostRefusals = 20;
  /// Of another version, and not converted: the sentence, and how many. Further sentences are left out.
  std::map<std::string, std::uint64_t> refused;
  std::uint64_t broken = 0;  ///< that break a rule of the wire
};

/// It converts messages of other versions. It decodes at once what changes seldom. Of arm states, planned motions,
/// heartbeats, obstacle poses and contact reports it decodes only the newest of each key, in flush(): the state of a
/// cell has no others. For one thread.
class MessageFeeder {
 public:
  /// Both must outlive it. `marks` gets what is decoded at once; null: none.
  explicit MessageFeeder(CellState& state, MarkFinder* marks = nullptr) : state_(state), marks_(marks) {}

  void take(const recorder::McapMessage& message);
  /// Brings the state up to date with all messages so far.
  void flush();
  /// Forgets what was taken and not decoded.
  void drop();

  [[nodiscard]] const UndecodedMessages& undecoded() const { return undecoded_; }
  [[nodiscard]] std::uint64_t decoded() const { return decoded_; }  ///< messages
  /// What a reader must know of messages of other versions, a sentence each.
  [[nodiscard]] std::vector<std::string> notes() const { return current_.notes(); }

 private:
  enum class Topic : std::uint8_t {
    kOther,
    kArmState,
    kHeartbeat,
    kObstacleStates,
    kContactReport,
    kGoalStatus,
    kToolState,
    kPlannedMotion,
    kObstacleShapes,
    kFault,
    kCellMode,
    kWithdrawn
  };
  struct Role {
    Topic topic = Topic::kOther;
    bus::EndpointId writer;
  };
  /// The newest message of a key that waits for flush().
  struct Waiting {
    Topic topic{};
    recorder::Bytes data;
    bus::Clock::time_point received;
    bus::EndpointId writer;
    bool waits = false;
  };
  /// By topic and key. It keeps the memory of messages that were decoded.
  using WaitingMessages = std::map<std::string, Waiting, std::less<>>;

  [[nodiscard]] const Role& role_of(const std::shared_ptr<const recorder::McapChannel>& described);
  /// False: the message cannot wait.
  bool defer(const Role& role, recorder::ByteSpan data, bus::Clock::time_point received);
  void refuse(const std::string& sentence);
  void decode(Topic topic, recorder::ByteSpan data, bus::Clock::time_point received, const bus::EndpointId& writer);
  template <class T>
  void apply(recorder::ByteSpan data, bus::Clock::time_point received, const bus::EndpointId& writer);
  void withdraw(recorder::ByteSpan json, bus::Clock::time_point received);

  CellState& state_;
  MarkFinder* marks_;
  recorder::CurrentMessages current_;
  UndecodedMessages undecoded_;
  std::uint64_t decoded_ = 0;
  std::unordered_map<std::shared_ptr<const recorder::McapChannel>, Role> roles_;
  WaitingMessages waiting_;
  std::string key_;  ///< of defer()
};

}  // namespace hecaton::services::replay
