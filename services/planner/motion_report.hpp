#pragma once
/// Where a planner wants to move its arm, as a message for people: from live planners and from simulations.

#include <cstddef>
#include <string>
#include <vector>

#include <idl/planner.h>

#include "planner/arm_planner/arm_planner.hpp"

namespace hecaton::services {

/// For one thread.
class MotionReport {
 public:
  static constexpr double kPeriod = 0.1;          ///< between two messages, at least [s]
  static constexpr std::size_t kMostPoints = 64;  ///< of each list of the message

  MotionReport(const std::string& arm, const std::string& node);

  /// Call it after each period that was planned. `time`: of its beginning, on a clock that runs evenly [s]. `answer`:
  /// of the rollout search in that period; null: none. True: message() is due, and the caller sets its stamp.
  [[nodiscard]] bool update(double time, const planner::ArmPlanner& planner, const planner::RolloutAnswer* answer);
  [[nodiscard]] msg::PlannedMotion& message() { return message_; }
  /// The next update() is due, with or without a change: a new reader has come, or this planner has just taken charge.
  void restart() { begins_ = true; }

 private:
  msg::PlannedMotion message_;
  std::vector<double> way_;       ///< reused
  std::vector<double> foreseen_;  ///< of the newest answer; empty: it is over
  double over_at_ = 0.0;          ///< the end of that rollout [s]
  double due_at_ = 0.0;           ///< [s]
  bool begins_ = true;
};

}  // namespace hecaton::services
