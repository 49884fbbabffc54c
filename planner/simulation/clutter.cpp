#include "planner/simulation/clutter.hpp"

#include <cmath>
#include <numbers>

namespace hecaton::planner {

std::vector<world::Obstacle> draw_clutter(const Clutter& clutter, Random& random) {
  std::vector<world::Obstacle> obstacles;
  for (int i = 0; i < clutter.count; ++i) {
    const auto half = [&] { return 0.5 * random.uniform(clutter.smallest, clutter.largest); };
    world::Obstacle& obstacle = obstacles.emplace_back();
    obstacle.name = "clutter" + std::to_string(i);
    switch (random.next() % 3) {
      case 0:
        obstacle.shapes.push_back({world::Box{{half(), half(), half()}}});
        break;
      case 1:
        obstacle.shapes.push_back({world::Sphere{half()}});
        break;
      default:
        obstacle.shapes.push_back({world::Cylinder{half(), half()}});
    }
    const double r = random.uniform(clutter.inner, clutter.outer);
    const double angle = random.uniform(-std::numbers::pi, std::numbers::pi);
    obstacle.X_WO.translation() =
        Eigen::Vector3d(r * std::cos(angle), r * std::sin(angle), random.uniform(clutter.lowest, clutter.highest));
    obstacle.X_WO.linear() =
        Eigen::AngleAxisd(random.uniform(0.0, std::numbers::pi), Eigen::Vector3d::UnitZ()).toRotationMatrix();
  }
  return obstacles;
}

}  // namespace hecaton::planner
