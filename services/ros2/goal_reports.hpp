#pragma once
/// What planners answer to goals from topics, which have no other answer. No network.

#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <string>

#include <hecaton/client.hpp>

#include "services/bus/mailbox.hpp"

namespace hecaton::ros2 {

/// Of one arm. For one thread.
class GoalReports {
 public:
  using Clock = bus::Clock;
  using Report = std::function<std::optional<Progress>()>;  ///< the newest of a planner; empty: none yet

  static constexpr std::chrono::seconds kAnswerTime{10};  ///< a goal without a report for this long counts as refused
  static constexpr std::size_t kMost = 64;                ///< goals without a report; then the oldest counts as refused

  /// A goal was sent.
  void add(Report report, Clock::time_point now);
  /// It was not sent, for this reason.
  void refuse(std::string reason);
  /// Looks for first reports. Call it in each period.
  void update(Clock::time_point now);

  [[nodiscard]] std::uint64_t accepted() const { return accepted_; }
  [[nodiscard]] std::uint64_t refused() const { return refused_; }
  /// Of the newest goal that has an answer; empty: it was accepted.
  [[nodiscard]] const std::optional<std::string>& refusal() const { return refusal_; }

 private:
  struct Sent {
    Report report;
    Clock::time_point at;
    std::uint64_t number;
  };
  void refuse(std::string reason, std::uint64_t number);
  /// True: it is counted.
  bool count(const Sent& goal, Clock::time_point now);

  std::deque<Sent> sent_;     ///< oldest first
  std::uint64_t goals_ = 0;   ///< sent and not sent
  std::uint64_t newest_ = 0;  ///< number of the newest goal that has an answer
  std::uint64_t accepted_ = 0;
  std::uint64_t refused_ = 0;
  std::optional<std::string> refusal_;
};

}  // namespace hecaton::ros2
