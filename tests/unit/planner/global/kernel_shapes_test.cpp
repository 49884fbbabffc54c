#include "planner/global/kernel_shapes.hpp"

#include <gtest/gtest.h>

#include "planner/collision/exact_distance.hpp"
#include "tests/unit/planner/collision/random_shapes.hpp"

namespace hecaton::planner::global {
namespace {

bool covered(const std::vector<world::BoundingSphere>& spheres, const Eigen::Vector3d& p) {
  return std::any_of(spheres.begin(), spheres.end(),
                     [&](const world::BoundingSphere& ball) { return (p - ball.centre).norm() <= ball.radius + 1e-9; });
}

TEST(SphereCover, ContainsAllPointsOfTheShape) {
  test::Random random(3);
  for (int i = 0; i < 100; ++i) {
    const world::Shape shape = test::random_shape(static_cast<test::Kind>(i % test::kKinds), random);
    const auto spheres = sphere_cover(shape, {0.01, i % 2 == 0 ? 4 : 32});
    const world::BoundingSphere bound = world::bounding_sphere(shape);
    for (int k = 0; k < 2000; ++k) {
      const Eigen::Vector3d p = bound.centre + test::random_vector(random, -bound.radius, bound.radius);
      world::Pose X = world::Pose::Identity();
      X.translation() = p;
      if (shape_distance(world::Sphere{1e-9}, X, shape, world::Pose::Identity()).distance > 0.0) continue;
      EXPECT_TRUE(covered(spheres, p)) << test::kKindNames[i % test::kKinds] << " " << i;
    }
  }
}

TEST(SphereCover, KeepsTheNumberOfSpheresAndTheExcess) {
  const world::Capsule capsule{0.05, 0.2};
  const auto spheres = sphere_cover(capsule, {0.005, 64});
  for (const auto& ball : spheres) EXPECT_LE(ball.radius, 0.055 + 1e-12);
  EXPECT_LE(spheres.size(),
            12U);  // a sphere of 55 mm covers 2 √(55² − 50²) = 45.8 mm of the axis of 400 mm: nine, plus the ends
  EXPECT_EQ(sphere_cover(capsule, {0.001, 3}).size(), 3U);
  EXPECT_EQ(sphere_cover(world::Box{{0.3, 0.2, 0.01}}, {0.001, 7}).size(), 7U);
  EXPECT_EQ(sphere_cover(world::Sphere{0.1}, {0.001, 7}).size(), 1U);
}

}  // namespace
}  // namespace hecaton::planner::global
