/// The culled pass finds exactly the pairs that a loop over all pairs finds.

#include <algorithm>

#include <gtest/gtest.h>

#include "planner/collision/exact_distance.hpp"
#include "planner/simd/instruction_set.hpp"
#include "random_cell.hpp"

namespace hecaton::planner {
namespace {

constexpr int kCapacity = 4096;  // more than any of these cells has pairs

struct PosedBody {
  const Body* body;
  Counterpart counterpart;
  int owner;
  int index;
  Pose X_WS;
};

std::vector<PosedBody> bodies_of_arm(const CellGeometry& geometry, const Kinematics& kinematics, int arm) {
  std::vector<PosedBody> placed;
  for (const Body& body : geometry.arm_bodies(arm)) {
    const auto counterpart = arm == geometry.self() ? Counterpart::kSelf : Counterpart::kArm;
    placed.push_back(
        {&body, counterpart, arm, static_cast<int>(placed.size()), kinematics.X_WL[body.link] * body.X_CS});
  }
  return placed;
}

std::vector<Clearance> by_brute_force(const CellGeometry& geometry, const CellPoses& poses,
                                      const InfluenceDistances& influence) {
  std::vector<Clearance> found;
  const auto check = [&](const PosedBody& own, const PosedBody& other, double limit) {
    const ShapeDistance d = shape_distance(own.body->shape, own.X_WS, other.body->shape, other.X_WS);
    if (d.distance >= limit) return;
    found.push_back({own.index, own.body->link, other.counterpart, other.owner, other.index, other.body->link, 0,
                     d.distance, d.p_a_W, d.p_b_W, d.n_W});
  };
  const auto at_speed_of = [&](const PosedBody& mine, const Reach& reach) {
    return InfluenceDistances::distance(reach, influence.own_speed.empty() ? 0.0 : influence.own_speed[mine.index]);
  };
  const auto own = bodies_of_arm(geometry, *poses.own, geometry.self());
  for (const auto& [first, second] : geometry.self_pairs())
    check(own[first], own[second], influence.against_self(first, second));
  for (int arm = 0; arm < static_cast<int>(geometry.arms().size()); ++arm) {
    if (arm == geometry.self()) continue;
    for (const PosedBody& other : bodies_of_arm(geometry, poses.arms[arm], arm)) {
      for (const PosedBody& mine : own) {
        if (mine.body->moves || other.body->moves) check(mine, other, at_speed_of(mine, influence.against_arm(arm)));
      }
    }
  }
  for (int obstacle = 0; obstacle < geometry.obstacle_count(); ++obstacle) {
    int index = 0;
    for (const Body& body : geometry.obstacle_bodies(obstacle)) {
      const PosedBody other{&body, Counterpart::kObstacle, obstacle, index++,
                            poses.obstacles[obstacle].X_WO * body.X_CS};
      for (const PosedBody& mine : own) {
        if (mine.body->moves) check(mine, other, at_speed_of(mine, influence.against_obstacle(obstacle)));
      }
    }
  }
  return found;
}

void expect_same(const Clearance& actual, const Clearance& expected) {
  EXPECT_EQ(actual.own_body, expected.own_body);
  EXPECT_EQ(actual.own_link, expected.own_link);
  EXPECT_EQ(actual.counterpart, expected.counterpart);
  EXPECT_EQ(actual.other, expected.other);
  EXPECT_EQ(actual.other_body, expected.other_body);
  EXPECT_EQ(actual.other_link, expected.other_link);
  EXPECT_NEAR(actual.distance, expected.distance, 1e-12);
  EXPECT_LT((actual.p_own_W - expected.p_own_W).norm(), 1e-12);
  EXPECT_LT((actual.p_other_W - expected.p_other_W).norm(), 1e-12);
  EXPECT_LT((actual.n_W - expected.n_W).norm(), 1e-12);
}

/// 0, 0.3, 0.6, … [m/s]: the farther from the base, the faster.
std::vector<double> rising_speeds(std::size_t bodies) {
  std::vector<double> speeds(bodies);
  for (std::size_t i = 0; i < bodies; ++i) speeds[i] = 0.3 * static_cast<double>(i);
  return speeds;
}

TEST(Clearances, ContainAllPairsNearerThanTheirInfluenceDistance) {
  std::array<int, 3> found_of_kind{};
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    test::RandomCell cell(seed);
    ExactDistance distance(cell.geometry());
    std::vector<Clearance> found(kCapacity);
    for (int pose = 0; pose < 10; ++pose) {
      cell.shuffle();
      const auto speeds = rising_speeds(cell.geometry().own_bodies().size());
      const std::array<Reach, 3> arms{{{0.1, 0.05, 0.1}, {}, {0.3, 0.1, 0.2}}};
      const std::vector<Reach> obstacles(cell.geometry().obstacle_count(), Reach{0.05, 0.0, 0.2});
      const std::array<Reach, 1> one_for_all{{{0.1, 0.02, 0.1}}};
      for (const InfluenceDistances& influence :
           {InfluenceDistances{0.12, 0.06, {}},
            InfluenceDistances{
                .own_speed = speeds, .of_arm = arms, .of_obstacle = obstacles, .of_self = {0.05, 0, 0.03}},
            InfluenceDistances{
                .own_speed = speeds, .of_arm = arms, .of_obstacle = one_for_all, .of_self = {0.05, 0, 0}},
            InfluenceDistances{0.0, 0.0, {}}}) {
        const int count = distance.clearances(cell.poses(), influence, found);
        const auto expected = by_brute_force(cell.geometry(), cell.poses(), influence);
        ASSERT_EQ(count, static_cast<int>(expected.size())) << "seed " << seed << ", pose " << pose;
        for (int i = 0; i < count; ++i) {
          SCOPED_TRACE(testing::Message() << "seed " << seed << ", pose " << pose << ", clearance " << i);
          expect_same(found[i], expected[i]);
          ++found_of_kind[static_cast<int>(found[i].counterpart)];
        }
      }
    }
  }
  for (const int found : found_of_kind) EXPECT_GT(found, 100);
}

TEST(Clearances, AreBitIdenticalForAllInstructionSets) {
  if (!has_avx2()) GTEST_SKIP() << "this processor has no AVX2 to compare with";
  long compared = 0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    test::RandomCell cell(seed);
    ExactDistance scalar(cell.geometry(), baseline::run_pass);
    ExactDistance lanes(cell.geometry(), avx2::run_pass);
    std::vector<Clearance> a(kCapacity);
    std::vector<Clearance> b(kCapacity);
    for (int pose = 0; pose < 10; ++pose) {
      cell.shuffle();
      const int count = scalar.clearances(cell.poses(), {0.3, 0.1, {}}, a);
      ASSERT_EQ(lanes.clearances(cell.poses(), {0.3, 0.1, {}}, b), count);
      for (int i = 0; i < count; ++i) {
        EXPECT_EQ(a[i].distance, b[i].distance);
        EXPECT_EQ(a[i].n_W, b[i].n_W);
        EXPECT_EQ(a[i].p_own_W, b[i].p_own_W);
        EXPECT_EQ(a[i].p_other_W, b[i].p_other_W);
        ++compared;
      }
    }
  }
  EXPECT_GT(compared, 1000);
}

