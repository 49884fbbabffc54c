/// Each result of shape_distance contains its proof: the points bound the distance from above, the normal from below.

#include "certificate.hpp"

#include <gtest/gtest.h>

#include "planner/collision/exact_distance.hpp"
#include "random_shapes.hpp"

namespace hecaton {
namespace {

using planner::shape_distance;
using planner::ShapeDistance;
using test::Kind;
using world::Pose;

constexpr double kExact = 1e-6;  ///< of a distance, as exact_distance.hpp promises [m]

class EveryPair : public testing::TestWithParam<std::tuple<int, int>> {
 protected:
  [[nodiscard]] Kind kind_a() const { return static_cast<Kind>(std::get<0>(GetParam())); }
  [[nodiscard]] Kind kind_b() const { return static_cast<Kind>(std::get<1>(GetParam())); }
  test::Random random_{static_cast<unsigned>(1000 + 10 * std::get<0>(GetParam()) + std::get<1>(GetParam()))};
};

/// How far from a shape its nearest point may be [m].
double on_shape(const world::Shape& a, const world::Shape& b) {
  return std::holds_alternative<world::Cylinder>(a) || std::holds_alternative<world::Cylinder>(b) ? 1e-4 : 1e-6;
}

void expect_certified(const world::Shape& a, const Pose& X_WA, const world::Shape& b, const Pose& X_WB,
                      const ShapeDistance& d) {
  ASSERT_NEAR(d.n_W.norm(), 1.0, 1e-9);
  ASSERT_LT((d.p_b_W - d.p_a_W - d.distance * d.n_W).norm(), 1e-9);
  EXPECT_LT(test::outside(a, X_WA, d.p_a_W), on_shape(a, b)) << "p_a is not on a";
  EXPECT_LT(test::outside(b, X_WB, d.p_b_W), on_shape(a, b)) << "p_b is not on b";
  EXPECT_NEAR(test::depth_along(a, X_WA, b, X_WB, d.n_W), -d.distance, kExact) << "n does not part them so far";
}

TEST_P(EveryPair, PointsAndNormalProveTheDistance) {
  int separated = 0;
  int penetrating = 0;
  for (int trial = 0; trial < 400; ++trial) {
    const auto a = test::random_shape(kind_a(), random_);
    const auto b = test::random_shape(kind_b(), random_);
    const Pose X_WA = test::random_pose(random_, 0.35);
    const Pose X_WB = test::random_pose(random_, 0.35);
    const ShapeDistance d = shape_distance(a, X_WA, b, X_WB);
    (d.distance > 0.0 ? separated : penetrating) += 1;
    SCOPED_TRACE(testing::Message() << "trial " << trial << ", distance " << d.distance);
    expect_certified(a, X_WA, b, X_WB, d);
    if (HasFailure()) return;
  }
  EXPECT_GT(separated, 40);
  EXPECT_GT(penetrating, 40);
}

// A larger depth would be safe, but would move an arm in a wrong direction.
TEST_P(EveryPair, NoSampledDirectionSeparatesSooner) {
  for (int trial = 0; trial < 60; ++trial) {
    const auto a = test::random_shape(kind_a(), random_);
    const auto b = test::random_shape(kind_b(), random_);
    const Pose X_WA = test::random_pose(random_, 0.1);
    const Pose X_WB = test::random_pose(random_, 0.1);
    const ShapeDistance d = shape_distance(a, X_WA, b, X_WB);
    for (int sample = 0; sample < 3000; ++sample) {
      const Eigen::Vector3d n = test::random_direction(random_);
      ASSERT_GT(test::depth_along(a, X_WA, b, X_WB, n), -d.distance - kExact) << "trial " << trial;
    }
  }
}

TEST_P(EveryPair, MovingAgainstTheNormalSeparates) {
  for (int trial = 0; trial < 100; ++trial) {
    const auto a = test::random_shape(kind_a(), random_);
    const auto b = test::random_shape(kind_b(), random_);
    const Pose X_WA = test::random_pose(random_, 0.2);
    const Pose X_WB = test::random_pose(random_, 0.2);
    const ShapeDistance before = shape_distance(a, X_WA, b, X_WB);
    // Just past touching, and a little further than before.
    for (const double step : {std::max(-before.distance, 0.0) + 1e-3, 1e-3}) {
      Pose X_WA_moved = X_WA;
      X_WA_moved.translation() -= step * before.n_W;
      const ShapeDistance after = shape_distance(a, X_WA_moved, b, X_WB);
      EXPECT_NEAR(after.distance, before.distance + step, 1e-5) << "trial " << trial << ", step " << step;
    }
  }
}

// Approach through contact in steps of a micrometre, where GJK's direction is noise.
TEST_P(EveryPair, StaysExactThroughTouching) {
  for (int trial = 0; trial < 20; ++trial) {
    const auto a = test::random_shape(kind_a(), random_);
    const auto b = test::random_shape(kind_b(), random_);
    const Pose X_WA = test::random_pose(random_, 0.0);
    Pose X_WB = test::random_pose(random_, 0.0);
    X_WB.translation() = 2.0 * test::random_direction(random_);
    const ShapeDistance far = shape_distance(a, X_WA, b, X_WB);
    for (const double gap :
         {1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-10, 1e-14, 0.0, -1e-10, -1e-8, -1e-7, -1e-6, -1e-5, -1e-4, -1e-3}) {
      Pose X_WB_near = X_WB;
      X_WB_near.translation() -= (far.distance - gap) * far.n_W;
      const ShapeDistance d = shape_distance(a, X_WA, b, X_WB_near);
      SCOPED_TRACE(testing::Message() << "trial " << trial << ", gap " << gap);
      // In penetration another direction may be shorter than the way back.
      EXPECT_GT(d.distance, gap - 1e-6);
      EXPECT_LT(d.distance, std::max(gap, 0.0) + 1e-6);
      expect_certified(a, X_WA, b, X_WB_near, d);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Shapes, EveryPair,
                         testing::Combine(testing::Range(0, test::kKinds), testing::Range(0, test::kKinds)),
                         [](const auto& pair) {
                           return std::string(test::kKindNames[std::get<0>(pair.param)]) +
                                  test::kKindNames[std::get<1>(pair.param)];
                         });

}  // namespace
}  // namespace hecaton
