#include "planner/simulation/delayed_observations.hpp"

#include <gtest/gtest.h>

namespace hecaton::planner {
namespace {

/// Two arms that move with the time, and an obstacle.
std::shared_ptr<const CellInstant> instant_at(double now) {
  auto instant = std::make_shared<CellInstant>();
  instant->arms.resize(2);
  for (ArmObservation& arm : instant->arms) {
    arm.q = JointVector::Constant(6, now);
    arm.known = true;
  }
  instant->obstacles.resize(1);
  instant->obstacles[0].X_WO.translation().x() = now;
  return instant;
}

TEST(DelayedObservations, ArriveAtOnceOnAnIdealNetwork) {
  Random seeds(1);
  DelayedObservations news({}, 0, 2, 1, seeds);
  EXPECT_FALSE(news.knows_obstacles());
  news.hear(0.5, instant_at(0.5));
  EXPECT_TRUE(news.knows_obstacles());
  EXPECT_EQ(news.arms()[1].q[0], 0.5);
  EXPECT_EQ(news.arms()[1].age, 0.0);
  EXPECT_EQ(news.obstacles()[0].X_WO.translation().x(), 0.5);
}

TEST(DelayedObservations, AreAsOldAsTheNetworkMakesThem) {
  Random seeds(1);
  DelayedObservations news({.age = 0.1, .jitter = 0.05, .loss = 0.3}, 0, 2, 1, seeds);
  news.hear(0.0, instant_at(0.0));
  EXPECT_FALSE(news.knows_obstacles());
  EXPECT_FALSE(news.arms()[1].known);
  for (int k = 1; k < 2000; ++k) {
    const double now = 0.01 * k;
    news.hear(now, instant_at(now));
    if (k < 100) continue;  // by then all were heard of
    const ArmObservation& other = news.arms()[1];
    ASSERT_NEAR(other.age, now - other.q[0], 1e-12);
    ASSERT_GE(other.age, 0.05 - 1e-9);
    const world::ObstacleState& obstacle = news.obstacles()[0];
    ASSERT_NEAR(obstacle.age, now - obstacle.X_WO.translation().x(), 1e-12);
  }
}

TEST(DelayedObservations, IdealAndNearlyIdealNetworksUseUpTheSameSeeds) {
  Random one(7);
  Random other(7);
  const DelayedObservations ideal({}, 0, 2, 1, one);
  const DelayedObservations late({.age = 0.1}, 0, 2, 1, other);
  EXPECT_EQ(one.next(), other.next());
}

}  // namespace
}  // namespace hecaton::planner
