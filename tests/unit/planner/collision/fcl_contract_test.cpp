/// Clearances never exceed FCL's distances of the links' and obstacles' own shapes.

#include <fcl/narrowphase/collision_object.h>
#include <fcl/narrowphase/distance.h>
#include <gtest/gtest.h>

#include "planner/collision/exact_distance.hpp"
#include "random_cell.hpp"
#include "tests/support/fcl_shape.hpp"

namespace hecaton::planner {
namespace {

constexpr int kCapacity = 4096;     // more than any of these cells has pairs
constexpr double kFar = 100.0;      // every pair is nearer [m]
constexpr double kAccuracy = 2e-6;  // ours and FCL's together [m]

/// A random cell in FCL.
class FclCell {
 public:
  explicit FclCell(const test::RandomCell& cell) : cell_(cell) {
    const CellGeometry& geometry = cell.geometry();
    for (int arm = 0; arm < static_cast<int>(geometry.arms().size()); ++arm) {
      arms_.push_back(objects(geometry.arm_bodies(arm)));
    }
    for (int i = 0; i < geometry.obstacle_count(); ++i) obstacles_.push_back(objects(geometry.obstacle_bodies(i)));
  }

  void place() {
    const CellGeometry& geometry = cell_.geometry();
    const CellPoses poses = cell_.poses();
    for (std::size_t arm = 0; arm < arms_.size(); ++arm) {
      for (std::size_t i = 0; i < arms_[arm].size(); ++i) {
        const Body& body = geometry.arm_bodies(static_cast<int>(arm))[i];
        arms_[arm][i].setTransform(poses.arms[arm].X_WL[body.link] * body.X_CS);
      }
    }
    for (std::size_t k = 0; k < obstacles_.size(); ++k) {
      for (std::size_t i = 0; i < obstacles_[k].size(); ++i) {
        const Body& body = geometry.obstacle_bodies(static_cast<int>(k))[i];
        obstacles_[k][i].setTransform(poses.obstacles[k].X_WO * body.X_CS);
      }
    }
  }

  /// FCL's distance of the same pair [m]; ≤ 0: overlap.
  double distance(const Clearance& pair) {
    const bool with_arm = pair.counterpart != Counterpart::kObstacle;
    const auto& other = with_arm ? arms_[pair.other][pair.other_body] : obstacles_[pair.other][pair.other_body];
    fcl::DistanceRequestd request;
    fcl::DistanceResultd result;
    return fcl::distance(&arms_[cell_.geometry().self()][pair.own_body], &other, request, result);
  }

 private:
  static std::vector<fcl::CollisionObjectd> objects(const std::vector<Body>& bodies) {
    std::vector<fcl::CollisionObjectd> all;
    for (const Body& body : bodies) all.emplace_back(test::fcl_shape(body.shape));
    return all;
  }

  const test::RandomCell& cell_;
  std::vector<std::vector<fcl::CollisionObjectd>> arms_;
  std::vector<std::vector<fcl::CollisionObjectd>> obstacles_;
};

TEST(FclContract, NeverReportsMoreClearanceThanFclDoes) {
  long pairs = 0;
  long apart = 0;
  std::vector<Clearance> ours(kCapacity);
  for (std::uint64_t seed = 1; pairs < 1'000'000; ++seed) {
    test::RandomCell cell(seed, LinkShapes::kFast);
    FclCell fcl(cell);
    ExactDistance pass(cell.geometry());
    for (int pose = 0; pose < 20; ++pose) {
      cell.shuffle();
      fcl.place();
      const int count = pass.clearances(cell.poses(), {kFar, kFar, {}}, ours);
      for (int i = 0; i < count; ++i) {
        const double theirs = std::max(0.0, fcl.distance(ours[i]));
        ASSERT_LE(ours[i].distance, theirs + kAccuracy) << "seed " << seed << ", pose " << pose << ", pair " << i;
        apart += theirs > 0.0 ? 1 : 0;
      }
      pairs += count;
    }
  }
  EXPECT_GT(apart, pairs / 2);
}

}  // namespace
}  // namespace hecaton::planner
