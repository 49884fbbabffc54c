#include "planner/methods/potential_field/refine_path.hpp"

#include <gtest/gtest.h>

#include "field_setup.hpp"

namespace hecaton::planner::potential {
namespace {

using test::box_obstacle;
using test::FieldSetup;
using test::joints;

/// Round a wall, trembling.
std::vector<JointVector> trembling() {
  std::vector<JointVector> path;
  for (int i = 0; i <= 40; ++i) {
    const double x = -1.0 + 0.05 * i, away = i % 2 == 0 ? 0.02 : -0.02;
    path.push_back(joints({x, 0.8 - 0.6 * x * x + away}));
  }
  return path;
}

double sharpest_turn(const std::vector<JointVector>& path) {
  double least = 1.0;
  for (std::size_t i = 1; i + 1 < path.size(); ++i) {
    const JointVector a = path[i] - path[i - 1], b = path[i + 1] - path[i];
    least = std::min(least, a.dot(b) / (a.norm() * b.norm()));
  }
  return least;
}

TEST(RefinePath, TakesVibrationsOutAndStaysFree) {
  FieldSetup setup(test::planar_point(), {box_obstacle("wall", {0, -0.2, 0}, {0.1, 0.8, 0.2})});
  const auto path = trembling();
  const auto refined = refine(path, setup.motion);
  EXPECT_EQ(refined.front(), path.front());
  EXPECT_EQ(refined.back(), path.back());
  EXPECT_LT(length(refined), length(path));
  EXPECT_GT(sharpest_turn(refined), sharpest_turn(path));
  EXPECT_GT(sharpest_turn(refined), 0.9);
  for (std::size_t i = 1; i < refined.size(); ++i) EXPECT_TRUE(setup.motion.free(refined[i - 1], refined[i])) << i;
}

TEST(RefinePath, IsAStraightLineWhereThatIsFree) {
  FieldSetup setup(test::planar_point(), {});
  const auto refined = refine(trembling(), setup.motion);
  EXPECT_NEAR(length(refined), (refined.back() - refined.front()).norm(), 1e-12);
}

TEST(RefinePath, ResamplesWithoutLeavingThePath) {
  FieldSetup setup(test::planar_point(), {});
  const std::vector<JointVector> path{joints({0, 0}), joints({1, 0}), joints({1, 1})};
  const auto finer = resample(path, setup.motion, 0.1);
  EXPECT_NEAR(length(finer), 2.0, 1e-12);
  for (std::size_t i = 1; i < finer.size(); ++i) EXPECT_LE(setup.motion.sweep(finer[i] - finer[i - 1]), 0.1 + 1e-9);
}

}  // namespace
}  // namespace hecaton::planner::potential
