#include "planner/model/capsules.hpp"

#include <gtest/gtest.h>

namespace hecaton::planner {
namespace {

world::PlacedShape at(const world::Shape& shape, const Eigen::Vector3d& p,
                      const Eigen::Matrix3d& R = Eigen::Matrix3d::Identity()) {
  world::PlacedShape placed{shape, world::Pose::Identity()};
  placed.X_BS.translation() = p;
  placed.X_BS.linear() = R;
  return placed;
}

/// z → x
const Eigen::Matrix3d kAlongX = Eigen::AngleAxisd(1.5707963267948966, Eigen::Vector3d::UnitY()).toRotationMatrix();

TEST(CapsuleMerge, CylinderWithTwoCapsIsACapsule) {
  const auto merged =
      merge_capsules({at(world::Sphere{0.1}, {1.5, 0, 0}), at(world::Cylinder{0.1, 0.5}, {1, 0, 0}, kAlongX),
                      at(world::Sphere{0.1}, {0.5, 0, 0})});
  ASSERT_EQ(merged.size(), 1U);
  const auto& capsule = std::get<world::Capsule>(merged[0].shape);
  EXPECT_DOUBLE_EQ(capsule.radius, 0.1);
  EXPECT_DOUBLE_EQ(capsule.half_length, 0.5);
  EXPECT_TRUE(merged[0].X_BS.translation().isApprox(Eigen::Vector3d(1, 0, 0)));
  EXPECT_TRUE(merged[0].X_BS.linear().isApprox(kAlongX));
}

TEST(CapsuleMerge, OneCapOrAnotherRadiusStaysSeparate) {
  EXPECT_EQ(merge_capsules({at(world::Cylinder{0.1, 0.5}, {0, 0, 0}), at(world::Sphere{0.1}, {0, 0, 0.5})}).size(), 2U);
  EXPECT_EQ(merge_capsules({at(world::Cylinder{0.1, 0.5}, {0, 0, 0}), at(world::Sphere{0.1}, {0, 0, 0.5}),
                            at(world::Sphere{0.09}, {0, 0, -0.5})})
                .size(),
            3U);
  EXPECT_EQ(merge_capsules({at(world::Cylinder{0.1, 0.5}, {0, 0, 0}), at(world::Sphere{0.1}, {0, 0, 0.5}),
                            at(world::Sphere{0.1}, {0, 0, -0.499})})
                .size(),
            3U);
}

TEST(CapsuleMerge, ASphereIsUsedOnce) {
  // Two cylinders end in the same ball: the first becomes a capsule, the second keeps its other ball.
  const auto merged =
      merge_capsules({at(world::Cylinder{0.1, 0.5}, {0, 0, 0.5}), at(world::Cylinder{0.1, 0.5}, {0, 0, 1.5}),
                      at(world::Sphere{0.1}, {0, 0, 0}), at(world::Sphere{0.1}, {0, 0, 1}),
                      at(world::Sphere{0.1}, {0, 0, 2}), at(world::Box{{1, 1, 1}}, {0, 0, 0})});
  ASSERT_EQ(merged.size(), 4U);
  EXPECT_TRUE(std::holds_alternative<world::Capsule>(merged[0].shape));
  EXPECT_TRUE(std::holds_alternative<world::Cylinder>(merged[1].shape));
  EXPECT_TRUE(std::holds_alternative<world::Sphere>(merged[2].shape));
  EXPECT_TRUE(std::holds_alternative<world::Box>(merged[3].shape));
}

}  // namespace
}  // namespace hecaton::planner
