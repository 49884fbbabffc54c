#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "planner/model/capsules.hpp"
#include "planner/model/convex_hull.hpp"

namespace hecaton::planner {
namespace {

using Points = std::vector<Eigen::Vector3d>;

Points sphere_points(int count, std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  Points points;
  for (int i = 0; i < count; ++i) {
    points.push_back(Eigen::Vector3d(normal(random), normal(random), normal(random)).normalized());
  }
  return points;
}

/// Point inside the convex hull of the vertices, by the faces: independent of how the hull was simplified.
double highest_above(const world::ConvexHull& hull, const Points& points) {
  double highest = -INFINITY;
  for (int f = 0; f < static_cast<int>(hull.faces.size()); ++f) {
    const FacePlane plane = face_plane(hull, f);
    for (const auto& p : points) highest = std::max(highest, plane.normal.dot(p) - plane.offset);
  }
  return highest;
}

TEST(EnclosingHull, KeepsSmallHulls) {
  const auto cube =
      convex_hull(Points{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {0, 0, 1}, {1, 0, 1}, {0, 1, 1}, {1, 1, 1}});
  ASSERT_TRUE(cube);
  EXPECT_EQ(enclosing_hull(*cube, 64).vertices, cube->vertices);
}

TEST(EnclosingHull, EnclosesASphereWith64VerticesAtSmallExcess) {
  std::mt19937_64 random(5);
  const Points points = sphere_points(3000, random);
  const auto hull = convex_hull(points);
  ASSERT_TRUE(hull);
  const world::ConvexHull outer = enclosing_hull(*hull, 64);
  EXPECT_LE(outer.vertices.size(), 64U);
  EXPECT_LE(highest_above(outer, points), 1e-9);
  EXPECT_LT(volume(outer) / volume(*hull), 1.3);  // 34 faces around a ball
}

TEST(EnclosingHull, EnclosesRandomHulls) {
  std::mt19937_64 random(17);
  for (int trial = 0; trial < 30; ++trial) {
    const Eigen::Vector3d stretch(1.0, std::pow(0.3, trial % 4), std::pow(0.2, trial % 3));
    const Eigen::AngleAxisd turn(0.1 * trial, Eigen::Vector3d(1, trial, 2).normalized());
    Points points = sphere_points(100 + 20 * trial, random);
    for (auto& p : points) p = turn * p.cwiseProduct(stretch) * 0.2 + Eigen::Vector3d(0.5, -1, 2);
    const auto hull = convex_hull(points);
    ASSERT_TRUE(hull);
    const world::ConvexHull outer = enclosing_hull(*hull, 64);
    ASSERT_LE(outer.vertices.size(), 64U);
    ASSERT_LE(highest_above(outer, points), 1e-8) << trial;
    ASSERT_LT(volume(outer) / volume(*hull), 2.0) << trial;
  }
}

TEST(EnclosingHull, KeepsTheEndsOfCylinders) {
  Points points;
  for (int i = 0; i < 360; ++i) {
    const double angle = std::numbers::pi * i / 180.0;
    for (const double z : {-0.4, 0.4}) points.emplace_back(0.05 * std::cos(angle), 0.05 * std::sin(angle), z);
  }
  const auto hull = convex_hull(points);
  ASSERT_TRUE(hull);
  const world::ConvexHull outer = enclosing_hull(*hull, 64);
  ASSERT_LE(outer.vertices.size(), 64U);
  EXPECT_LE(highest_above(outer, points), 1e-9);
  // A prism of at most 32 sides around a circle: (n/π) tan(π/n) = 1.0033 for n = 32; allow for unequal sides.
  EXPECT_LT(volume(outer) / volume(*hull), 1.05);
}

double outside(const PlacedCapsule& placed, const Eigen::Vector3d& p) {
  Eigen::Vector3d q = placed.X_FS.inverse() * p;
  q.z() -= std::clamp(q.z(), -placed.capsule.half_length, placed.capsule.half_length);
  return q.norm() - placed.capsule.radius;
}

TEST(EnclosingCapsule, RecoversTheCapsuleOfItsSurfacePoints) {
  std::mt19937_64 random(3);
  const Eigen::AngleAxisd turn(1.1, Eigen::Vector3d(3, 1, 2).normalized());
  const Eigen::Vector3d shift(0.4, -0.7, 1.5);
  Points points = sphere_points(2000, random);
  for (auto& p : points) {
    p *= 0.08;
    p.z() += p.z() > 0 ? 0.3 : -0.3;
    p = turn * p + shift;
  }
  const PlacedCapsule placed = enclosing_capsule(points);
  for (const auto& p : points) ASSERT_LE(outside(placed, p), 1e-9);
  EXPECT_NEAR(placed.capsule.radius, 0.08, 0.001);
  EXPECT_NEAR(placed.capsule.half_length, 0.3, 0.003);
  EXPECT_GT(std::abs(placed.X_FS.linear().col(2).dot(turn * Eigen::Vector3d::UnitZ())), 0.9999);
  EXPECT_LT((placed.X_FS.translation() - shift).norm(), 0.002);
}

TEST(EnclosingCapsule, EnclosesRandomPoints) {
  std::mt19937_64 random(8);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int trial = 0; trial < 100; ++trial) {
    Points points;
    const int count = 1 + trial;
    for (int i = 0; i < count; ++i) {
      points.emplace_back(uniform(random), 0.3 * uniform(random), (trial % 3) * uniform(random));
    }
    const PlacedCapsule placed = enclosing_capsule(points);
    ASSERT_TRUE(placed.X_FS.linear().isUnitary(1e-9));
    ASSERT_GE(placed.capsule.half_length, 0.0);
    for (const auto& p : points) ASSERT_LE(outside(placed, p), 1e-9) << trial;
  }
}

TEST(EnclosingCapsule, VolumeIsCylinderPlusBall) {
  // π r² (2 h + 4/3 r) with r = 1, h = 2: π (4 + 4/3)
  EXPECT_NEAR(volume(world::Capsule{1.0, 2.0}), std::numbers::pi * (4.0 + 4.0 / 3.0), 1e-12);
}

}  // namespace
}  // namespace hecaton::planner
