#include "services/ros2/planner_watch.hpp"

#include <algorithm>

namespace hecaton::ros2 {

void PlannerWatch::note(const bus::Event& event) {
  if (event.kind != bus::EventKind::kParticipantFound && event.kind != bus::EventKind::kParticipantLost) return;
  std::erase_if(planners_, [&](const Planner& one) { return one.participant.same_participant(event.peer); });
  constexpr std::string_view kPlanner = "planner/";  // then the arm, and for a standby '@' and its host
  if (event.kind == bus::EventKind::kParticipantLost || planners_.size() == kMost || !event.key.starts_with(kPlanner)) {
    return;
  }
  const std::string arm = event.key.substr(kPlanner.size());
  planners_.push_back({event.peer, arm.substr(0, arm.find('@'))});
}

bool PlannerWatch::knows(std::string_view arm) const {
  return std::any_of(planners_.begin(), planners_.end(), [&](const Planner& one) { return one.arm == arm; });
}

}  // namespace hecaton::ros2
