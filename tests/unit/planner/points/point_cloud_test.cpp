#include "world/model/point_cloud.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <set>
#include <stdexcept>

#include <gtest/gtest.h>

#include "tests/unit/planner/points/clouds.hpp"

namespace hecaton::world {
namespace {

using test::CloudPoints;
using test::Random;

/// Each point is below the root once, and in all boxes above it.
void expect_complete(const PointCloud& cloud, int node, const PointBox& around, std::size_t& points) {
  const PointNode& at = cloud.nodes()[static_cast<std::size_t>(node)];
  ASSERT_GE(at.count, 1);
  ASSERT_LE(at.count, kPointFan);
  for (int k = 0; k < at.count; ++k) {
    PointBox box{};
    for (int axis = 0; axis < 3; ++axis) {
      box.low[axis] = at.low[axis][k];
      box.high[axis] = at.high[axis][k];
      ASSERT_GE(box.low[axis], around.low[axis]);
      ASSERT_LE(box.high[axis], around.high[axis]);
    }
    if (at.child[k] >= 0) {
      expect_complete(cloud, at.child[k], box, points);
      continue;
    }
    const PointLeaf& leaf = cloud.leaves()[static_cast<std::size_t>(~at.child[k])];
    points += static_cast<std::size_t>(leaf.count);
    for (int i = 0; i < kPointFan; ++i) {
      for (int axis = 0; axis < 3; ++axis) {
        ASSERT_GE(leaf.p[axis][i], box.low[axis]);
        ASSERT_LE(leaf.p[axis][i], box.high[axis]);
      }
    }
  }
}

TEST(PointCloud, TreeHoldsEachPointOnce) {
  Random random(1);
  for (const int count : {1, 2, 15, 16, 17, 33, 255, 256, 257, 5000, 100'000}) {
    const PointCloud cloud(test::random_points(count, random), 0.01);
    std::size_t points = 0;
    expect_complete(cloud, 0, cloud.box(), points);
    EXPECT_EQ(points, cloud.size()) << count;
    EXPECT_EQ(cloud.size(), static_cast<std::size_t>(count));
    for (const Eigen::Vector3f& point : cloud.points()) {
      EXPECT_LE((point.cast<double>() - cloud.centre()).norm() + cloud.radius(), cloud.bounding_radius() + 1e-12);
    }
  }
}

TEST(PointCloud, DoesNotDependOnTheOrderOfItsPoints) {
  Random random(2);
  CloudPoints points = test::random_points(3000, random);
  points[7] = Eigen::Vector3f(-0.0F, 0.0F, 0.0F);
  points[8] = Eigen::Vector3f(0.0F, -0.0F, 0.0F);  // the same point
  const PointCloud one(points, 0.01);
  points.insert(points.end(), points.begin(), points.begin() + 100);
  std::shuffle(points.begin(), points.end(), random);
  const PointCloud two(points, 0.01);
  EXPECT_EQ(one.size(), 2999U);
  ASSERT_EQ(one.size(), two.size());
  ASSERT_EQ(one.nodes().size(), two.nodes().size());
  EXPECT_EQ(std::memcmp(one.points().data(), two.points().data(), one.size() * sizeof(Eigen::Vector3f)), 0);
  EXPECT_EQ(std::memcmp(one.leaves().data(), two.leaves().data(), one.leaves().size_bytes()), 0);
}

void expect_rejected(CloudPoints points, double radius, const std::string& sentence) {
  try {
    const PointCloud cloud(std::move(points), radius);
    ADD_FAILURE() << "accepted: " << sentence;
  } catch (const std::invalid_argument& error) {
    EXPECT_EQ(error.what(), sentence);
  }
}

TEST(PointCloud, RejectsWhatIsNoCloud) {
  const Eigen::Vector3f origin = Eigen::Vector3f::Zero();
  expect_rejected({}, 0.01, "a cloud must have 1 to 100000 points, not 0");
  expect_rejected(CloudPoints(100'001, origin), 0.01, "a cloud must have 1 to 100000 points, not 100001");
  expect_rejected({origin}, 0.0, "radius = 0.000000 m must be finite and > 0");
  expect_rejected({origin}, std::numeric_limits<double>::quiet_NaN(), "radius = nan m must be finite and > 0");
  expect_rejected({origin, Eigen::Vector3f(0.0F, HUGE_VALF, 0.0F)}, 0.01, "point 2 of 2 must have finite coordinates");
}

}  // namespace
}  // namespace hecaton::world
