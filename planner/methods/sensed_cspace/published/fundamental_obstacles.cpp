#include "planner/methods/sensed_cspace/published/fundamental_obstacles.hpp"

#include <algorithm>
#include <cmath>

namespace hecaton::planner::cspace {

std::vector<FundamentalObstacle> border(std::span<const Point> corners, double spacing) {
  constexpr double kStepsPerSpacing = 4.0;
  std::vector<FundamentalObstacle> found;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Point& from = corners[i];
    const Point& to = corners[(i + 1) % corners.size()];
    const double length = std::hypot(to.x - from.x, to.y - from.y);
    const int steps = std::max(1, static_cast<int>(std::ceil(kStepsPerSpacing * length / spacing)));
    for (int k = 0; k < steps; ++k) {
      const double share = static_cast<double>(k) / steps;
      const Point place{spacing * std::round((from.x + share * (to.x - from.x)) / spacing),
                        spacing * std::round((from.y + share * (to.y - from.y)) / spacing)};
      const bool known = std::any_of(found.begin(), found.end(), [&](const FundamentalObstacle& other) {
        return other.place.x == place.x && other.place.y == place.y;
      });
      if (!known) found.push_back({place, std::hypot(place.x, place.y), std::atan2(place.y, place.x)});
    }
  }
  return found;
}

std::vector<Point> border_points(std::span<const Point> corners, double spacing) {
  std::vector<Point> points;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Point& from = corners[i];
    const Point& to = corners[(i + 1) % corners.size()];
    const int steps = std::max(1, static_cast<int>(std::ceil(std::hypot(to.x - from.x, to.y - from.y) / spacing)));
    for (int k = 0; k < steps; ++k) {
      const double share = static_cast<double>(k) / steps;
      points.push_back({from.x + share * (to.x - from.x), from.y + share * (to.y - from.y)});
    }
  }
  return points;
}

}  // namespace hecaton::planner::cspace
