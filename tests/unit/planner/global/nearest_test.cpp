#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "planner/global/nearest_points.hpp"
#include "planner/global/space.hpp"
#include "planner/simd/instruction_set.hpp"

namespace hecaton::planner::global {
namespace {

TEST(NearestPoints, MatchExhaustiveSearch) {
  Random random(5);
  for (const int dimensions : {1, 2, 6, 7, 18}) {
    const Space space{dimensions, (dimensions + 7) / 8 * 8, std::vector<float>(dimensions, -2.0F),
                      std::vector<float>(dimensions, 3.0F)};
    NearestPoints set(dimensions);
    Points points(space.stride);
    std::vector<float> q(space.stride);
    EXPECT_EQ(set.nearest(q.data()).index, -1);
    for (int i = 0; i < 500; ++i) {
      space.sample(random, q.data());
      points.add(q.data());
      set.add(q.data());
      space.sample(random, q.data());
      int best = 0;
      for (int k = 1; k < points.size(); ++k) {
        if (space.distance(points[k], q.data()) < space.distance(points[best], q.data())) best = k;
      }
      const Neighbour found = set.nearest(q.data());
      EXPECT_FLOAT_EQ(std::sqrt(found.distance2), space.distance(points[best], q.data()));
      std::vector<Neighbour> near;
      set.within(q.data(), 2.0F, near);
      for (const Neighbour& neighbour : near) EXPECT_LT(neighbour.distance2, 4.0F);
      int count = 0;
      for (int k = 0; k < points.size(); ++k) count += space.distance(points[k], q.data()) < 1.9999F ? 1 : 0;
      EXPECT_GE(static_cast<int>(near.size()), count);
    }
  }
}

TEST(KdTree, GivesTheResultOfTheScanToTheLastBit) {
  Random random(9);
  for (const int dimensions : {1, 2, 3, 6, 7, 12, 18}) {
    PointGroups all(dimensions);
    KdTree tree(dimensions);
    std::vector<float> q(dimensions, 0.0F);
    EXPECT_EQ(tree.nearest(q.data()).index, -1);
    for (int i = 0; i < 3000; ++i) {
      // Some points on a coarse grid, so that many points and distances are equal.
      for (float& x : q) {
        x = static_cast<float>(random.uniform(-3.0, 3.0));
        if (i % 2 == 0) x = std::round(x);
      }
      all.add(q.data());
      tree.add(q.data());
      for (float& x : q) x = i % 3 == 0 ? std::round(2 * x) / 2 : static_cast<float>(random.uniform(-3.0, 3.0));
      const Neighbour scanned = all.nearest(q.data());
      const Neighbour found = tree.nearest(q.data());
      ASSERT_EQ(found.index, scanned.index) << dimensions << " " << i;
      ASSERT_EQ(found.distance2, scanned.distance2);
    }
  }
}

void expect_same(const std::vector<Neighbour>& found, const std::vector<Neighbour>& scanned) {
  ASSERT_EQ(found.size(), scanned.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    ASSERT_EQ(found[i].index, scanned[i].index);
    ASSERT_EQ(found[i].distance2, scanned[i].distance2);
  }
}

TEST(KdTree, FindsSeveralNeighboursAsTheScanDoes) {
  Random random(11);
  for (const int dimensions : {1, 2, 3, 6, 7, 12}) {
    PointGroups all(dimensions);
    KdTree tree(dimensions);
    std::vector<float> q(dimensions, 0.0F);
    std::vector<Neighbour> found{{3, 1.0F}}, scanned{{4, 1.0F}};
    tree.nearest(q.data(), 5, found);
    tree.within(q.data(), 5.0F, scanned);
    EXPECT_TRUE(found.empty() && scanned.empty());
    for (int i = 0; i < 2000; ++i) {
      for (float& x : q) {
        x = static_cast<float>(random.uniform(-3.0, 3.0));
        if (i % 2 == 0) x = std::round(x);
      }
      all.add(q.data());
      tree.add(q.data());
      for (float& x : q) x = i % 3 == 0 ? std::round(2 * x) / 2 : static_cast<float>(random.uniform(-3.0, 3.0));
      const int count = 1 + static_cast<int>(random.next() % 20);
      all.nearest(q.data(), count, scanned);
      tree.nearest(q.data(), count, found);
      expect_same(found, scanned);
      EXPECT_EQ(static_cast<int>(found.size()), std::min(count, i + 1));
      const auto radius = static_cast<float>(i % 5 == 0 ? 1.0 : random.uniform(0.1, 4.0));
      all.within(q.data(), radius, scanned);
      tree.within(q.data(), radius, found);
      expect_same(found, scanned);
    }
  }
}

TEST(PointGroups, NearestFewAreTheFirstOfAllSorted) {
  Random random(12);
  PointGroups all(3);
  std::vector<float> q(3);
  for (int i = 0; i < 400; ++i) {
    for (float& x : q) x = std::round(static_cast<float>(random.uniform(-3.0, 3.0)));
    all.add(q.data());
  }
  std::vector<Neighbour> sorted, few;
  for (int i = 0; i < 50; ++i) {
    for (float& x : q) x = std::round(static_cast<float>(random.uniform(-6.0, 6.0))) / 2;
    all.within(q.data(), 1e9F, sorted);
    std::sort(sorted.begin(), sorted.end());
    all.nearest(q.data(), 10, few);
    expect_same(few, {sorted.begin(), sorted.begin() + 10});
  }
}

TEST(KdTree, HoldsManyEqualPoints) {
  KdTree tree(2);
  const float q[] = {1.0F, 2.0F};
  for (int i = 0; i < 500; ++i) tree.add(q);
  EXPECT_EQ(tree.nearest(q).index, 0);
  EXPECT_EQ(tree.size(), 500);
  std::vector<Neighbour> few;
  tree.nearest(q, 3, few);
  ASSERT_EQ(few.size(), 3U);
  EXPECT_EQ(few[2].index, 2);
}

TEST(NearestPoints, SwitchToATreeAtTheThreshold) {
  Random random(10);
  PointGroups all(2);
  NearestPoints points(2);
  std::vector<float> q(2);
  for (int i = 0; i < NearestPoints::tree_threshold(2) + 100; ++i) {
    for (float& x : q) x = static_cast<float>(random.uniform(-3.0, 3.0));
    all.add(q.data());
    points.add(q.data());
    for (float& x : q) x = static_cast<float>(random.uniform(-3.0, 3.0));
    ASSERT_EQ(points.nearest(q.data()).index, all.nearest(q.data()).index);
    std::vector<Neighbour> found, scanned;
    points.nearest(q.data(), 10, found);
    all.nearest(q.data(), 10, scanned);
    expect_same(found, scanned);
    points.within(q.data(), 0.5F, found);
    all.within(q.data(), 0.5F, scanned);
    expect_same(found, scanned);
  }
}

TEST(NearestPoints, BothInstructionSetsAgreeToTheLastBit) {
  if (!has_avx2()) GTEST_SKIP() << "this processor has no AVX2";
  Random random(6);
  std::vector<float> groups(7 * 8 * 50);
  for (float& x : groups) x = static_cast<float>(random.uniform(-3.0, 3.0));
  for (int i = 0; i < 200; ++i) {
    float q[8];
    for (float& x : q) x = static_cast<float>(random.uniform(-3.0, 3.0));
    const Neighbour one = baseline::kNearest.nearest(groups.data(), 50, 7, q);
    const Neighbour two = avx2::kNearest.nearest(groups.data(), 50, 7, q);
    EXPECT_EQ(one.index, two.index);
    EXPECT_EQ(one.distance2, two.distance2);
  }
}

TEST(NearestPoints, FindPeriodicImages) {
  Random random(7);
  const int dimensions = 3;
  const Space space{dimensions,
                    8,
                    {-kFullTurn / 2, -2.0F, -kFullTurn / 2},
                    {kFullTurn / 2, 2.0F, kFullTurn / 2},
                    {kFullTurn, 0.0F, kFullTurn}};
  NearestPoints set(space);
  std::vector<std::vector<float>> points;
  std::vector<float> q(space.stride);
  for (int i = 0; i < NearestPoints::tree_threshold(dimensions) + 200; ++i) {
    space.sample(random, q.data());
    q[0] += kFullTurn * static_cast<float>(i % 3 - 1);  // points and queries may differ by full turns
    set.add(q.data());
    points.push_back(q);
    space.sample(random, q.data());
    q[2] += kFullTurn * static_cast<float>(i % 5 - 2);
    const Neighbour near = set.nearest(q.data());
    float least = 1e9F;
    for (const auto& point : points) least = std::min(least, space.distance(point.data(), q.data()));
    ASSERT_GE(near.index, 0);
    ASSERT_NEAR(space.distance(points[near.index].data(), q.data()), least, 1e-5F);
    ASSERT_NEAR(std::sqrt(near.distance2), least, 1e-5F);
    if (i % 50 != 0) continue;
    std::vector<Neighbour> within;
    set.within(q.data(), 3.5F, within);
    const auto count = std::count_if(points.begin(), points.end(), [&](const std::vector<float>& point) {
      return space.distance(point.data(), q.data()) < 3.5F;
    });
    ASSERT_NEAR(static_cast<double>(within.size()), static_cast<double>(count), 1.0);
  }
}

}  // namespace
}  // namespace hecaton::planner::global
