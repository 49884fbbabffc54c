/// Configurations and edges among point clouds: never more permissive than the distances of the balls.

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "planner/collision/exact_distance.hpp"
#include "planner/global/plan.hpp"
#include "planner/global/space.hpp"
#include "planner/global/validity.hpp"
#include "planner/local/random.hpp"
#include "tests/support/puma_among_boxes.hpp"
#include "tests/unit/planner/collision/random_cell.hpp"
#include "tests/unit/planner/points/clouds.hpp"

namespace hecaton::planner::global {
namespace {

using Floats = std::vector<float>;

/// A cloud around an arm: a table, boxes, or points anywhere.
std::vector<WorldBody> random_cloud(int count, test::Random& random, double away) {
  WorldBody body;
  body.name = "cloud";
  body.shape = world::Points{test::cloud_of(test::random_points(count, random), test::uniform(random, 0.005, 0.02))};
  body.X_WS = test::random_pose(random, 0.1);
  body.X_WS.translation() += away * test::random_direction(random);
  return {body};
}

/// The smallest distance of a moving body from the cloud [m], by all balls or by the search that other tests compare
/// with all balls.
double distance(const Validity& validity, const std::vector<WorldBody>& world, const float* q, bool all_balls) {
  const CellGeometry& geometry = validity.planned().front();
  const Arm& arm = geometry.own_arm();
  JointVector joints(arm.model->joints());
  for (Eigen::Index j = 0; j < joints.size(); ++j) joints[j] = static_cast<double>(q[j]);
  Kinematics kinematics;
  forward_kinematics(*arm.model, arm.X_WB, joints, kinematics);
  double least = std::numeric_limits<double>::infinity();
  for (const Body& body : geometry.own_bodies()) {
    if (!body.moves) continue;
    const Pose X_WS = kinematics.X_WL[body.link] * body.X_CS;
    for (const WorldBody& other : world) {
      const auto& cloud = *std::get<world::Points>(other.shape).cloud;
      if (!all_balls) {
        least = std::min(least, shape_distance(body.shape, X_WS, other.shape, other.X_WS).distance);
        continue;
      }
      for (const Eigen::Vector3f& point : cloud.points()) {
        const Pose X_WB(Eigen::Translation3d(other.X_WS * point.cast<double>()));
        least = std::min(least, shape_distance(body.shape, X_WS, world::Sphere{cloud.radius()}, X_WB).distance);
      }
    }
  }
  return least;
}

struct Tally {
  int states = 0;
  int free = 0;
  int permissive = 0;
  int missed = 0;  ///< not free although clear of the cloud
};

void compare_states(const Validity& validity, const std::vector<WorldBody>& world, const Validity& without, int count,
                    bool all_balls, Random& random, Tally& tally) {
  const Space space = space_of(without);
  Floats eight(static_cast<std::size_t>(kWidth) * space.stride);
  for (int i = 0; i < count; i += kWidth) {
    for (int lane = 0; lane < kWidth; ++lane) space.sample(random, eight.data() + lane * space.stride);
    const unsigned own = without.collisions(eight.data());
    for (const ValidityKernel* kernel : supported_kernels()) {
      const unsigned collisions = validity.collisions(*kernel, eight.data());
      for (int lane = 0; lane < kWidth; ++lane) {
        if ((own >> lane & 1U) != 0) continue;  // by itself
        const bool free = (collisions >> lane & 1U) == 0;
        const double least = distance(validity, world, eight.data() + lane * space.stride, all_balls);
        ++tally.states;
        tally.free += free ? 1 : 0;
        tally.permissive += free && least < 0.0 ? 1 : 0;
        tally.missed += !free && least > 3e-4 ? 1 : 0;
      }
    }
  }
}

void expect_sound(const Tally& tally) {
  EXPECT_EQ(tally.permissive, 0) << "of " << tally.states;
  EXPECT_EQ(tally.missed, 0) << "of " << tally.states;
  EXPECT_GT(tally.free, tally.states / 20);
  EXPECT_LT(tally.free, tally.states);
}

TEST(CloudValidity, IsNeverMorePermissiveThanAllBalls) {
  test::Random places(41);
  Random random(41);
  Tally tally;
  for (int scene = 0; scene < 10; ++scene) {
    const auto world = random_cloud(150, places, 0.7);
    const Validity validity({CellGeometry({test::puma()}, 0)}, world);
    const Validity without({CellGeometry({test::puma()}, 0)}, {});
    compare_states(validity, world, without, 160, true, random, tally);
  }
  expect_sound(tally);
}

TEST(CloudValidity, IsNeverMorePermissiveForManyPointsAndAllShapes) {
  test::Random places(42);
  Random random(42);
  Tally tally;
  for (int seed = 0; seed < 30; ++seed) {
    test::RandomCell cell(static_cast<std::uint64_t>(seed), LinkShapes::kExact, 1, 2);
    CellGeometry geometry = cell.geometry();
    geometry.set_obstacles({});
    const auto world = random_cloud(seed % 3 == 0 ? 20'000 : 1000, places, 0.8);
    const Validity validity({geometry}, world);
    const Validity without({geometry}, {});
    compare_states(validity, world, without, 320, false, random, tally);
  }
  expect_sound(tally);
}

TEST(CloudValidity, ProvenEdgesTouchNothingInBetween) {
  test::Random places(43);
  Random random(43);
  int free = 0;
  int clear = 0;
  int edges = 0;
  int blocked_only_by_proof = 0;
  for (int scene = 0; scene < 15; ++scene) {
    const auto world = random_cloud(2000, places, 0.8);
    const Validity validity({CellGeometry({test::puma()}, 0)}, world);
    const Validity without({CellGeometry({test::puma()}, 0)}, {});
    const Space space = space_of(validity);
    Floats a(space.stride), b(space.stride), q(space.stride);
    for (int i = 0; i < 60; ++i) {
      for (int draw = 0; draw < 30; ++draw) {
        space.sample(random, a.data());
        if (validity.state_free(a.data())) break;
      }
      space.sample(random, b.data());
      const float length = static_cast<float>(random.uniform(0.05, 2.5));
      space.interpolate(a.data(), b.data(), std::min(1.0F, length / space.distance(a.data(), b.data())), b.data());
      if (!without.edge_free(a.data(), b.data())) continue;
      double least = std::numeric_limits<double>::infinity();
      constexpr int kSamples = 300;
      for (int k = 0; k <= kSamples; ++k) {
        space.interpolate(a.data(), b.data(), static_cast<float>(k) / kSamples, q.data());
        least = std::min(least, distance(validity, world, q.data(), false));
      }
      for (const ValidityKernel* kernel : supported_kernels()) {
        const bool proven = validity.edge_free(*kernel, a.data(), b.data(), {});
        ++edges;
        free += proven ? 1 : 0;
        clear += least > 0.0 ? 1 : 0;
        EXPECT_FALSE(proven && least < 0.0) << least;
        if (!proven && least > 1e-3) ++blocked_only_by_proof;
      }
    }
  }
  EXPECT_GT(free, edges / 20);
  EXPECT_LT(free, edges);
  EXPECT_LE(blocked_only_by_proof, clear / 100) << "of " << clear;
}

}  // namespace
}  // namespace hecaton::planner::global
