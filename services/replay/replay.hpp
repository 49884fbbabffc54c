#pragma once
/// A recorded cell that is played: pages choose the time that all of them show.

#include <cstdint>
#include <string>
#include <string_view>

#include "services/replay/recorded_cell.hpp"
#include "services/view/cell_feed.hpp"
#include "services/view/json.hpp"

namespace hecaton::services::replay {

/// For one thread.
class Replay : public CellFeed {
 public:
  static constexpr double kSlowest = 0.1;
  static constexpr double kFastest = 10.0;

  /// Paused, at the begin of the recording. `cell` must outlive it.
  explicit Replay(RecordedCell& cell) : cell_(cell) {}

  /// Takes a command of a page (page/src/protocol.ts: Command). One that is malformed is ignored.
  void command(std::string_view json);
  void seek(bus::Clock::time_point time);
  /// So much time has passed. At its end the recording is paused.
  void advance(bus::Clock::duration elapsed);

  [[nodiscard]] const CellState& state() const override { return cell_.state(); }
  [[nodiscard]] bus::Clock::time_point now() const override { return cell_.now(); }
  [[nodiscard]] std::chrono::milliseconds unix_time() const override;
  [[nodiscard]] double rate() const override { return plays_ ? speed_ : 0.0; }
  [[nodiscard]] std::uint64_t leaps() const override { return leaps_; }

  /// Where it is, for the page.
  [[nodiscard]] view::Json playback_json() const;
  /// The recording itself: its length, its marks, and what a viewer must know.
  [[nodiscard]] view::Json recording_json() const;

 private:
  /// To the next (1) or previous (-1) tick of the arm's planner; where none is recorded, to the arm's state. An empty
  /// name: of any arm.
  void step(int by, const std::string& arm);

  RecordedCell& cell_;
  bool plays_ = false;
  double speed_ = 1.0;
  std::uint64_t leaps_ = 0;
};

}  // namespace hecaton::services::replay
