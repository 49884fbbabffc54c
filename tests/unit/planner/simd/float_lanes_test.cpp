#include "planner/simd/float_lanes.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace hecaton::planner::HECATON_ISA {
namespace {

// The proof of an edge counts on this bound (planner/global/kernel_robot.cpp).
TEST(FloatLanes, SineAndCosineKeepTheirErrorBound) {
  double worst = 0.0;
  for (double x = -40.0; x < 40.0; x += 1e-5 * kFloats) {
    Floats angle, sine, cosine;
    for (int i = 0; i < kFloats; ++i) angle[i] = static_cast<float>(x + 1e-5 * i);
    sine_cosine(angle, sine, cosine);
    for (int i = 0; i < kFloats; ++i) {
      worst = std::max(worst, std::abs(sine[i] - std::sin(static_cast<double>(angle[i]))));
      worst = std::max(worst, std::abs(cosine[i] - std::cos(static_cast<double>(angle[i]))));
    }
  }
  EXPECT_LT(worst, 2.5e-7);
}

TEST(FloatLanes, ExtremesAreThoseOfAllLanes) {
  Floats x = lane_numbers(), y = 3.0F - lane_numbers(), z = lane_numbers() * lane_numbers() - 2.0F * lane_numbers();
  float out[8];
  extremes(x, y, z, out);
  const auto last = static_cast<float>(kFloats - 1);
  EXPECT_EQ(out[0], 0.0F);
  EXPECT_EQ(out[4], -last);
  EXPECT_EQ(out[1], 3.0F - last);
  EXPECT_EQ(out[5], -3.0F);
  EXPECT_EQ(out[2], -1.0F);
  EXPECT_EQ(out[6], -(last * last - 2.0F * last));
}

TEST(FloatLanes, NextLaneShiftsAndKeepsTheLast) {
  const Floats next = next_lane(lane_numbers());
  for (int i = 0; i + 1 < kFloats; ++i) EXPECT_EQ(next[i], static_cast<float>(i + 1));
  EXPECT_EQ(next[kFloats - 1], static_cast<float>(kFloats - 1));
}

TEST(FloatLanes, ComparisonWithNotANumberDoesNotFail) {
  Floats a = all(1.0F);
  a[0] = std::nanf("");
  a[1] = -1.0F;
  EXPECT_EQ(below(a, all(0.0F)), 0b11U);
}

}  // namespace
}  // namespace hecaton::planner::HECATON_ISA
