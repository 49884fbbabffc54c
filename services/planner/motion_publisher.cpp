#include "services/planner/motion_publisher.hpp"

#include <chrono>
#include <utility>

namespace hecaton::services {

void MotionPublisher::publish(bus::Clock::time_point now, const planner::ArmPlanner& planner,
                              const planner::SearchAnswers& answers) {
  const int readers = writer_.matched();
  if (readers > std::exchange(readers_, readers)) report_.restart();
  if (readers == 0) return;
  const double time = std::chrono::duration<double>(now.time_since_epoch()).count();
  if (!report_.update(time, planner, answers.rollout ? &*answers.rollout : nullptr)) return;
  report_.message().stamp_ns(now.time_since_epoch().count());
  (void)writer_.write(report_.message());  // the bus logs a failed write
}

}  // namespace hecaton::services
