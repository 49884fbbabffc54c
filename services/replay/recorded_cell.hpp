#pragma once
/// The state of a recorded cell at any time of its recording.

#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "services/replay/message_feeder.hpp"
#include "services/replay/recording_index.hpp"

namespace hecaton::services::replay {

/// For one thread.
class RecordedCell {
 public:
  /// A search for the next state of an arm ends after this time of the recording, one for the next tick after the
  /// other.
  static constexpr std::chrono::seconds kLongestStep{60};
  static constexpr std::chrono::seconds kLongestTick{1};

  /// At the begin of the recording. `index` must outlive it. Throws RecordingError with a sentence when a file has
  /// changed since it was indexed; so do the other functions.
  explicit RecordedCell(const RecordingIndex& index);

  /// Shows the state after the last message that is not later than `time`. A time outside of the recording is its begin
  /// or end. It decodes the messages since now(), or since a checkpoint: some megabytes at most in a file of 1 GB.
  void move_to(bus::Clock::time_point time);

  [[nodiscard]] const RecordingIndex& index() const { return index_; }
  [[nodiscard]] const CellState& state() const { return state_; }
  [[nodiscard]] bus::Clock::time_point now() const { return now_; }

  /// When the arm's next state after now() was received, or the last one before now(). An empty name: of any arm.
  /// Empty: there is none within kLongestStep.
  [[nodiscard]] std::optional<bus::Clock::time_point> next_state(const std::string& arm);
  [[nodiscard]] std::optional<bus::Clock::time_point> previous_state(const std::string& arm);
  /// The same for ticks of the arm's planner. Empty: there is none within kLongestTick.
  [[nodiscard]] std::optional<bus::Clock::time_point> next_tick(const std::string& arm);
  [[nodiscard]] std::optional<bus::Clock::time_point> previous_tick(const std::string& arm);

 private:
  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);
  /// What a step goes to: messages of a topic whose key is the arm; empty: any arm.
  struct Wanted {
    std::string_view topic;
    const std::string& arm;
    bus::Clock::duration longest;  ///< from now()
  };
  /// A chunk with its messages in memory.
  struct Loaded {
    std::size_t chunk = kNone;
    recorder::Bytes records;
    std::vector<recorder::McapMessage> messages;
  };

  void return_to(const Checkpoint& checkpoint);
  /// False: the chunk begins the state of the cell anew, and later than `time`.
  bool enter_chunk(bus::Clock::time_point time);
  /// Takes the messages of the chunk until `time`. False: some of them are later.
  bool take_until(bus::Clock::time_point time);
  [[nodiscard]] const Loaded& load(std::size_t chunk);
  [[nodiscard]] std::optional<bus::Clock::time_point> next(const Wanted& wanted);
  [[nodiscard]] std::optional<bus::Clock::time_point> previous(const Wanted& wanted);
  [[nodiscard]] bool matches(const recorder::McapMessage& message, const Wanted& wanted);

  const RecordingIndex& index_;
  CellState state_;
  MessageFeeder feeder_;
  recorder::CurrentMessages searched_;  ///< for matches()
  bus::Clock::time_point now_;
  std::size_t chunk_ = 0;          ///< that has the next message
  std::size_t message_ = 0;        ///< the next one in the chunk
  bool entered_ = false;           ///< the chunk
  bus::Clock::time_point newest_;  ///< of the messages that were taken
  std::array<Loaded, 2> loaded_;   ///< the newest used one first
  std::size_t part_ = kNone;       ///< of reader_
  std::unique_ptr<recorder::McapChunks> reader_;
};

}  // namespace hecaton::services::replay
