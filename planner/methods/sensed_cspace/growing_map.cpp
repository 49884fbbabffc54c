#include "planner/methods/sensed_cspace/growing_map.hpp"

#include <algorithm>

namespace hecaton::planner::cspace {

void GrowingMap::note(double distance, const Eigen::Vector3d& p_B) {
  if (!map_.holds(p_B)) waiting_.push_back({distance, p_B});
}

bool GrowingMap::advance(int& points) {
  std::stable_sort(waiting_.begin(), waiting_.end(),
                   [](const Waiting& a, const Waiting& b) { return a.distance < b.distance; });
  bool blocked_more = false;
  auto next = waiting_.begin();
  for (; next != waiting_.end(); ++next) {
    if (map_.holds(next->p_B)) continue;
    if (points <= 0) break;
    blocked_more = map_.see(next->p_B) || blocked_more;
    --points;
  }
  waiting_.erase(waiting_.begin(), next);
  return blocked_more;
}

void GrowingMap::forget() {
  map_.forget();
  waiting_.clear();
}

}  // namespace hecaton::planner::cspace
