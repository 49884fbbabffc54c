// Eq. 2, 3, 6 and 7 of [Cardenas10]: values by hand, slopes against differences.
#include "planner/methods/potential_field/potential.hpp"

#include <gtest/gtest.h>

namespace hecaton::planner::potential {
namespace {

constexpr double kGoalDistance = 0.3, kInfluence = 0.2, kEta = 1e-4;

template <typename F>
double difference(const F& f, double d, double step) {
  return (f(d + step).value - f(d - step).value) / (2.0 * step);
}

TEST(Potential, AttractionIsAParaboloidThatGoesOnAsACone) {
  EXPECT_DOUBLE_EQ(attraction(0.2, kGoalDistance).value, 0.02);
  EXPECT_DOUBLE_EQ(attraction(1.0, kGoalDistance).value, 0.3 - 0.045);
  EXPECT_DOUBLE_EQ(attraction(1.0, kGoalDistance).slope, kGoalDistance);
  EXPECT_NEAR(attraction(kGoalDistance - 1e-9, kGoalDistance).value,
              attraction(kGoalDistance + 1e-9, kGoalDistance).value, 1e-9);
}

TEST(Potential, RepulsionIsAsPublishedAndEndsSmoothly) {
  EXPECT_NEAR(repulsion(0.1, kInfluence, kEta).value, 0.5 * kEta * 25.0, 1e-12);
  // Corrected eq. 7 with its sign: −η (1/d − 1/Q*)/d² = −1e-4 · 5 · 100.
  EXPECT_NEAR(repulsion(0.1, kInfluence, kEta).slope, -0.05, 1e-12);
  EXPECT_DOUBLE_EQ(repulsion(kInfluence, kInfluence, kEta).value, 0.0);
  EXPECT_DOUBLE_EQ(repulsion(0.5, kInfluence, kEta).slope, 0.0);
  EXPECT_NEAR(repulsion(kInfluence - 1e-7, kInfluence, kEta).slope, 0.0, 1e-6);
}

TEST(Potential, SlopesAreDerivatives) {
  for (double d = 0.01; d < 0.6; d += 0.007) {
    const auto attract = [](double x) { return attraction(x, kGoalDistance); };
    const auto repel = [](double x) { return repulsion(x, kInfluence, kEta); };
    EXPECT_NEAR(attract(d).slope, difference(attract, d, 1e-6), 1e-6) << d;
    EXPECT_NEAR(repel(d).slope, difference(repel, d, 1e-7), 1e-4 * std::abs(repel(d).slope) + 1e-7) << d;
  }
}

TEST(Potential, PushesOutOfWhatItIsInside) {
  const Potential inside = repulsion(-0.01, kInfluence, kEta);
  EXPECT_LT(inside.slope, 0.0);
  EXPECT_GT(inside.value, repulsion(0.0, kInfluence, kEta).value);
  EXPECT_GT(repulsion(0.0, kInfluence, kEta).value, repulsion(0.01, kInfluence, kEta).value);
}

}  // namespace
}  // namespace hecaton::planner::potential
