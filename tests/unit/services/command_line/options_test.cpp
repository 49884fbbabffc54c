#include "services/command_line/options.hpp"

#include <numbers>

#include <gtest/gtest.h>

namespace hecaton::services::cli {
namespace {

constexpr double kPi = std::numbers::pi;

TEST(ParseNumbers, SplitsAtBlanksCommasAndWords) {
  const std::vector<double> expected{1.0, -0.5, 2e-3};
  EXPECT_EQ(parse_numbers({"1 -0.5 2e-3"}, 3).numbers, expected);
  EXPECT_EQ(parse_numbers({"1,-0.5, 2e-3"}, 3).numbers, expected);
  EXPECT_EQ(parse_numbers({"1", "-0.5", "2e-3"}, 0).numbers, expected);
}

TEST(ParseNumbers, RejectsWordsThatAreNoFiniteNumber) {
  EXPECT_EQ(parse_numbers({"1 two"}, 0).error, "'two' must be a finite number");
  EXPECT_EQ(parse_numbers({"nan"}, 0).error, "'nan' must be a finite number");
  EXPECT_EQ(parse_numbers({"1 inf"}, 0).error, "'inf' must be a finite number");
  EXPECT_EQ(parse_numbers({"1e999"}, 0).error, "'1e999' must be a finite number");
  EXPECT_EQ(parse_numbers({"0x10"}, 0).error, "'0x10' must be a finite number");
}

TEST(ParseNumbers, RejectsAnotherCount) {
  EXPECT_EQ(parse_numbers({"1 2"}, 3).error, "2 numbers given, must be 3");
  EXPECT_EQ(parse_numbers({" "}, 0).error, "no number given, must be at least one");
}

TEST(PoseOf, AppliesRollThenPitchThenYaw) {
  // Rz(90°)·Rx(90°) takes z to x: Rx turns z into −y, Rz turns −y into x.
  const world::Pose pose = pose_of({1, 2, 3, kPi / 2, 0, kPi / 2});
  EXPECT_NEAR((pose * Eigen::Vector3d::UnitZ() - Eigen::Vector3d(2, 2, 3)).norm(), 0.0, 1e-12);
}

TEST(XyzRpyOf, InvertsPoseOf) {
  const std::vector<double> given{0.1, -0.2, 0.3, 0.4, -0.5, 2.9};
  const std::vector<double> back = xyz_rpy_of(pose_of(given));
  for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(back[i], given[i], 1e-12) << i;
}

TEST(XyzRpyOf, KeepsTheRotationAtAPitchOfNinetyDegrees) {
  const world::Pose pose = pose_of({0, 0, 0, 0.3, kPi / 2, 0.8});
  const world::Pose again = pose_of(xyz_rpy_of(pose));
  EXPECT_TRUE(again.isApprox(pose, 1e-9));
}

}  // namespace
}  // namespace hecaton::services::cli
