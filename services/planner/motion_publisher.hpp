#pragma once
/// Publishes where a planner wants to move its arm, while a page or a recorder receives it.

#include <string>

#include "services/bus/endpoint.hpp"
#include "services/planner/motion_report.hpp"

namespace hecaton::services {

/// Without a reader a period costs the reading of one number. For one thread.
class MotionPublisher {
 public:
  MotionPublisher(bus::Participant& participant, const std::string& arm, const std::string& node)
      : writer_(participant), report_(arm, node) {}

  /// Call it after each planned period in which this planner commands its arm, with the answers of that period.
  void publish(bus::Clock::time_point now, const planner::ArmPlanner& planner, const planner::SearchAnswers& answers);
  /// Call it when another planner commands the arm.
  void resign() { report_.restart(); }

 private:
  bus::Writer<msg::PlannedMotion> writer_;
  MotionReport report_;
  int readers_ = 0;  ///< in the last period
};

}  // namespace hecaton::services
