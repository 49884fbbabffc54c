#include "world/sim/bullet_shape.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace hecaton::world {
namespace {

using Eigen::Vector3d;

Pose at_point(double x, double y, double z) {
  Pose pose = Pose::Identity();
  pose.translation() = Vector3d(x, y, z);
  return pose;
}

double distance(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB) {
  return signed_distance(*make_bullet_shape(a), to_bullet(X_WA), *make_bullet_shape(b), to_bullet(X_WB)).distance;
}

Convex hull_of_box(const Vector3d& half) {
  auto hull = std::make_shared<ConvexHull>();
  for (int i = 0; i < 8; ++i) {
    hull->vertices.emplace_back((i & 1) ? half.x() : -half.x(), (i & 2) ? half.y() : -half.y(),
                                (i & 4) ? half.z() : -half.z());
  }
  hull->faces = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  return {hull};
}

TEST(BulletShape, PoseConversionIsInvertible) {
  const Pose pose = pose_from_xyz_rpy({1, -2, 3}, {0.3, -0.8, 2.0});
  EXPECT_TRUE(from_bullet(to_bullet(pose)).isApprox(pose, 1e-15));
}

TEST(BulletShape, SphereDistanceIsCentreDistanceMinusRadii) {
  EXPECT_NEAR(distance(Sphere{0.3}, at_point(0, 0, 0), Sphere{0.2}, at_point(0, 3, 4)), 4.5, 1e-9);
  EXPECT_NEAR(distance(Sphere{0.3}, at_point(0, 0, 0), Sphere{0.2}, at_point(0.4, 0, 0)), -0.1, 1e-9);
}

TEST(BulletShape, CapsuleLiesAlongZWithItsRadius) {
  const Capsule capsule{0.05, 0.4};
  // Ends: the segment's end at 0.4, the cap to 0.45.
  EXPECT_NEAR(distance(capsule, at_point(0, 0, 0), Sphere{0.1}, at_point(0, 0, 1)), 0.45, 1e-9);
  EXPECT_NEAR(distance(capsule, at_point(0, 0, 0), Sphere{0.1}, at_point(1, 0, 0)), 0.85, 1e-9);
  EXPECT_NEAR(distance(capsule, at_point(0, 0, 0), Sphere{0.1}, at_point(0, 1, 0.3)), 0.85, 1e-9);
  // Beyond the end: nearest point of the segment (0, 0, 0.4), 3–4–5 away.
  EXPECT_NEAR(distance(capsule, at_point(0, 0, 0), Sphere{0.1}, at_point(0.3, 0, 0.8)), 0.35, 1e-9);
  // Two crossed capsules, axes 0.08 apart: 0.02 deep.
  const Pose lying = pose_from_xyz_rpy({0.08, 0, 0}, {std::acos(-1.0) / 2, 0, 0});
  EXPECT_NEAR(distance(capsule, at_point(0, 0, 0), capsule, lying), -0.02, 1e-9);
  // A capsule without length is a ball.
  EXPECT_NEAR(distance(Capsule{0.1, 0.0}, at_point(0, 0, 0), Sphere{0.1}, at_point(0, 0.5, 0)), 0.3, 1e-9);
}

TEST(BulletShape, BoxKeepsSizeAndSharpCorners) {
  const Box cube{Vector3d(0.5, 0.5, 0.5)};
  EXPECT_NEAR(distance(cube, at_point(0, 0, 0), cube, at_point(1.2, 0.3, 0)), 0.2, 1e-9);
  EXPECT_NEAR(distance(cube, at_point(0, 0, 0), cube, at_point(0.9, 0.1, 0)), -0.1, 1e-9);
  // Corner (0.5, 0.5, 0.5) to a ball at (1, 1, 1): √0.75 less its radius.
  EXPECT_NEAR(distance(cube, at_point(0, 0, 0), Sphere{0.1}, at_point(1, 1, 1)), std::sqrt(0.75) - 0.1, 1e-9);
  // Edge to edge: both turned by 45°, so √0.5 each, 2 m apart.
  const Pose turned = pose_from_xyz_rpy({0, 0, 0}, {0, 0, std::acos(-1.0) / 4});
  EXPECT_NEAR(distance(cube, turned, cube, at_point(2, 0, 0) * turned), 2 - std::sqrt(2.0), 1e-9);
}

TEST(BulletShape, TallThinBoxKeepsSize) {
  const Box blade{Vector3d(0.001, 0.2, 2.0)};
  EXPECT_NEAR(distance(blade, at_point(0, 0, 0), Sphere{0.05}, at_point(0.1, 0, 1.9)), 0.049, 1e-9);
  EXPECT_NEAR(distance(blade, at_point(0, 0, 0), Sphere{0.05}, at_point(0, 0, 2.1)), 0.05, 1e-9);
  EXPECT_NEAR(distance(blade, at_point(0, 0, 0), Capsule{0.02, 1.0}, at_point(0.0305, 0.1, 0.5)), 0.0095, 1e-9);
  // Thin against thin, overlapping by the sum of the half thicknesses less the offset.
  EXPECT_NEAR(distance(blade, at_point(0, 0, 0), blade, at_point(0.0015, 0, 0)), -0.0005, 1e-5);
}

TEST(BulletShape, CylinderStandsAlongZWithSharpRims) {
  const Cylinder cylinder{0.2, 0.5};
  EXPECT_NEAR(distance(cylinder, at_point(0, 0, 0), Sphere{0.1}, at_point(0, 0, 1)), 0.4, 1e-4);
  EXPECT_NEAR(distance(cylinder, at_point(0, 0, 0), Sphere{0.1}, at_point(0.6, 0, 0.2)), 0.3, 1e-4);
  // Rim at (0.2, 0, 0.5): 3–4–5 to (0.5, 0, 0.9).
  EXPECT_NEAR(distance(cylinder, at_point(0, 0, 0), Sphere{0.1}, at_point(0.5, 0, 0.9)), 0.4, 1e-4);
  EXPECT_NEAR(distance(cylinder, at_point(0, 0, 0), cylinder, at_point(0.35, 0, 0)), -0.05, 1e-4);
}

TEST(BulletShape, HullsAreNotInflated) {
  const Vector3d half(0.3, 0.2, 0.1);
  const Convex hull = hull_of_box(half);
  EXPECT_NEAR(distance(hull, at_point(0, 0, 0), Sphere{0.1}, at_point(0.6, 0, 0)), 0.2, 1e-9);
  EXPECT_NEAR(distance(hull, at_point(0, 0, 0), hull, at_point(0, 0, 0.15)), -0.05, 1e-5);
  EXPECT_NEAR(distance(hull, at_point(0, 0, 0), Sphere{0.1}, at_point(0.6, 0.6, 0.1)), 0.4, 1e-9);
}

TEST(BulletShape, ConcentricShapesOverlap) {
  // The shallowest way out of a concentric pair is along the thinnest direction of the two.
  EXPECT_NEAR(distance(Sphere{0.2}, at_point(0, 0, 0), Sphere{0.1}, at_point(0, 0, 0)), -0.3, 1e-6);
  EXPECT_NEAR(
      distance(Box{Vector3d(0.5, 0.5, 0.1)}, at_point(0, 0, 0), Box{Vector3d(0.5, 0.5, 0.1)}, at_point(0, 0, 0)), -0.2,
      1e-6);
  EXPECT_NEAR(distance(Box{Vector3d(0.5, 0.4, 0.1)}, at_point(0, 0, 0), Sphere{0.05}, at_point(0, 0, 0)), -0.15, 1e-6);
}

/// Signed distance of a point from a box at the origin, in closed form.
double box_point(const Vector3d& half, const Vector3d& p) {
  const Vector3d outside = p.cwiseAbs() - half;
  return outside.cwiseMax(0.0).norm() + std::min(outside.maxCoeff(), 0.0);
}

/// The distance from a point to a segment, in closed form.
double segment_point(const Vector3d& from, const Vector3d& to, const Vector3d& p) {
  const double share = std::clamp((p - from).dot(to - from) / (to - from).squaredNorm(), 0.0, 1.0);
  return (from + share * (to - from) - p).norm();
}

Pose random_pose(std::mt19937_64& random) {
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  std::normal_distribution<double> normal;
  Pose pose = at_point(0.4 * unit(random), 0.4 * unit(random), 0.4 * unit(random));
  pose.linear() = Eigen::Quaterniond(normal(random), normal(random), normal(random), normal(random))
                      .normalized()
                      .toRotationMatrix();
  return pose;
}

TEST(BulletShape, SphereToBoxAndHullMatchesClosedForm) {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> size(0.01, 0.3);
  int overlaps = 0;
  int inexact = 0;
  for (int i = 0; i < 3000; ++i) {
    const Vector3d half(size(random), size(random), size(random));
    const Sphere ball{size(random)};
    const Pose X_WA = random_pose(random);
    const Pose X_WB = random_pose(random);
    const double expected = box_point(half, X_WA.inverse() * X_WB.translation()) - ball.radius;
    overlaps += expected < 0 ? 1 : 0;
    for (const double found : {distance(Box{half}, X_WA, ball, X_WB), distance(ball, X_WB, hull_of_box(half), X_WA)}) {
      // Overlaps that Bullet cannot settle are reported deeper than they are, never less deep, and seldom.
      ASSERT_LE(found, expected + 1e-4) << i;
      ASSERT_TRUE(expected < 0 || std::abs(found - expected) < 1e-4) << i;
      inexact += std::abs(found - expected) > 1e-4 ? 1 : 0;
    }
  }
  EXPECT_LT(inexact, 10);
  EXPECT_GT(overlaps, 300);
  EXPECT_LT(overlaps, 2700);
}

TEST(BulletShape, SphereToCapsuleMatchesClosedForm) {
  std::mt19937_64 random(12);
  std::uniform_real_distribution<double> size(0.01, 0.3);
  for (int i = 0; i < 3000; ++i) {
    const Capsule capsule{size(random), size(random)};
    const Sphere ball{size(random)};
    const Pose X_WA = random_pose(random);
    const Pose X_WB = random_pose(random);
    const Vector3d end = capsule.half_length * X_WA.linear().col(2);
    const double expected = segment_point(X_WA.translation() - end, X_WA.translation() + end, X_WB.translation()) -
                            capsule.radius - ball.radius;
    ASSERT_NEAR(distance(capsule, X_WA, ball, X_WB), expected, 1e-9) << i;
  }
}

TEST(BulletShape, CapsuleToBoxMatchesSearchAlongItsAxis) {
  std::mt19937_64 random(13);
  std::uniform_real_distribution<double> size(0.01, 0.3);
  int compared = 0;
  for (int i = 0; i < 3000; ++i) {
    const Vector3d half(size(random), size(random), size(random));
    const Capsule capsule{0.3 * size(random), size(random)};
    const Pose X_AB = random_pose(random);
    // The distance to a convex set is convex along the axis: golden-section search finds its least value.
    double low = -capsule.half_length;
    double high = capsule.half_length;
    const auto at = [&](double z) { return box_point(half, X_AB * Vector3d(0, 0, z)); };
    for (int k = 0; k < 100; ++k) {
      const double third = (high - low) / 3.0;
      (at(low + third) < at(high - third) ? high : low) =
          at(low + third) < at(high - third) ? high - third : low + third;
    }
    // Where the axis itself enters the box, the depth is not that of its deepest point.
    if (at(0.5 * (low + high)) <= 0.0) continue;
    ++compared;
    ASSERT_NEAR(distance(Box{half}, Pose::Identity(), capsule, X_AB), at(0.5 * (low + high)) - capsule.radius, 1e-6)
        << i;
  }
  EXPECT_GT(compared, 1000);
}

/// Support function of the shape along a unit direction, in closed form.
double reach(const Shape& shape, const Vector3d& n) {
  if (const auto* box = std::get_if<Box>(&shape)) return box->half_extents.dot(n.cwiseAbs());
  if (const auto* capsule = std::get_if<Capsule>(&shape))
    return capsule->radius + capsule->half_length * std::abs(n.z());
  const auto& cylinder = std::get<Cylinder>(shape);
  return cylinder.radius * std::hypot(n.x(), n.y()) + cylinder.half_length * std::abs(n.z());
}

TEST(BulletShape, NoDirectionSeparatesMoreThanTheDistance) {
  // Duality: the signed distance is the largest gap over all directions. So no direction may show a larger one.
  std::mt19937_64 random(14);
  std::uniform_real_distribution<double> size(0.01, 0.3);
  std::normal_distribution<double> normal;
  const auto random_shape = [&](int kind) -> Shape {
    if (kind == 0) return Box{Vector3d(size(random), size(random), size(random))};
    if (kind == 1) return Capsule{size(random), size(random)};
    return Cylinder{size(random), size(random)};
  };
  for (int i = 0; i < 2000; ++i) {
    const Shape a = random_shape(i % 3);
    const Shape b = random_shape(i / 3 % 3);
    const Pose X_WA = random_pose(random);
    const Pose X_WB = random_pose(random);
    const double found = distance(a, X_WA, b, X_WB);
    const Vector3d between = X_WB.translation() - X_WA.translation();
    for (int k = 0; k < 200; ++k) {
      const Vector3d n = Vector3d(normal(random), normal(random), normal(random)).normalized();
      const double gap =
          n.dot(between) - reach(a, X_WA.linear().transpose() * n) - reach(b, X_WB.linear().transpose() * -n);
      ASSERT_LE(gap, found + 2e-4) << i;
    }
  }
}

}  // namespace
}  // namespace hecaton::world