TEST(Clearances, KeepTheNearestInOrderWhenTheBufferIsFull) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const test::RandomCell cell(seed);
    ExactDistance distance(cell.geometry());
    std::vector<Clearance> all(kCapacity);
    const InfluenceDistances influence{0.3, 0.1, {}};
    all.resize(distance.clearances(cell.poses(), influence, all));
    ASSERT_GT(all.size(), 12U);
    for (const int capacity : {0, 1, 5, 12}) {
      std::vector<Clearance> some(capacity);
      ASSERT_EQ(distance.clearances(cell.poses(), influence, some), capacity);
      std::vector<double> nearest(all.size());
      std::transform(all.begin(), all.end(), nearest.begin(), [](const Clearance& c) { return c.distance; });
      std::sort(nearest.begin(), nearest.end());
      auto next = all.begin();
      for (const Clearance& clearance : some) {
        EXPECT_LE(clearance.distance, nearest[capacity - 1]);
        next = std::find_if(next, all.end(), [&](const Clearance& c) {
          return c.own_body == clearance.own_body && c.counterpart == clearance.counterpart &&
                 c.other == clearance.other && c.other_body == clearance.other_body;
        });
        ASSERT_NE(next, all.end()) << "not in the order of the whole list";
        ++next;
      }
    }
  }
}

