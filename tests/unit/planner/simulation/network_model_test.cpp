#include "planner/simulation/network_model.hpp"

#include <gtest/gtest.h>

#include "tests/support/planar_point.hpp"

namespace hecaton::planner {
namespace {

using test::joints;

TEST(StateChannel, NothingIsKnownBeforeTheFirstArrival) {
  StateChannel channel({.age = 0.02}, 1);
  EXPECT_FALSE(channel.receive(0.0).known);
  channel.send(0.0, {joints({1}), joints({2}), 0.0, true, true});
  EXPECT_FALSE(channel.receive(0.01).known);
  const ArmObservation state = channel.receive(0.02);
  EXPECT_TRUE(state.known && state.plans);
  EXPECT_DOUBLE_EQ(state.age, 0.02);
  EXPECT_EQ(state.q, joints({1}));
  EXPECT_DOUBLE_EQ(channel.receive(0.05).age, 0.05);  // it grows while nothing newer comes
}

TEST(StateChannel, JitterNeverBringsOlderNewsAfterNewer) {
  StateChannel channel({.age = 0.05, .jitter = 0.05}, 7);
  double last = -1.0;
  for (int k = 0; k < 5000; ++k) {
    const double now = 0.01 * k;
    channel.send(now, {joints({now}), joints({0}), 0.0, true, true});
    const ArmObservation state = channel.receive(now);
    if (!state.known) continue;
    ASSERT_GE(state.q[0], last);
    ASSERT_NEAR(state.age, now - state.q[0], 1e-12);
    ASSERT_LE(state.age, 0.12);
    last = state.q[0];
  }
}

TEST(StateChannel, LosesTheShareItWasTold) {
  StateChannel channel({.loss = 0.2}, 3);
  int fresh = 0;
  for (int k = 0; k < 20'000; ++k) {
    const double now = 0.01 * k;
    channel.send(now, {joints({now}), joints({0}), 0.0, true, true});
    if (channel.receive(now).age == 0.0) ++fresh;
  }
  EXPECT_NEAR(fresh, 16'000, 300);  // binomial: σ = 57; the very first sample may be unknown
}

}  // namespace
}  // namespace hecaton::planner
