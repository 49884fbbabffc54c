/// Distances calculated by hand.

#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "planner/collision/exact_distance.hpp"
#include "random_shapes.hpp"

namespace hecaton {
namespace {

using Eigen::Vector3d;
using planner::shape_distance;
using planner::ShapeDistance;
using world::Pose;

Pose at(double x, double y, double z, const Vector3d& rpy = Vector3d::Zero()) {
  return world::pose_from_xyz_rpy({x, y, z}, rpy);
}

constexpr double kRightAngle = std::numbers::pi / 2.0;
const world::Box kUnitBox{{0.5, 0.5, 0.5}};

void expect_point(const Vector3d& actual, const Vector3d& expected, double tolerance = 1e-9) {
  EXPECT_LT((actual - expected).norm(), tolerance) << actual.transpose() << " instead of " << expected.transpose();
}

TEST(SphereSphere, IsTheDistanceOfCentresMinusTheRadii) {
  // Centres 5 apart (3-4-5), radii 1 and 2.
  const ShapeDistance d = shape_distance(world::Sphere{1.0}, at(0, 0, 0), world::Sphere{2.0}, at(3, 4, 0));
  EXPECT_NEAR(d.distance, 2.0, 1e-12);
  expect_point(d.n_W, {0.6, 0.8, 0.0});
  expect_point(d.p_a_W, {0.6, 0.8, 0.0});
  expect_point(d.p_b_W, {1.8, 2.4, 0.0});
}

TEST(SphereSphere, HasTheDepthOfBothRadiiWhenConcentric) {
  const ShapeDistance d = shape_distance(world::Sphere{1.0}, at(1, 2, 3), world::Sphere{2.0}, at(1, 2, 3));
  EXPECT_NEAR(d.distance, -3.0, 1e-12);
  EXPECT_NEAR(d.n_W.norm(), 1.0, 1e-12);
}

TEST(SphereBox, IsExactOutsideFaceEdgeAndCorner) {
  const world::Sphere sphere{0.1};
  EXPECT_NEAR(shape_distance(sphere, at(1.5, 0.2, 0.1), kUnitBox, at(0, 0, 0)).distance, 0.9, 1e-12);
  EXPECT_NEAR(shape_distance(sphere, at(0.8, 0.9, 0.1), kUnitBox, at(0, 0, 0)).distance, 0.4, 1e-12);  // 3-4-5
  EXPECT_NEAR(shape_distance(sphere, at(0.6, 0.7, 0.7), kUnitBox, at(0, 0, 0)).distance, 0.2, 1e-12);  // 1-2-2-3
}

TEST(SphereBox, LeavesThroughTheNearestFaceFromInside) {
  const ShapeDistance d = shape_distance(world::Sphere{0.1}, at(0.1, -0.3, 0.2), kUnitBox, at(0, 0, 0));
  EXPECT_NEAR(d.distance, -0.3, 1e-12);  // 0.2 to the face y = −0.5, and the radius
  expect_point(d.n_W, {0.0, 1.0, 0.0});
  expect_point(d.p_a_W, {0.1, -0.2, 0.2});
  expect_point(d.p_b_W, {0.1, -0.5, 0.2});
}

TEST(SphereCylinder, IsExactOutsideSideCapAndRim) {
  const world::Sphere sphere{0.1};
  const world::Cylinder cylinder{0.5, 1.0};
  EXPECT_NEAR(shape_distance(sphere, at(0.6, 0.8, 0.3), cylinder, at(0, 0, 0)).distance, 0.4, 1e-12);
  EXPECT_NEAR(shape_distance(sphere, at(0.2, 0.1, -1.7), cylinder, at(0, 0, 0)).distance, 0.6, 1e-12);
  EXPECT_NEAR(shape_distance(sphere, at(0.0, 0.8, 1.4), cylinder, at(0, 0, 0)).distance, 0.4, 1e-12);  // 3-4-5
}

TEST(SphereCylinder, LeavesThroughSideOrCapFromInside) {
  const world::Sphere sphere{0.1};
  const world::Cylinder cylinder{0.5, 1.0};
  const ShapeDistance side = shape_distance(sphere, at(0.0, 0.4, 0.5), cylinder, at(0, 0, 0));
  EXPECT_NEAR(side.distance, -0.2, 1e-12);
  expect_point(side.n_W, {0.0, -1.0, 0.0});
  const ShapeDistance cap = shape_distance(sphere, at(0.0, 0.0, -0.8), cylinder, at(0, 0, 0));
  EXPECT_NEAR(cap.distance, -0.3, 1e-12);
  expect_point(cap.n_W, {0.0, 0.0, 1.0});
}

TEST(CapsuleCylinder, IsExactAtSideCapAndRim) {
  const world::Capsule capsule{0.1, 0.3};
  const world::Cylinder cylinder{0.5, 1.0};
  // Upright beside it; lying over the cap; lying across the axis, beyond the side.
  EXPECT_NEAR(shape_distance(capsule, at(0.9, 0, 0.2), cylinder, at(0, 0, 0)).distance, 0.3, 1e-9);
  EXPECT_NEAR(shape_distance(capsule, at(0.1, 0, 1.5, {0, kRightAngle, 0}), cylinder, at(0, 0, 0)).distance, 0.4, 1e-9);
  const ShapeDistance side = shape_distance(capsule, at(0.1, 0.8, 0.4, {0, kRightAngle, 0}), cylinder, at(0, 0, 0));
  EXPECT_NEAR(side.distance, 0.2, 1e-9);
  expect_point(side.n_W, {0, -1, 0}, 1e-8);
  expect_point(side.p_a_W, {0, 0.7, 0.4}, 1e-8);
  expect_point(side.p_b_W, {0, 0.5, 0.4}, 1e-8);
  // Along y, 0.3 outside the rim in x and 0.4 above it: 3-4-5.
  EXPECT_NEAR(shape_distance(capsule, at(0.8, 0, 1.4, {kRightAngle, 0, 0}), cylinder, at(0, 0, 0)).distance, 0.4, 1e-9);
  // Its end at (0.8, 0, 1.4).
  EXPECT_NEAR(shape_distance(capsule, at(0.8, 0, 1.7), cylinder, at(0, 0, 0)).distance, 0.4, 1e-9);
}

TEST(CapsuleCylinder, AgreesWithThePointsOfItsSegment) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> number(-1.0, 1.0);
  int apart = 0;
  for (int i = 0; i < 2000; ++i) {
    const auto draw = [&] { return Vector3d(number(random), number(random), number(random)); };
    const Vector3d place = draw();
    const Vector3d rpy = std::numbers::pi * draw();
    const Pose X_WA = at(place.x(), place.y(), place.z(), rpy);
    const world::Cylinder cylinder{0.05 + 0.2 * std::abs(number(random)), 0.05 + 0.3 * std::abs(number(random))};
    const double half = 0.4 * std::abs(number(random));
    const ShapeDistance d = shape_distance(world::Capsule{0.02, half}, X_WA, cylinder, at(0, 0, 0));
    // Points within 0.0002 of each other, and so within 0.0001 of the nearest one.
    double least = 1e9;
    const int steps = static_cast<int>(half / 1e-4) + 1;
    for (int k = 0; k <= steps; ++k) {
      const Vector3d p = X_WA * Vector3d(0, 0, half * (2.0 * k / steps - 1.0));
      const double side = std::max(std::hypot(p.x(), p.y()) - cylinder.radius, 0.0);
      least = std::min(least, std::hypot(side, std::max(std::abs(p.z()) - cylinder.half_length, 0.0)));
    }
    if (least < 1e-3) continue;
    ++apart;
    EXPECT_LE(d.distance, least - 0.02 + 1e-12);
    EXPECT_GE(d.distance, least - 0.02 - 1e-5) << "the square of half a step over twice the distance";
    EXPECT_NEAR((d.p_b_W - d.p_a_W).norm(), std::abs(d.distance), 1e-9);
  }
  EXPECT_GT(apart, 1000);
}

TEST(CapsuleCapsule, IsExactWhenCrossingApart) {
  // Axes along z and, turned about y, along x, 0.5 apart in y.
  const ShapeDistance d = shape_distance(world::Capsule{0.1, 1.0}, at(0, 0, 0), world::Capsule{0.2, 1.0},
                                         at(0.3, 0.5, 0.4, {0, kRightAngle, 0}));
  EXPECT_NEAR(d.distance, 0.2, 1e-12);
  expect_point(d.n_W, {0, 1, 0});
  expect_point(d.p_a_W, {0, 0.1, 0.4});
  expect_point(d.p_b_W, {0, 0.3, 0.4});
}

TEST(CapsuleCapsule, IsExactForParallelAndEndToEnd) {
  const world::Capsule capsule{0.1, 0.5};
  EXPECT_NEAR(shape_distance(capsule, at(0, 0, 0), capsule, at(0.5, 0, 0.2)).distance, 0.3, 1e-12);
  EXPECT_NEAR(shape_distance(capsule, at(0, 0, 0), capsule, at(0, 0, 1.5)).distance, 0.3, 1e-12);
  EXPECT_NEAR(shape_distance(capsule, at(0, 0, 0), capsule, at(0.3, 0, 1.4)).distance, 0.3, 1e-12);  // 3-4-5
}

TEST(CapsuleCapsule, SeparatesCrossingAxesAlongTheirCommonNormal) {
  const ShapeDistance d = shape_distance(world::Capsule{0.1, 1.0}, at(0, 0, 0), world::Capsule{0.2, 1.0},
                                         at(0.3, 0, 0.4, {0, kRightAngle, 0}));
  EXPECT_NEAR(d.distance, -0.3, 1e-12);
  EXPECT_NEAR(std::abs(d.n_W.y()), 1.0, 1e-12);
}

TEST(CapsuleCapsule, SeparatesCollinearOverlapSideways) {
  const ShapeDistance d =
      shape_distance(world::Capsule{0.1, 0.5}, at(0, 0, 0), world::Capsule{0.2, 0.5}, at(0, 0, 0.3));
  EXPECT_NEAR(d.distance, -0.3, 1e-12);
  EXPECT_NEAR(d.n_W.z(), 0.0, 1e-12);
}

TEST(CapsuleBox, IsExactAtFaceEdgeAndCorner) {
  const world::Capsule capsule{0.1, 0.3};
  EXPECT_NEAR(shape_distance(capsule, at(0.9, 0, 0), kUnitBox, at(0, 0, 0)).distance, 0.3, 1e-12);
  // Along y over the edge x = z = 0.5.
  EXPECT_NEAR(shape_distance(capsule, at(0.8, 0.0, 0.9, {kRightAngle, 0, 0}), kUnitBox, at(0, 0, 0)).distance, 0.4,
              1e-12);
  // Its lower end at (0.6, 0.7, 0.7): 1-2-2-3 from the corner.
  EXPECT_NEAR(shape_distance(capsule, at(0.6, 0.7, 1.0), kUnitBox, at(0, 0, 0)).distance, 0.2, 1e-12);
}

TEST(CapsuleBox, LeavesTheBoxOnTheShortestWay) {
  // The axis, along z, pierces the whole box, 0.1 inside the face x = 0.5.
  const ShapeDistance d = shape_distance(world::Capsule{0.1, 2.0}, at(0.4, 0, 0), kUnitBox, at(0, 0, 0));
  EXPECT_NEAR(d.distance, -0.2, 1e-12);
  expect_point(d.n_W, {-1, 0, 0});
  // Pushed in by 0.15 from above, upright.
  const ShapeDistance end = shape_distance(world::Capsule{0.05, 0.2}, at(0.1, 0.1, 0.55), kUnitBox, at(0, 0, 0));
  EXPECT_NEAR(end.distance, -0.2, 1e-12);
  expect_point(end.n_W, {0, 0, -1});
  expect_point(end.p_a_W, {0.1, 0.1, 0.3});
  expect_point(end.p_b_W, {0.1, 0.1, 0.5});
}

TEST(BoxBox, IsExactForFacesEdgesAndOverlap) {
  EXPECT_NEAR(shape_distance(kUnitBox, at(0, 0, 0), kUnitBox, at(1.3, 0.2, 0.1)).distance, 0.3, 1e-9);
  EXPECT_NEAR(shape_distance(kUnitBox, at(0, 0, 0), kUnitBox, at(1.3, 1.4, 0.1)).distance, 0.5, 1e-9);
  const ShapeDistance in = shape_distance(kUnitBox, at(0, 0, 0), kUnitBox, at(0.3, 0.2, 0.9));
  EXPECT_NEAR(in.distance, -0.1, 1e-9);
  expect_point(in.n_W, {0, 0, 1}, 1e-6);
  // Turned by 45° about z: half the diagonal reaches √½.
  const ShapeDistance corner = shape_distance(kUnitBox, at(0, 0, 0), kUnitBox, at(1.5, 0, 0, {0, 0, kRightAngle / 2}));
  EXPECT_NEAR(corner.distance, 1.0 - std::sqrt(0.5), 1e-9);
}

TEST(BoxBox, SeparatesEqualBoxesAlongTheShortestSide) {
  const world::Box box{{0.2, 0.5, 0.3}};
  const ShapeDistance d = shape_distance(box, at(1, 1, 1, {0.1, 0.2, 0.3}), box, at(1, 1, 1, {0.1, 0.2, 0.3}));
  EXPECT_NEAR(d.distance, -0.4, 1e-9);
}

TEST(CylinderCylinder, IsExactForParallelCoaxialAndCrossed) {
  const world::Cylinder cylinder{0.2, 0.5};
  EXPECT_NEAR(shape_distance(cylinder, at(0, 0, 0), cylinder, at(0.3, 0.4, 0.1)).distance, 0.1, 1e-6);
  EXPECT_NEAR(shape_distance(cylinder, at(0, 0, 0), cylinder, at(0, 0, 1.2)).distance, 0.2, 1e-6);
  EXPECT_NEAR(shape_distance(cylinder, at(0, 0, 0), cylinder, at(0.6, 0, 0, {kRightAngle, 0, 0})).distance, 0.2, 1e-6);
  EXPECT_NEAR(shape_distance(cylinder, at(0, 0, 0), cylinder, at(0, 0, 0.9)).distance, -0.1, 1e-6);
  EXPECT_NEAR(shape_distance(cylinder, at(0, 0, 0), cylinder, at(0.0, 0.3, 0)).distance, -0.1, 1e-6);
  // Coaxial and congruent: every radial direction is as good.
  EXPECT_NEAR(shape_distance(cylinder, at(0, 0, 0), cylinder, at(0, 0, 0)).distance, -0.4, 1e-4);
}

TEST(CylinderBox, IsExactWhenStandingAndLying) {
  const world::Cylinder cylinder{0.2, 0.3};
  EXPECT_NEAR(shape_distance(cylinder, at(0.1, 0.1, 0.8), kUnitBox, at(0, 0, 0)).distance, 0.0, 1e-6);
  EXPECT_NEAR(shape_distance(cylinder, at(0.1, 0.1, 0.75), kUnitBox, at(0, 0, 0)).distance, -0.05, 1e-6);
  EXPECT_NEAR(shape_distance(cylinder, at(0, 0, 0.8, {kRightAngle, 0, 0}), kUnitBox, at(0, 0, 0)).distance, 0.1, 1e-6);
}

TEST(CapsuleCylinder, IsExactBesideAndThrough) {
  const world::Cylinder cylinder{0.3, 0.5};
  EXPECT_NEAR(shape_distance(world::Capsule{0.1, 0.4}, at(0.7, 0, 0.2), cylinder, at(0, 0, 0)).distance, 0.3, 1e-6);
  // On the cylinder's own axis and longer than it: leaves sideways by both radii.
  EXPECT_NEAR(shape_distance(world::Capsule{0.1, 2.0}, at(0, 0, 0), cylinder, at(0, 0, 0)).distance, -0.4, 1e-4);
}

TEST(Convex, IsExactForOctahedronAndSquarePrism) {
  // An octahedron's face x + y + z = 1 is 1/√3 from its centre.
  const world::Convex octahedron = test::octahedron({1, 1, 1}, Vector3d::Zero());
  const double face = 1.0 / std::sqrt(3.0);
  EXPECT_NEAR(shape_distance(octahedron, at(0, 0, 0), world::Sphere{0.1}, at(1, 1, 1)).distance, 2.0 * face - 0.1,
              1e-9);
  EXPECT_NEAR(shape_distance(octahedron, at(0, 0, 0), world::Sphere{0.1}, at(0, 0, 0)).distance, -face - 0.1, 1e-9);
  EXPECT_NEAR(shape_distance(octahedron, at(0, 0, 0), kUnitBox, at(0, 0, 1.7)).distance, 0.2, 1e-9);
  // A square prism is a box; its vertices lie on x and y, so its faces are turned by 45°, at radius/√2.
  const world::Convex prism = test::prism(4, 0.5 * std::sqrt(2.0), 0.5, Vector3d::Zero());
  EXPECT_NEAR(shape_distance(prism, at(0, 0, 0, {0, 0, kRightAngle / 2}), kUnitBox, at(1.3, 1.4, 0.1)).distance, 0.5,
              1e-9);
}

TEST(FlatAndThin, AreExactForFloorAndNeedle) {
  const world::Box floor{{5.0, 5.0, 0.01}};
  const world::Capsule needle{0.001, 1.0};
  EXPECT_NEAR(shape_distance(needle, at(3, -4, 0.5, {0, kRightAngle, 0}), floor, at(0, 0, 0)).distance, 0.489, 1e-12);
  EXPECT_NEAR(shape_distance(floor, at(0, 0, 0), world::Box{{0.1, 0.1, 0.1}}, at(4.9, 4.9, 0.10)).distance, -0.01,
              1e-9);
  EXPECT_NEAR(shape_distance(floor, at(0, 0, 0), world::Cylinder{0.1, 0.1}, at(-4, 4, 0.12)).distance, 0.01, 1e-6);
}

}  // namespace
}  // namespace hecaton
