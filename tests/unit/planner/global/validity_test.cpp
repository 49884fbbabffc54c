#include "planner/global/validity.hpp"

#include <algorithm>
#include <cstdlib>

#include <gtest/gtest.h>

#include "planner/global/plan.hpp"
#include "planner/global/space.hpp"
#include "planner/global/validity_kernel.hpp"
#include "tests/support/fcl_collision_checker.hpp"
#include "tests/support/puma_among_boxes.hpp"
#include "tests/unit/planner/collision/random_cell.hpp"

namespace hecaton::planner::global {
namespace {

/// Number of states that a test draws; HECATON_VALIDITY_STATES=1000000 for the long run.
int states(int usual) {
  const char* wanted = std::getenv("HECATON_VALIDITY_STATES");
  return wanted == nullptr ? usual : std::atoi(wanted);
}

struct Tally {
  int states = 0;
  int free = 0;        ///< by the fast check
  int fcl_free = 0;    ///< by FCL
  int permissive = 0;  ///< free by the fast check, not by FCL
};

void compare(const Validity& validity, test::FclCollisionChecker& checker, Random& random, int count, Tally& tally) {
  const std::vector<double> zero(validity.dimensions(), 0.0);
  const Space space = space_of(validity, zero, zero);
  std::vector<float> eight(static_cast<std::size_t>(kWidth) * space.stride);
  for (int i = 0; i < count; i += kWidth) {
    for (int lane = 0; lane < kWidth; ++lane) space.sample(random, eight.data() + lane * space.stride);
    const unsigned collisions = validity.collisions(eight.data());
    for (int lane = 0; lane < kWidth; ++lane) {
      const bool free = (collisions >> lane & 1U) == 0;
      const bool fcl_free = !checker.collides(eight.data() + lane * space.stride);
      ++tally.states;
      tally.free += free ? 1 : 0;
      tally.fcl_free += fcl_free ? 1 : 0;
      tally.permissive += free && !fcl_free ? 1 : 0;
    }
  }
}

TEST(Validity, IsNeverMorePermissiveThanFclForPumaAmongBoxes) {
  Random random(11);
  Tally tally;
  const int scenes = 20;
  for (int scene = 0; scene < scenes; ++scene) {
    const auto world = test::random_boxes(20, random);
    const Validity validity({CellGeometry({test::puma()}, 0)}, world);
    test::FclCollisionChecker checker(validity, world);
    compare(validity, checker, random, states(20'000) / scenes, tally);
  }
  EXPECT_EQ(tally.permissive, 0) << "of " << tally.states;
  EXPECT_GT(tally.free, tally.states / 20);
  EXPECT_LE(tally.fcl_free - tally.free, tally.fcl_free / 1000) << "the check misses free states only within rounding";
  RecordProperty("free", tally.free);
  RecordProperty("fcl_free", tally.fcl_free);
}

// Links and obstacles of all kinds, joints about any axis, a carried obstacle.
TEST(Validity, IsNeverMorePermissiveThanFclForAllShapes) {
  Tally tally;
  Random random(12);
  const int cells = 40;
  for (int seed = 0; seed < cells; ++seed) {
    test::RandomCell cell(seed, LinkShapes::kExact, 1, 6);
    test::Random places(seed);
    std::vector<Pose> X_WO;
    for (int i = 0; i < cell.geometry().obstacle_count(); ++i) X_WO.push_back(test::random_pose(places, 1.5));
    const auto world = world_bodies(cell.geometry(), X_WO, std::vector<JointVector>(1));
    const Validity validity({cell.geometry()}, world);
    test::FclCollisionChecker checker(validity, world);
    compare(validity, checker, random, states(8'000) / cells, tally);
  }
  EXPECT_EQ(tally.permissive, 0) << "of " << tally.states;
  EXPECT_GT(tally.free, tally.states / 100);
}

TEST(Validity, IsNeverMorePermissiveThanFclForThreeArms) {
  std::vector<Arm> arms{test::puma("a"), test::puma("b"), test::puma("c")};
  arms[1].X_WB.translation() = Eigen::Vector3d(0.9, 0.0, 0.0);
  arms[2].X_WB.translation() = Eigen::Vector3d(0.4, 0.8, 0.1);
  Random random(13);
  const auto world = test::random_boxes(6, random);
  const Validity validity({CellGeometry(arms, 0), CellGeometry(arms, 1), CellGeometry(arms, 2)}, world);
  ASSERT_EQ(validity.dimensions(), 18);
  test::FclCollisionChecker checker(validity, world);
  Tally tally;
  compare(validity, checker, random, states(4'000), tally);
  EXPECT_EQ(tally.permissive, 0) << "of " << tally.states;
  EXPECT_GT(tally.free, tally.states / 100);
}

TEST(Validity, LeavesOutFixedBodiesBetweenArmsOfOneRobot) {
  std::vector<Arm> arms{test::puma("a"), test::puma("b")};
  arms[1].X_WB.translation() = Eigen::Vector3d(0.9, 0.0, 0.0);
  const auto pairs_between = [&](bool fixed_only) {
    const Validity validity({CellGeometry(arms, 0), CellGeometry(arms, 1)}, {});
    const auto first_of_b = static_cast<int>(arms[0].model->geometry.size());
    const auto& bodies = validity.robot().bodies;
    return std::count_if(validity.robot().pairs.begin(), validity.robot().pairs.end(), [&](const KernelPair& pair) {
      const bool fixed = bodies[pair.a].frame < 0 || bodies[pair.b].frame < 0;
      return (pair.a < first_of_b) != (pair.b < first_of_b) && (fixed || !fixed_only);
    });
  };
  const auto all = pairs_between(false);
  const auto fixed = pairs_between(true);
  EXPECT_GT(fixed, 0);
  for (Arm& arm : arms) arm.robot = 0;
  EXPECT_EQ(pairs_between(true), 0);
  EXPECT_EQ(pairs_between(false), all - fixed);
}

/// True where rounding decides whether q is free.
bool is_borderline(const Validity& validity, const float* q) {
  const Validity::Nearest tightest = validity.tightest(std::vector<double>(q, q + validity.dimensions()));
  return std::abs(tightest.distance - tightest.required) < 1e-4;
}

TEST(Validity, AllKernelsAgreeUnlessRoundingDecides) {
  Random scene(5);
  const Validity validity({CellGeometry({test::puma()}, 0)}, test::random_boxes(10, scene));
  const Space space = space_of(validity);
  Random random(4);
  int free = 0;
  std::vector<float> eight(static_cast<std::size_t>(kWidth) * space.stride);
  for (int i = 0; i < 2000; ++i) {
    for (int lane = 0; lane < kWidth; ++lane) space.sample(random, eight.data() + lane * space.stride);
    const unsigned narrowest = validity.collisions(*supported_kernels().front(), eight.data());
    free += kWidth - __builtin_popcount(narrowest);
    for (const ValidityKernel* kernel : supported_kernels()) {
      const unsigned differing = validity.collisions(*kernel, eight.data()) ^ narrowest;
      for (int lane = 0; lane < kWidth; ++lane) {
        if ((differing >> lane & 1U) == 0) continue;
        EXPECT_TRUE(is_borderline(validity, eight.data() + lane * space.stride)) << kernel->lanes << " lanes";
      }
    }
  }
  EXPECT_GT(free, 1000);
}

TEST(Validity, UnprovenEdgeIsFreeIfItsConfigurationsAre) {
  Random random(21);
  int free = 0;
  for (int scene = 0; scene < 10; ++scene) {
    const Validity validity({CellGeometry({test::puma()}, 0)}, test::random_boxes(10, random));
    const std::vector<double> zero(6, 0.0);
    const Space space = space_of(validity, zero, zero);
    std::vector<float> a(space.stride), b(space.stride), q(space.stride);
    for (int i = 0; i < 200; ++i) {
      space.sample(random, a.data());
      space.sample(random, b.data());
      space.interpolate(a.data(), b.data(), static_cast<float>(random.uniform()), b.data());
      // The configurations that an edge without proof checks, one by one.
      const double length = space.distance(a.data(), b.data());
      const int lanes = fastest_validity().lanes;
      const int count = lanes * std::max(1, static_cast<int>(std::ceil(length / (validity.options().step * lanes))));
      bool all = true;
      for (int k = 1; k <= count; ++k) {
        const float t = static_cast<float>(k) / static_cast<float>(count);
        for (int j = 0; j < space.stride; ++j) q[j] = a[j] * (1.0F - t) + b[j] * t;
        all = all && validity.state_free(q.data());
      }
      EXPECT_EQ(validity.edge_free(a.data(), b.data(), {.proven = false}), all);
      free += all ? 1 : 0;
    }
  }
  EXPECT_GT(free, 100);
}

TEST(Validity, PaddingKeepsItsDistance) {
  WorldBody wall{world::Box{{0.05, 1.0, 1.0}}, Pose::Identity(), "wall"};
  std::vector<float> q(8, 0.0F);
  const auto free = [&](double x, double padding) {
    wall.X_WS.translation() = Eigen::Vector3d(x, 0.0, 1.0);
    ValidityOptions options;
    options.padding = padding;
    return Validity({CellGeometry({test::puma()}, 0)}, std::vector{wall}, options).state_free(q.data());
  };
  // Upper arm along +x: it reaches less than 1 m.
  double touching = 0.0;
  for (double x = 1.0; x > 0.3 && free(x, 0.0); x -= 0.001) touching = x;
  ASSERT_GT(touching, 0.4);
  EXPECT_FALSE(free(touching + 0.049, 0.05));
  EXPECT_TRUE(free(touching + 0.052, 0.05));
}

}  // namespace
}  // namespace hecaton::planner::global
