#include "planner/simulation/network_model.hpp"

#include <gtest/gtest.h>

namespace hecaton::planner {
namespace {

TEST(StateChannel, IsUnknownBeforeTheFirstArrival) {
  StateChannel<int> channel({.age = 0.02}, 1);
  channel.receive(0.0);
  EXPECT_FALSE(channel.known());
  channel.send(0.0, 7);
  channel.receive(0.01);
  EXPECT_FALSE(channel.known());
  channel.receive(0.02);
  EXPECT_TRUE(channel.known());
  EXPECT_EQ(channel.newest(), 7);
  EXPECT_DOUBLE_EQ(channel.age(0.02), 0.02);
  EXPECT_DOUBLE_EQ(channel.age(0.05), 0.05);  // grows until a newer sample arrives
}

TEST(StateChannel, OlderSampleNeverReplacesNewer) {
  StateChannel<double> channel({.age = 0.05, .jitter = 0.05}, 7);
  double last = -1.0;
  int skipped = 0;
  for (int k = 0; k < 5000; ++k) {
    const double now = 0.01 * k;
    channel.send(now, now);
    channel.receive(now);
    if (!channel.known()) continue;
    ASSERT_GE(channel.newest(), last);
    ASSERT_NEAR(channel.age(now), now - channel.newest(), 1e-12);
    ASSERT_LE(channel.age(now), 0.12);
    if (channel.newest() > last + 0.015) ++skipped;
    last = channel.newest();
  }
  EXPECT_GT(skipped, 500);
}

/// Number of losses, and of losses that follow a loss, of 100,000 samples.
std::pair<int, int> count_losses(const NetworkParameters& parameters) {
  LossModel model(parameters);
  Random random(3);
  int losses = 0;
  int repeated = 0;
  bool before = false;
  for (int k = 0; k < 100'000; ++k) {
    const bool lost = model.lost(random);
    losses += lost ? 1 : 0;
    repeated += lost && before ? 1 : 0;
    before = lost;
  }
  return {losses, repeated};
}

TEST(LossModel, LossesAreIndependentByDefault) {
  const auto [losses, repeated] = count_losses({.loss = 0.2});
  EXPECT_NEAR(losses, 20'000, 700);   // binomial: σ = 126
  EXPECT_NEAR(repeated, 4'000, 400);  // 0.2² of all
}

TEST(LossModel, BurstsKeepTheMeanLoss) {
  const auto [losses, repeated] = count_losses({.loss = 0.2, .burst = 5.0});
  EXPECT_NEAR(losses, 20'000, 2'000);          // bursts of 5 vary more: σ ≈ 380
  EXPECT_NEAR(repeated, 0.8 * losses, 1'000);  // all of a burst but its first: 1 − 1/5
}

/// Two arms and an obstacle, all at position `now`.
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

TEST(DelayedObservations, ArriveAtOnceOnIdealNetwork) {
  Random seeds(1);
  DelayedObservations observations({}, 0, 2, 1, seeds);
  EXPECT_FALSE(observations.knows_obstacles());
  observations.update(0.5, instant_at(0.5));
  EXPECT_TRUE(observations.knows_obstacles());
  EXPECT_EQ(observations.arms()[1].q[0], 0.5);
  EXPECT_EQ(observations.arms()[1].age, 0.0);
  EXPECT_EQ(observations.obstacles()[0].X_WO.translation().x(), 0.5);
}

TEST(DelayedObservations, HaveTheAgeThatTheNetworkGives) {
  Random seeds(1);
  DelayedObservations observations({.age = 0.1, .jitter = 0.05, .loss = 0.3}, 0, 2, 1, seeds);
  observations.update(0.0, instant_at(0.0));
  EXPECT_FALSE(observations.knows_obstacles());
  EXPECT_FALSE(observations.arms()[1].known);
  for (int k = 1; k < 2000; ++k) {
    const double now = 0.01 * k;
    observations.update(now, instant_at(now));
    if (k < 100) continue;  // by then, a state of each sender has arrived
    const ArmObservation& other = observations.arms()[1];
    ASSERT_NEAR(other.age, now - other.q[0], 1e-12);
    ASSERT_GE(other.age, 0.05 - 1e-9);
    const world::ObstacleState& obstacle = observations.obstacles()[0];
    ASSERT_NEAR(obstacle.age, now - obstacle.X_WO.translation().x(), 1e-12);
  }
}

TEST(DelayedObservations, NumberOfSeedsDoesNotDependOnTheNetwork) {
  Random one(7);
  Random other(7);
  const DelayedObservations ideal({}, 0, 2, 1, one);
  const DelayedObservations late({.age = 0.1}, 0, 2, 1, other);
  EXPECT_EQ(one.next(), other.next());
}

}  // namespace
}  // namespace hecaton::planner
