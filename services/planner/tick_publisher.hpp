#pragma once
/// Publishes the ticks of a planner while a recorder receives them.

#include <chrono>
#include <optional>
#include <string>

#include <idl/planner.h>

#include "services/bus/endpoint.hpp"
#include "services/tick_log/tick_writer.hpp"

namespace hecaton::services {

/// Without a recorder a period costs the reading of one number. For one thread.
class TickPublisher {
 public:
  using Clock = std::chrono::steady_clock;

  /// `arm`, `self`: name and index of the arm.
  TickPublisher(bus::Participant& participant, const std::string& arm, int self, const std::string& node);

  struct Period {
    TickWriter* ticks = nullptr;  ///< to fill in this period; null: no recorder is there, or another planner commands
    bool snapshot = false;        ///< with the memory of the planner
  };
  /// Call it at the beginning of each period. `in_charge`: this planner commands its arm.
  [[nodiscard]] Period begin(Clock::time_point now, bool in_charge);
  /// Call it after the command was sent. Publishes the tick of a period with `ticks`.
  void publish();

 private:
  bus::Writer<msg::PlannerTick> writer_;
  TickWriter ticks_;
  int readers_ = 0;        ///< in the last period
  bool unbroken_ = false;  ///< the tick before was published
  bool begun_ = false;     ///< in this period
  Clock::time_point snapshot_at_;
};

}  // namespace hecaton::services
