#include "planner/simulation/network_model.hpp"

#include <gtest/gtest.h>

namespace hecaton::planner {
namespace {

TEST(StateChannel, NothingIsKnownBeforeTheFirstArrival) {
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
  EXPECT_DOUBLE_EQ(channel.age(0.05), 0.05);  // it grows while nothing newer comes
}

TEST(StateChannel, SamplesOvertakeEachOtherButOlderNewsNeverReplaceNewer) {
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

/// Lost samples and losses that follow a loss, of 100,000.
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

TEST(LossModel, IndependentLossesByDefault) {
  const auto [losses, repeated] = count_losses({.loss = 0.2});
  EXPECT_NEAR(losses, 20'000, 700);   // binomial: σ = 126
  EXPECT_NEAR(repeated, 4'000, 400);  // 0.2² of all
}

TEST(LossModel, BurstsKeepTheShareAndComeInRows) {
  const auto [losses, repeated] = count_losses({.loss = 0.2, .burst = 5.0});
  EXPECT_NEAR(losses, 20'000, 2'000);          // runs of 5 vary more: σ ≈ 380
  EXPECT_NEAR(repeated, 0.8 * losses, 1'000);  // all of a run but its first: 1 − 1/5
}

}  // namespace
}  // namespace hecaton::planner
