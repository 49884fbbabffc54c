#include "services/agent/restart_policy.hpp"

#include <gtest/gtest.h>

namespace hecaton::services {
namespace {

using namespace std::chrono_literals;

TEST(RestartPolicy, DoublesFromAHundredMillisecondsToFiveSeconds) {
  RestartPolicy policy({});
  for (const auto expected : {100ms, 200ms, 400ms, 800ms, 1600ms, 3200ms, 5000ms, 5000ms, 5000ms, 5000ms}) {
    EXPECT_EQ(policy.died(50ms), expected);
  }
  EXPECT_EQ(policy.died(50ms), std::nullopt);
}

TEST(RestartPolicy, SteadyLifeForgivesEarlierDeaths) {
  RestartPolicy policy({});
  for (int i = 0; i < 9; ++i) static_cast<void>(policy.died(50ms));
  EXPECT_EQ(policy.died(10s), 100ms);
  EXPECT_EQ(policy.died(50ms), 200ms);
}

TEST(RestartPolicy, WithoutAttemptsItIsGivenUpAtOnce) {
  RestartLimits limits;
  limits.attempts = 0;
  RestartPolicy policy(limits);
  EXPECT_EQ(policy.died(1h), std::nullopt);
}

}  // namespace
}  // namespace hecaton::services
