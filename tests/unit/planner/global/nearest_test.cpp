#include "planner/global/nearest.hpp"

#include <gtest/gtest.h>

#include "planner/global/space.hpp"
#include "planner/simd/instruction_set.hpp"

namespace hecaton::planner::global {
namespace {

TEST(NearestPoints, AreThoseThatAreFoundOneByOne) {
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

TEST(NearestPoints, BothCompilationsAgreeToTheLastBit) {
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

}  // namespace
}  // namespace hecaton::planner::global
