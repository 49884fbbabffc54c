#include "planner/methods/potential_field/control_points.hpp"

#include <gtest/gtest.h>

#include "planner/model/urdf_loader.hpp"
#include "tests/support/planar_point.hpp"

namespace hecaton::planner::potential {
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

TEST(ControlPoints, OfTheToolPinDownHowItIsTurned) {
  const auto points = tool_points(*robot_alone("puma560").own_arm().model, 0.1);
  ASSERT_EQ(points.size(), 3U);
  const Eigen::Vector3d a = points[1].p_L - points[0].p_L, b = points[2].p_L - points[0].p_L;
  EXPECT_NEAR(a.cross(b).norm(), 0.01, 1e-12);
}

TEST(ControlPoints, StandForTheArmAmongTheSameObstacles) {
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
}  // namespace hecaton::planner::potential
