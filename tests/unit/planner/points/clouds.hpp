#pragma once
/// Random point clouds, such as cameras see, and their balls one by one.

#include <memory>
#include <vector>

#include "tests/unit/planner/collision/random_shapes.hpp"
#include "world/model/point_cloud.hpp"

namespace hecaton::test {

using CloudPoints = std::vector<Eigen::Vector3f>;

inline std::shared_ptr<const world::PointCloud> cloud_of(CloudPoints points, double radius) {
  return std::make_shared<const world::PointCloud>(std::move(points), radius);
}

/// On a horizontal rectangle, with a camera's noise.
inline void add_table(CloudPoints& points, int count, const Eigen::Vector3d& centre, double half_size, double noise,
                      Random& random) {
  for (int i = 0; i < count; ++i) {
    points.emplace_back(
        (centre + Eigen::Vector3d(uniform(random, -half_size, half_size), uniform(random, -half_size, half_size),
                                  uniform(random, -noise, noise)))
            .cast<float>());
  }
}

/// On the sides of a box.
inline void add_box(CloudPoints& points, int count, const Eigen::Vector3d& centre, const Eigen::Vector3d& half,
                    Random& random) {
  for (int i = 0; i < count; ++i) {
    Eigen::Vector3d p(uniform(random, -1.0, 1.0), uniform(random, -1.0, 1.0), uniform(random, -1.0, 1.0));
    const auto axis = static_cast<Eigen::Index>(random() % 3);
    p[axis] = p[axis] > 0.0 ? 1.0 : -1.0;
    points.emplace_back((centre + p.cwiseProduct(half)).cast<float>());
  }
}

/// A table with a box on it, or points anywhere in a cube of 1 m.
inline CloudPoints random_points(int count, Random& random) {
  CloudPoints points;
  if (random() % 2 == 0) {
    for (int i = 0; i < count; ++i) {
      points.emplace_back(
          Eigen::Vector3d(uniform(random, -0.5, 0.5), uniform(random, -0.5, 0.5), uniform(random, -0.5, 0.5))
              .cast<float>());
    }
    return points;
  }
  add_table(points, count - count / 3, Eigen::Vector3d::Zero(), 0.5, 0.003, random);
  add_box(points, count / 3, Eigen::Vector3d(0.1, 0.1, 0.1), Eigen::Vector3d(0.1, 0.2, 0.1), random);
  return points;
}

}  // namespace hecaton::test
