#include "planner/model/capsule_merge.hpp"

#include <cmath>

namespace hecaton::planner {
namespace {

constexpr double kSame = 1e-5;  // [m]: what a URDF's rounded decimals leave

/// Index of an unused sphere of `radius` around `centre`; −1 when there is none.
int sphere_at(const std::vector<world::PlacedShape>& shapes, const std::vector<bool>& used,
              const Eigen::Vector3d& centre, double radius) {
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    const auto* sphere = std::get_if<world::Sphere>(&shapes[i].shape);
    if (sphere != nullptr && !used[i] && std::abs(sphere->radius - radius) < kSame &&
        (shapes[i].X_BS.translation() - centre).norm() < kSame) {
      return static_cast<int>(i);
    }
  }
  return -1;
}

}  // namespace

std::vector<world::PlacedShape> merge_capsules(const std::vector<world::PlacedShape>& shapes) {
  std::vector<world::PlacedShape> merged = shapes;
  std::vector<bool> used(shapes.size(), false);  // spheres that became caps
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    const auto* cylinder = std::get_if<world::Cylinder>(&shapes[i].shape);
    if (cylinder == nullptr || cylinder->half_length < kSame) continue;
    const Eigen::Vector3d to_top(0.0, 0.0, cylinder->half_length);
    const int top = sphere_at(shapes, used, shapes[i].X_BS * to_top, cylinder->radius);
    const int bottom = sphere_at(shapes, used, shapes[i].X_BS * -to_top, cylinder->radius);
    if (top < 0 || bottom < 0) continue;
    used[top] = used[bottom] = true;
    merged[i].shape = world::Capsule{cylinder->radius, cylinder->half_length};
  }
  std::vector<world::PlacedShape> result;
  for (std::size_t i = 0; i < merged.size(); ++i) {
    if (!used[i]) result.push_back(merged[i]);
  }
  return result;
}

}  // namespace hecaton::planner
