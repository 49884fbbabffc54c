#include "planner/model/convex_hull.hpp"

#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <set>
#include <stdexcept>

#include <gtest/gtest.h>

namespace hecaton::planner {
namespace {

using Points = std::vector<Eigen::Vector3d>;

double area(const world::ConvexHull& hull, int f) {
  const auto& face = hull.faces[f];
  Eigen::Vector3d twice = Eigen::Vector3d::Zero();
  for (std::size_t i = 2; i < face.size(); ++i) {
    twice +=
        (hull.vertices[face[i - 1]] - hull.vertices[face[0]]).cross(hull.vertices[face[i]] - hull.vertices[face[0]]);
  }
  return 0.5 * twice.norm();
}

/// Closed, convex, and with every point inside: Euler's formula, each edge once in either direction, no point above a
/// face by more than the hull's promise.
void expect_valid(const world::ConvexHull& hull, const Points& points) {
  Eigen::AlignedBox3d box;
  for (const auto& p : points) box.extend(p);
  const double extent = box.sizes().maxCoeff();
  const double tolerance = 1e-11 * extent;
  std::set<std::pair<int, int>> edges;
  for (const auto& face : hull.faces) {
    for (std::size_t i = 0; i < face.size(); ++i) {
      ASSERT_TRUE(edges.emplace(face[i], face[(i + 1) % face.size()]).second) << "an edge used twice";
    }
  }
  for (const auto& [a, b] : edges) ASSERT_TRUE(edges.contains({b, a})) << "an open edge";
  ASSERT_EQ(hull.vertices.size() + hull.faces.size(), edges.size() / 2 + 2);
  for (int f = 0; f < static_cast<int>(hull.faces.size()); ++f) {
    const FacePlane plane = face_plane(hull, f);
    // A sliver's normal is no better than its area; the promise is about the volume enclosed.
    if (area(hull, f) < 1e-5 * extent * extent) continue;
    for (const auto& p : points) ASSERT_LE(plane.normal.dot(p) - plane.offset, tolerance);
  }
}

TEST(ConvexHull, CubeWithPointsOnFacesEdgesAndInside) {
  Points points;
  for (int x = 0; x <= 4; ++x) {
    for (int y = 0; y <= 4; ++y) {
      for (int z = 0; z <= 4; ++z) points.emplace_back(0.5 * x, 0.5 * y, 0.5 * z);
    }
  }
  const auto hull = convex_hull(points);
  ASSERT_TRUE(hull);
  expect_valid(*hull, points);
  EXPECT_EQ(hull->vertices.size(), 8U);  // only the corners of the cube of side 2
  EXPECT_EQ(hull->faces.size(), 6U);
  EXPECT_NEAR(volume(*hull), 8.0, 1e-12);
}

TEST(ConvexHull, Tetrahedron) {
  const Points points{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0.1, 0.1, 0.1}};
  const auto hull = convex_hull(points);
  ASSERT_TRUE(hull);
  EXPECT_EQ(hull->vertices.size(), 4U);
  EXPECT_NEAR(volume(*hull), 1.0 / 6.0, 1e-12);
}

TEST(ConvexHull, RotatedCylinderHasThePrismsVolume) {
  // A prism over a regular n-gon of circumradius r: volume = h · n/2 · r² sin(2π/n).
  constexpr int kSides = 100;
  const Eigen::AngleAxisd turn(0.7, Eigen::Vector3d(1, 2, 3).normalized());
  Points points;
  for (int i = 0; i < kSides; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / kSides;
    for (const double z : {0.0, 0.3, 0.5}) {  // the middle ring lies in the side faces
      points.push_back(turn * Eigen::Vector3d(0.2 * std::cos(angle), 0.2 * std::sin(angle), z));
    }
  }
  const auto hull = convex_hull(points);
  ASSERT_TRUE(hull);
  expect_valid(*hull, points);
  EXPECT_NEAR(volume(*hull), 0.5 * kSides / 2.0 * 0.04 * std::sin(2.0 * std::numbers::pi / kSides), 1e-9);
}

TEST(ConvexHull, RandomCloudsOfEveryShape) {
  std::mt19937_64 random(11);
  std::normal_distribution<double> normal;
  for (int trial = 0; trial < 300; ++trial) {
    const Eigen::Vector3d stretch(1.0, std::pow(10.0, -(trial % 4)), std::pow(10.0, -(trial % 3)));
    const Eigen::Vector3d shift = 3.0 * Eigen::Vector3d(normal(random), normal(random), normal(random));
    Points points;
    const int count = 4 + static_cast<int>(random() % 300);
    for (int i = 0; i < count; ++i) {
      Eigen::Vector3d p(normal(random), normal(random), normal(random));
      if (trial % 2 == 0) p.normalize();                  // every point a vertex
      if (trial % 5 == 0) p = (p * 4.0).array().round();  // many coplanar, collinear and equal points
      points.push_back(p.cwiseProduct(stretch) + shift);
    }
    const auto hull = convex_hull(points);
    if (!hull) {
      ASSERT_EQ(trial % 5, 0);  // only the rounded ones can be flat
      continue;
    }
    expect_valid(*hull, points);
    if (HasFatalFailure()) FAIL() << "trial " << trial;
    ASSERT_GT(volume(*hull), 0.0);
  }
}

/// Points of a grid that lie in its sides but for noise: most of them are neither clearly outside nor clearly inside.
TEST(ConvexHull, IsClosedAroundNearlyCoplanarPoints) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  for (int trial = 0; trial < 100; ++trial) {
    const double noise = std::pow(10.0, -6 - trial % 11);
    const double thin = std::pow(10.0, -(trial % 5));
    const Eigen::AngleAxisd turn(normal(random), Eigen::Vector3d(1.0, 2.0, normal(random)).normalized());
    Points points;
    for (int i = 0; i < 512; ++i) {
      const Eigen::Vector3d p(0.1 * (i % 8), 0.1 * (i / 8 % 8), 0.1 * thin * (i / 64));
      points.push_back(turn * p + noise * Eigen::Vector3d(normal(random), normal(random), normal(random)));
    }
    const auto hull = convex_hull(points);
    ASSERT_TRUE(hull) << "trial " << trial;
    expect_valid(*hull, points);
    if (HasFatalFailure()) FAIL() << "trial " << trial;
    EXPECT_NEAR(volume(*hull), 0.343 * thin, 10.0 * noise) << "trial " << trial;
  }
}

TEST(ConvexShape, NamesAPointThatIsNotFinite) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  try {
    static_cast<void>(convex_shape(Points{{0, 0, 0}, {1, 0, 0}, {0, nan, 0}, {0, 0, 1}}));
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_STREQ(error.what(), "points[2] must be finite");
  }
}

TEST(ConvexHull, IsEmptyForFlatThinOrNonFiniteSets) {
  EXPECT_FALSE(convex_hull(Points{}));
  EXPECT_FALSE(convex_hull(Points{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}));
  EXPECT_FALSE(convex_hull(Points(10, Eigen::Vector3d(1, 2, 3))));
  Points plane;
  for (int i = 0; i < 50; ++i) plane.emplace_back(std::cos(i), std::sin(i), 0.2 * std::cos(i) + 0.1 * std::sin(i));
  EXPECT_FALSE(convex_hull(plane));
  EXPECT_FALSE(convex_hull(Points{{0, 0, 0}, {1, 1, 1}, {2, 2, 2}, {3, 3, 3}, {4, 4, 4}}));
  EXPECT_FALSE(convex_hull(Points{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, NAN}}));
  EXPECT_TRUE(convex_hull(Points{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1e-4}}));
}

}  // namespace
}  // namespace hecaton::planner
