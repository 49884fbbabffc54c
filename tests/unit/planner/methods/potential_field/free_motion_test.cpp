// Conservative: what it calls free is free at every one of many configurations in between.
#include "planner/methods/potential_field/free_motion.hpp"

#include <random>

#include <gtest/gtest.h>

#include "field_setup.hpp"
#include "planner/collision/model_filter.hpp"

namespace hecaton::planner::potential {
namespace {

using test::ball_obstacle;
using test::box_obstacle;
using test::FieldSetup;
using test::joints;

TEST(FreeMotion, DetectsAThinWallInBetween) {
  FieldSetup setup(test::planar_point(), {box_obstacle("sheet", {0, 0, 0}, {0.0005, 0.5, 0.5})}, {}, 0.0);
  EXPECT_FALSE(setup.motion.free(joints({-1, 0}), joints({1, 0})));
  EXPECT_TRUE(setup.motion.free(joints({-1, 0.56}), joints({1, 0.56})));
  EXPECT_FALSE(setup.motion.free(joints({-1, 0.54}), joints({1, 0.54})));
}

TEST(FreeMotion, KeepsTheMargin) {
  const std::vector<world::Obstacle> wall{box_obstacle("wall", {0, 0, 0}, {0.1, 0.5, 0.5})};
  FieldSetup strict(test::planar_point(), wall, {}, 0.1);
  EXPECT_FALSE(strict.motion.free(joints({-1, 0.64}), joints({1, 0.64})));
  EXPECT_TRUE(strict.motion.free(joints({-1, 0.66}), joints({1, 0.66})));
  EXPECT_FALSE(strict.motion.free(joints({0.2, 0})));
}

TEST(FreeMotion, IsConservativeForAPuma) {
  Arm arm;
  arm.name = "puma";
  arm.model = load_arm_model(std::string(HECATON_SOURCE_DIR) + "/deploy/cells/urdf/puma560.urdf");
  arm.limits = arm.model->limits;
  FieldSetup setup(arm, {ball_obstacle({0.6, 0.1, 0.8}, 0.05), ball_obstacle({0.2, 0.7, 0.5}, 0.05)}, {}, 0.0);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const auto draw = [&] {
    JointVector q(6);
    for (int j = 0; j < 6; ++j) q[j] = arm.limits.lower[j] + unit(random) * (arm.limits.upper[j] - arm.limits.lower[j]);
    return q;
  };
  int free = 0, blocked = 0;
  for (int sample = 0; sample < 300; ++sample) {
    const JointVector from = draw();
    const JointVector to = from + 0.3 * (draw() - from);
    bool touches = false;
    for (int i = 0; i <= 400; ++i)
      touches = touches || setup.motion.free_distance(from + i / 400.0 * (to - from), 0.01) <= 0.0;
    const bool said_free = setup.motion.free(from, to);
    EXPECT_FALSE(said_free && touches) << sample;
    (said_free ? free : blocked) += 1;
  }
  EXPECT_GT(free, 20);
  EXPECT_GT(blocked, 10);
}

TEST(FreeMotion, SweepBoundsHowFarAnyPointMoves) {
  Arm arm;
  arm.name = "arm";
  arm.model = load_arm_model(std::string(HECATON_SOURCE_DIR) + "/deploy/cells/urdf/planar_3r.urdf");
  arm.limits = arm.model->limits;
  FieldSetup setup(arm, {});
  EXPECT_GE(setup.motion.sweep(joints({0.01, 0, 0})), 0.01 * 1.2);
  EXPECT_LE(setup.motion.sweep(joints({0.01, 0, 0})), 0.01 * 1.5);
  EXPECT_LE(setup.motion.sweep(joints({0, 0, 0.01})), 0.01 * 0.6);
}

}  // namespace
}  // namespace hecaton::planner::potential
