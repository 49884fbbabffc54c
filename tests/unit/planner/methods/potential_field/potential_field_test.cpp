#include "planner/methods/potential_field/potential_field.hpp"

#include <random>

#include <gtest/gtest.h>

#include "field_setup.hpp"
#include "planner/collision/model_filter.hpp"
#include "planner/model/urdf_loader.hpp"
#include "tests/support/planar_point.hpp"

namespace hecaton::planner::potential {
namespace {

constexpr double kGoalDistance = 0.3, kInfluence = 0.2, kEta = 1e-4;

template <typename F>
double difference(const F& f, double d, double step) {
  return (f(d + step).value - f(d - step).value) / (2.0 * step);
}

TEST(Potential, AttractionIsAParaboloidThatContinuesAsACone) {
  EXPECT_DOUBLE_EQ(attraction(0.2, kGoalDistance).value, 0.02);
  EXPECT_DOUBLE_EQ(attraction(1.0, kGoalDistance).value, 0.3 - 0.045);
  EXPECT_DOUBLE_EQ(attraction(1.0, kGoalDistance).slope, kGoalDistance);
  EXPECT_NEAR(attraction(kGoalDistance - 1e-9, kGoalDistance).value,
              attraction(kGoalDistance + 1e-9, kGoalDistance).value, 1e-9);
}

TEST(Potential, RepulsionMatchesThePaperAndEndsSmoothly) {
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

TEST(Potential, PushesOutOfPenetratedObstacles) {
  const Potential inside = repulsion(-0.01, kInfluence, kEta);
  EXPECT_LT(inside.slope, 0.0);
  EXPECT_GT(inside.value, repulsion(0.0, kInfluence, kEta).value);
  EXPECT_GT(repulsion(0.0, kInfluence, kEta).value, repulsion(0.01, kInfluence, kEta).value);
}

}  // namespace
namespace {

CellGeometry robot_alone(const std::string& name) {
  Arm arm;
  arm.name = "arm";
  arm.model = load_urdf(std::string(HECATON_SOURCE_DIR) + "/deploy/cells/urdf/" + name + ".urdf");
  arm.limits = arm.model->limits;
  return CellGeometry({arm}, 0);
}

bool has(const std::vector<ControlPoint>& points, const Eigen::Vector3d& p_L) {
  return std::any_of(points.begin(), points.end(), [&](const auto& point) { return (point.p_L - p_L).norm() < 1e-9; });
}

/// Of the rectangle, without the slides that carry it.
std::vector<ControlPoint> of_rectangle(double spacing) {
  std::vector<ControlPoint> points = control_points(robot_alone("mobile_rectangle"), spacing);
  std::erase_if(points, [](const auto& point) { return point.link != 3; });
  return points;
}

// "In W, the control points are chosen at the vertices of the rectangle."
TEST(ControlPoints, OfARectangleAreItsVertices) {
  const auto points = of_rectangle(1.0);
  EXPECT_EQ(points.size(), 4U);
  for (const double x : {-0.25, 0.25}) {
    for (const double y : {-0.125, 0.125}) EXPECT_TRUE(has(points, {x, y, 0.0})) << x << " " << y;
  }
}

TEST(ControlPoints, AlongEdgesAreNoFartherApartThanTheSpacing) {
  const auto points = of_rectangle(0.125);
  EXPECT_EQ(points.size(), 12U);  // 4 vertices, 3 more on each long side, 1 more on each short one
  EXPECT_TRUE(has(points, {0.125, 0.125, 0.0}));
  EXPECT_TRUE(has(points, {0.25, 0.0, 0.0}));
}

TEST(ControlPoints, OfRoundLinksAreBallsOnTheirAxes) {
  const auto points = control_points(robot_alone("planar_3r"), 0.15);
  for (const ControlPoint& point : points) {
    EXPECT_GT(point.link, 0) << "what no joint moves needs none";
    EXPECT_NEAR(point.p_L.y(), 0.0, 1e-9);
    EXPECT_NEAR(point.radius, 0.025, 1e-3);
  }
  for (int link = 1; link <= 3; ++link) {
    const auto of_link = std::count_if(points.begin(), points.end(), [&](const auto& p) { return p.link == link; });
    EXPECT_GE(of_link, 4) << link;
  }
}

TEST(ControlPoints, OfTheToolDetermineItsOrientation) {
  const auto points = tool_points(*robot_alone("puma560").own_arm().model, 0.1);
  ASSERT_EQ(points.size(), 3U);
  const Eigen::Vector3d a = points[1].p_L - points[0].p_L, b = points[2].p_L - points[0].p_L;
  EXPECT_NEAR(a.cross(b).norm(), 0.01, 1e-12);
}

TEST(ControlPoints, ReplaceTheArmAmongTheSameObstacles) {
  CellGeometry geometry = robot_alone("planar_3r");
  geometry.set_obstacles(std::vector<world::Obstacle>{test::box_obstacle("box", {1, 1, 0}, {0.1, 0.1, 0.1})});
  const auto points = control_points(geometry, 0.15);
  const CellGeometry balls = control_geometry(geometry, points);
  ASSERT_EQ(balls.own_bodies().size(), points.size());
  ASSERT_EQ(balls.obstacle_count(), 1);
  EXPECT_EQ(balls.obstacle_bodies(0).size(), 1U);
  EXPECT_TRUE(balls.self_pairs().empty());
}

}  // namespace
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

TEST(PotentialField, OfAPointMatchesThePaper) {
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