TEST(Clearances, DependOnTheirArgumentsOnly) {
  test::RandomCell cell(77);
  ExactDistance used(cell.geometry());
  const InfluenceDistances influence{0.2, 0.1, {}};
  std::vector<Clearance> found(kCapacity);
  for (int i = 0; i < 20; ++i) {
    cell.shuffle();
    used.clearances(cell.poses(), influence, found);
  }
  const int count = used.clearances(cell.poses(), influence, found);
  ExactDistance fresh(cell.geometry());
  std::vector<Clearance> again(kCapacity);
  ASSERT_EQ(fresh.clearances(cell.poses(), influence, again), count);
  for (int i = 0; i < count; ++i) {
    EXPECT_EQ(found[i].distance, again[i].distance);
    EXPECT_EQ(found[i].n_W, again[i].n_W);
    EXPECT_EQ(found[i].p_own_W, again[i].p_own_W);
  }
}

TEST(Clearances, FollowAChangedSceneAfterRebuild) {
  test::RandomCell cell(5);
  CellGeometry geometry = cell.geometry();
  ExactDistance distance(geometry);
  geometry.set_obstacles({});
  distance.rebuild(geometry);
  std::vector<Clearance> found(kCapacity);
  CellPoses poses = cell.poses();
  poses.obstacles = {};
  const int count = distance.clearances(poses, {1.0, 0.1, {}}, found);
  EXPECT_GT(count, 0);
  for (int i = 0; i < count; ++i) EXPECT_NE(found[i].counterpart, Counterpart::kObstacle);
}

TEST(Clearances, LeaveOutPairsThatNoMotionChanges) {
  const test::RandomCell cell(3);
  ExactDistance distance(cell.geometry());
  std::vector<Clearance> found(kCapacity);
  const int count = distance.clearances(cell.poses(), {5.0, 0.0, {}}, found);
  const auto& own = cell.geometry().own_bodies();
  int static_own = 0;
  int static_other = 0;
  for (int i = 0; i < count; ++i) {
    const Clearance& c = found[i];
    if (c.counterpart == Counterpart::kSelf) continue;
    const bool other_moves =
        c.counterpart == Counterpart::kArm && cell.geometry().arm_bodies(c.other)[c.other_body].moves;
    if (!own[c.own_body].moves) {
      EXPECT_TRUE(other_moves);
      ++static_own;
    }
    static_other += c.counterpart == Counterpart::kArm && !other_moves;
  }
  EXPECT_GT(static_own, 0);
  EXPECT_GT(static_other, 0);
}

TEST(Clearances, OfArmsOfOneRobotAreThoseOfMovingBodies) {
  const test::RandomCell cell(3);
  std::vector<Arm> arms = cell.geometry().arms();
  for (Arm& arm : arms) arm.robot = 0;
  const CellGeometry shared(arms, cell.geometry().self());
  CellPoses poses = cell.poses();
  poses.obstacles = {};
  ExactDistance distance(shared);
  std::vector<Clearance> found(kCapacity);
  const int count = distance.clearances(poses, {5.0, 0.0, {}}, found);
  std::size_t expected = 0;
  const auto moving = [](const std::vector<Body>& bodies) {
    return static_cast<std::size_t>(std::count_if(bodies.begin(), bodies.end(), [](const Body& b) { return b.moves; }));
  };
  for (int arm = 0; arm < 3; ++arm) {
    if (arm != shared.self()) expected += moving(shared.own_bodies()) * moving(shared.arm_bodies(arm));
  }
  std::size_t between_arms = 0;
  for (int i = 0; i < count; ++i) {
    if (found[i].counterpart != Counterpart::kArm) continue;
    ++between_arms;
    EXPECT_TRUE(shared.own_bodies()[found[i].own_body].moves);
    EXPECT_TRUE(shared.arm_bodies(found[i].other)[found[i].other_body].moves);
  }
  EXPECT_EQ(between_arms, expected);
}

}  // namespace
}  // namespace hecaton::planner
