#pragma once
/// What a planner hears from its arm's distance sensors, with ages on this process's clock.

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include <idl/cause.h>
#include <idl/world.h>

#include "planner/cell.hpp"
#include "services/bus/mailbox.hpp"
#include "services/planner/arm_view.hpp"
#include "services/planner/sender_clock.hpp"

namespace hecaton::services {

class SensorView {
 public:
  using Clock = std::chrono::steady_clock;

  explicit SensorView(const planner::PlannedArm& arm);

  /// A scan of the own arm, measured where the arm then was: brought there from `own`, its last state. Nothing for
  /// another arm's sensors, for scans that were overtaken, and when it cannot be used: then `complaint` says why.
  [[nodiscard]] std::optional<planner::RangeScan> take(const msg::RangeScan& message, const bus::EndpointId& writer,
                                                       Clock::time_point received, const ArmView::Heard& own,
                                                       std::optional<std::string>& complaint);

  /// The first sensor that has been silent for longer than `limit` [s], or for three of its periods where those are
  /// longer; empty: none.
  [[nodiscard]] std::optional<msg::Cause> silent(Clock::time_point now, double limit) const;

  /// On the wire.
  [[nodiscard]] static std::string key(const std::string& arm, const std::string& sensor) { return arm + "/" + sensor; }

 private:
  struct Heard {
    bus::EndpointId writer;
    std::uint64_t sequence = 0;
    Clock::time_point at;  ///< when it was true, on this process's clock
    SenderClock clock;     ///< of its writer
  };

  std::string arm_;
  std::vector<planner::RangeSensor> sensors_;
  std::vector<std::string> links_;  ///< of the sensors
  std::vector<std::optional<Heard>> heard_;
};

}  // namespace hecaton::services
