/// Distances of random pairs of all shapes against Bullet's.

#include <gtest/gtest.h>

#include "bullet_oracle.hpp"
#include "certificate.hpp"
#include "planner/collision/exact_distance.hpp"
#include "random_shapes.hpp"

namespace hecaton {
namespace {

using planner::ShapeDistance;
using test::Kind;

class Pair : public testing::TestWithParam<std::tuple<int, int>> {
 protected:
  struct Sample {
    world::Shape a;
    world::Shape b;
    world::Pose X_WA;
    world::Pose X_WB;
    ShapeDistance ours;
    std::optional<ShapeDistance> bullet;
  };

  Sample draw(double reach) {
    Sample s{test::random_shape(static_cast<Kind>(std::get<0>(GetParam())), random_),
             test::random_shape(static_cast<Kind>(std::get<1>(GetParam())), random_),
             test::random_pose(random_, reach),
             test::random_pose(random_, reach),
             {},
             {}};
    s.ours = planner::shape_distance(s.a, s.X_WA, s.b, s.X_WB);
    s.bullet = test::bullet_distance(s.a, s.X_WA, s.b, s.X_WB);
    return s;
  }

  test::Random random_{static_cast<unsigned>(4000 + 10 * std::get<0>(GetParam()) + std::get<1>(GetParam()))};
};

TEST_P(Pair, SeparatedDistancesAgree) {
  int compared = 0;
  for (int trial = 0; trial < 1500; ++trial) {
    const Sample s = draw(0.6);
    if (!s.bullet || s.ours.distance < 1e-3) continue;
    ++compared;
    EXPECT_NEAR(s.ours.distance, s.bullet->distance, 1e-4) << "trial " << trial;
    // Nearest points on round or flat parts are ill-conditioned; the normal is not.
    EXPECT_GT(s.ours.n_W.dot(s.bullet->n_W), 1.0 - 1e-4 / s.ours.distance) << "trial " << trial;
  }
  EXPECT_GT(compared, 300);
}

TEST_P(Pair, BulletFindsNoSmallerPenetration) {
  int compared = 0;
  int agreed = 0;
  for (int trial = 0; trial < 800; ++trial) {
    const Sample s = draw(0.15);
    if (!s.bullet || s.ours.distance > -1e-3) continue;
    ++compared;
    // Bullet's depth is sometimes wrong. The depth along its direction, by support functions, is not.
    const double bullet_depth = test::depth_along(s.a, s.X_WA, s.b, s.X_WB, s.bullet->n_W.normalized());
    EXPECT_GT(bullet_depth, -s.ours.distance - 1e-6) << "trial " << trial;
    agreed += std::abs(s.ours.distance - s.bullet->distance) < 1e-4;
  }
  EXPECT_GT(compared, 100);
  RecordProperty("compared", compared);
  RecordProperty("agreed", agreed);
  EXPECT_GT(agreed, 0.98 * compared);
}

INSTANTIATE_TEST_SUITE_P(Shapes, Pair,
                         testing::Combine(testing::Range(0, test::kKinds), testing::Range(0, test::kKinds)),
                         [](const auto& pair) {
                           return std::string(test::kKindNames[std::get<0>(pair.param)]) +
                                  test::kKindNames[std::get<1>(pair.param)];
                         });

}  // namespace
}  // namespace hecaton
