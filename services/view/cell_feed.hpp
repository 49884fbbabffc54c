#pragma once
/// Where the page gets the states of a cell from: a running cell (live_feed.hpp) or a recording (services/replay).

#include <chrono>
#include <cstdint>

#include "services/view/cell_state.hpp"

namespace hecaton::services {

/// For one thread.
class CellFeed {
 public:
  CellFeed() = default;
  virtual ~CellFeed() = default;
  CellFeed(const CellFeed&) = delete;
  CellFeed& operator=(const CellFeed&) = delete;

  /// What was received until now().
  [[nodiscard]] virtual const CellState& state() const = 0;
  /// The instant that the page shows, on the clock by which samples were received.
  [[nodiscard]] virtual bus::Clock::time_point now() const = 0;
  /// The same instant by the wall clock, since 1970.
  [[nodiscard]] virtual std::chrono::milliseconds unix_time() const = 0;
  /// Seconds of now() in a second: 1 for a running cell, 0 for a recording that is paused.
  [[nodiscard]] virtual double rate() const = 0;
  /// Grows by one when now() leaps, back or forth.
  [[nodiscard]] virtual std::uint64_t leaps() const = 0;
};

}  // namespace hecaton::services
