// The field of a whole arm: its gradient against differences of the potential, forces summed in Q.
#include "planner/methods/potential_field/potential_field.hpp"

#include <random>

#include <gtest/gtest.h>

#include "field_setup.hpp"
#include "planner/collision/model_filter.hpp"
#include "planner/methods/potential_field/potential.hpp"

namespace hecaton::planner::potential {
namespace {

using test::ball_obstacle;
using test::FieldSetup;
using test::joints;

Arm robot(const std::string& name) {
  Arm arm;
  arm.name = "arm";
  arm.model = load_arm_model(std::string(HECATON_SOURCE_DIR) + "/deploy/cells/urdf/" + name + ".urdf");
  arm.limits = arm.model->limits;
  return arm;
}

TEST(PotentialField, OfAPointIsThePublishedOne) {
  PotentialParameters parameters;
  parameters.attraction = Attraction::kJoints;
  FieldSetup setup(test::planar_point(), {ball_obstacle({1, 0, 0}, 0.2)}, parameters);
  setup.field.set_goal(joints({2, 0}));
  const FieldValue far = setup.at(joints({0, 0}));
  EXPECT_NEAR(far.attraction, attraction(2.0, 0.3).value, 1e-12);
  EXPECT_DOUBLE_EQ(far.repulsion, 0.0);
  EXPECT_NEAR(far.gradient[0], -0.3, 1e-12);
  // 0.1 m before it: once for the control point, once for the body's nearest point, which is the same.
  const FieldValue near = setup.at(joints({0.65, 0}));
  EXPECT_NEAR(near.clearance, 0.1, 1e-9);
  EXPECT_NEAR(near.repulsion, 2.0 * repulsion(0.1, 0.2, 1e-4).value, 1e-9);
  EXPECT_NEAR(near.gradient[0], -0.3 - 2.0 * repulsion(0.1, 0.2, 1e-4).slope, 1e-6);
}

/// Where nearest points do not jump the potential has a gradient: differences must agree with it.
void expect_gradient(const std::string& name, Attraction attract, const std::vector<world::Obstacle>& obstacles) {
  PotentialParameters parameters;
  parameters.attraction = attract;
  const Arm arm = robot(name);
  FieldSetup setup(arm, obstacles, parameters);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const int n = arm.model->joints();
  const auto draw = [&] {
    JointVector q(n);
    for (int j = 0; j < n; ++j) q[j] = std::clamp(1.5 * unit(random), arm.limits.lower[j], arm.limits.upper[j]);
    return q;
  };
  int repelled = 0;
  for (int sample = 0; sample < 60; ++sample) {
    const JointVector q = draw();
    setup.field.set_goal(draw());
    const FieldValue value = setup.at(q);
    if (value.clearance < 0.01) continue;
    repelled += value.repulsion > 0.0 ? 1 : 0;
    const double step = 1e-6;
    for (int j = 0; j < n; ++j) {
      JointVector more = q, less = q;
      more[j] += step;
      less[j] -= step;
      const double slope = (setup.at(more).potential() - setup.at(less).potential()) / (2.0 * step);
      EXPECT_NEAR(value.gradient[j], slope, 1e-3 * value.gradient.norm() + 1e-5) << name << " joint " << j;
    }
  }
  EXPECT_GT(repelled, 5) << name << ": the test must see obstacles";
}

TEST(PotentialField, GradientIsThatOfThePotential) {
  const std::vector<world::Obstacle> plane{ball_obstacle({0.7, 0.2, 0}, 0.1), ball_obstacle({-0.3, 0.6, 0}, 0.1)};
  expect_gradient("planar_3r", Attraction::kControlPoints, plane);
  expect_gradient("planar_3r", Attraction::kJoints, plane);
  expect_gradient("mobile_rectangle", Attraction::kControlPoints, plane);
  expect_gradient("puma560", Attraction::kControlPoints,
                  {ball_obstacle({0.5, 0.2, 0.7}, 0.1), ball_obstacle({-0.4, 0.4, 0.9}, 0.2)});
}

// "Summing the forces in the W space and then transforming this vector to the Q space is not equal to summing the
// transformed forces in the Q space. The latter is the correct way." A rectangle that only has to turn: by hand.
TEST(PotentialField, SumsForcesInQ) {
  FieldSetup setup(robot("mobile_rectangle"), {});
  const double goal = 0.4;
  setup.field.set_goal(joints({0, 0, goal}));
  const FieldValue value = setup.at(joints({0, 0, 0}));
  auto points = setup.field.points();
  const auto more = tool_points(*setup.geometry.own_arm().model, setup.field.parameters().spacing);
  points.insert(points.end(), more.begin(), more.end());
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  double torque = 0.0;
  for (const ControlPoint& point : points) {
    if (point.link < 3) continue;  // the slides are where they shall be
    const Eigen::Vector3d there = Eigen::AngleAxisd(goal, Eigen::Vector3d::UnitZ()) * point.p_L;
    const Eigen::Vector3d away = point.p_L - there;
    const double d = away.norm();
    const Eigen::Vector3d gradient = d > 0.0 ? Eigen::Vector3d(attraction(d, 0.3).slope / d * away) : away;
    force += gradient;
    torque += point.p_L.cross(gradient).z();
  }
  EXPECT_NEAR(value.gradient[0], force.x(), 1e-12);
  EXPECT_NEAR(value.gradient[1], force.y(), 1e-12);
  EXPECT_NEAR(value.gradient[2], torque, 1e-12);
  EXPECT_LT(torque, -0.05) << "the sum of the forces at the centre would not turn it";
}

TEST(PotentialField, VanishesAtAFreeGoal) {
  const Arm arm = robot("puma560");
  FieldSetup setup(arm, {});
  const JointVector q = joints({0.3, -1.2, 2.6, 0.4, 0.6, 0.2});
  setup.field.set_goal(q);
  EXPECT_NEAR(setup.at(q).attraction, 0.0, 1e-20);
  JointVector turned = q;
  turned[5] += 0.5;
  EXPECT_GT(setup.at(turned).attraction, 1e-4) << "the last joint turns about the tool's axis";
}

}  // namespace
}  // namespace hecaton::planner::potential
