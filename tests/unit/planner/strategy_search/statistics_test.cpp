#include "planner/strategy_search/statistics.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace hecaton::planner {
namespace {

// No fault in N: P(X ≤ 0) = (1 − p)^N = 2.5 % → p = 1 − 0.025^(1/N).
TEST(FaultBoundsTest, NoFaultInSomeTasks) {
  const FaultBounds bounds = fault_bounds(0, 4200);
  EXPECT_EQ(bounds.low, 0.0);
  EXPECT_NEAR(bounds.high, 1.0 - std::pow(0.025, 1.0 / 4200), 1e-12);
}

// The textbook example of exact limits: 2 of 10, 95 %: 0.0252 to 0.5561.
TEST(FaultBoundsTest, TwoOfTen) {
  const FaultBounds bounds = fault_bounds(2, 10);
  EXPECT_NEAR(bounds.low, 0.02521, 1e-5);
  EXPECT_NEAR(bounds.high, 0.55610, 1e-5);
}

TEST(FaultBoundsTest, AllFaultsAndNoTasks) {
  EXPECT_EQ(fault_bounds(7, 7).high, 1.0);
  EXPECT_NEAR(fault_bounds(7, 7).low, std::pow(0.025, 1.0 / 7), 1e-12);
  EXPECT_EQ(fault_bounds(0, 0).high, 1.0);
}

// a = 1, 3, 1, 3: mean 2, deviation 1; lag 1: Σ of three products of −1 over 4; lag 2: two of +1 over 4.
TEST(CorrelationTest, OfAnAlternatingSeries) {
  const std::vector<std::int32_t> a = {1, 3, 1, 3};
  const std::vector<double> own = correlations(a, a, 2);
  EXPECT_DOUBLE_EQ(own[0], -0.75);
  EXPECT_DOUBLE_EQ(own[1], 0.5);
  EXPECT_DOUBLE_EQ(correlation(a, a), 1.0);
  EXPECT_DOUBLE_EQ(correlation(a, {std::vector<std::int32_t>{3, 1, 3, 1}}), -1.0);
  EXPECT_DOUBLE_EQ(correlation(a, {std::vector<std::int32_t>{5, 5, 5, 5}}), 0.0);
}

}  // namespace
}  // namespace hecaton::planner
