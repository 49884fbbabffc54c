#pragma once
/// Cancellations that must reach a planner.

#include <chrono>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "services/bus/mailbox.hpp"

namespace hecaton::ros2 {

/// Cancellations for the planner of an arm, each repeated until it is sent: an arm must not go on along a trajectory
/// that has ended for its client.
class Cancellations {
 public:
  using Clock = bus::Clock;

  static constexpr std::chrono::seconds kPeriod{1};  ///< between attempts

  explicit Cancellations(std::string arm) : arm_(std::move(arm)) {}

  /// Sends a cancellation now. `send` throws Error when it cannot; the reason is logged.
  void add(const std::string& goal, std::function<void()> send, Clock::time_point now);
  /// Sends again what could not be sent. Call it in each period.
  void retry(Clock::time_point now);
  /// Goals whose cancellation could not be sent yet.
  [[nodiscard]] std::vector<std::string> unsent() const;

 private:
  struct Entry {
    std::string goal;
    std::function<void()> send;
  };
  [[nodiscard]] bool sent(const Entry& entry) const;

  std::string arm_;
  std::vector<Entry> unsent_;
  Clock::time_point tried_{};
};

}  // namespace hecaton::ros2
