/// Bounds on the reach of arms, and on the distances between arms.

#include <gtest/gtest.h>

#include "planner/collision/exact_distance.hpp"
#include "planner/model/arm.hpp"
#include "random_cell.hpp"

namespace hecaton::planner {
namespace {

TEST(ArmReach, ContainsEveryBodyInEveryConfiguration) {
  double fullest = 0.0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    test::RandomCell cell(seed);
    for (int pose = 0; pose < 200; ++pose) {
      cell.shuffle();
      for (std::size_t arm = 0; arm < cell.geometry().arms().size(); ++arm) {
        const world::BoundingSphere& reach = cell.geometry().arm_reach(static_cast<int>(arm));
        for (const Body& body : cell.geometry().arm_bodies(static_cast<int>(arm))) {
          const Eigen::Vector3d centre_W = cell.poses().arms[arm].X_WL[body.link] * body.bound.centre;
          const double out = (centre_W - reach.centre).norm() + body.bound.radius;
          EXPECT_LE(out, reach.radius + 1e-12);
          fullest = std::max(fullest, out / reach.radius);
        }
      }
    }
  }
  EXPECT_GT(fullest, 0.5) << "the bounds are too large to cull pairs";
}

TEST(ArmReach, ContainsTheTool) {
  double fullest = 0.0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    test::RandomCell cell(seed);
    for (int pose = 0; pose < 200; ++pose) {
      cell.shuffle();
      for (std::size_t i = 0; i < cell.geometry().arms().size(); ++i) {
        const Arm& arm = cell.geometry().arms()[i];
        const ArmReach reach = arm_reach(arm);
        const Pose X_WT = cell.poses().arms[i].X_WL[arm.model->tool_link] * arm.model->X_LT;
        const double out = (X_WT.translation() - reach.centre).norm();
        EXPECT_LE(out, reach.tool + 1e-12);
        fullest = std::max(fullest, out / reach.tool);
      }
    }
  }
  EXPECT_GT(fullest, 0.5);
}

TEST(ArmReach, GapNeverExceedsTheDistance) {
  std::vector<Clearance> found(4096);
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    test::RandomCell cell(seed);
    ExactDistance pass(cell.geometry());
    for (int pose = 0; pose < 20; ++pose) {
      cell.shuffle();
      const int count = pass.clearances(cell.poses(), {10.0, 0.0, {}}, found);
      for (int i = 0; i < count; ++i) {
        if (found[i].counterpart != Counterpart::kArm) continue;
        EXPECT_LE(cell.geometry().gap_to_arm(found[i].other), found[i].distance);
      }
    }
  }
}

}  // namespace
}  // namespace hecaton::planner
