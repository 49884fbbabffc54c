#include "examples/obstacle_shape/cone.hpp"

#include <gtest/gtest.h>

#include "planner/collision/exact_distance.hpp"
#include "services/config/cell_file.hpp"
#include "services/messages/convert.hpp"

namespace example {
namespace {

using hecaton::world::Pose;
using hecaton::world::Sphere;

constexpr double kRadius = 0.3;
constexpr double kHeight = 0.4;  // slant: a triangle of 3, 4 and 5
const std::vector<double> kSizes = {kRadius, kHeight};

/// Distance of a small ball around a point from the cone [m].
double distance_from(const world::Shape& cone, const Eigen::Vector3d& point) {
  constexpr double kBall = 0.001;
  Pose X = Pose::Identity();
  X.translation() = point;
  return hecaton::planner::shape_distance(cone, Pose::Identity(), Sphere{kBall}, X).distance + kBall;
}

TEST(Cone, HasTheDistancesOfACone) {
  const world::Shape cone = make_cone(kSizes);
  EXPECT_NEAR(distance_from(cone, {0, 0, 0.3}), 0.1, 1e-6);   // above the tip
  EXPECT_NEAR(distance_from(cone, {0, 0, -0.5}), 0.3, 1e-6);  // below the base
  for (double angle = 0.0; angle < 6.3; angle += 0.1) {
    // From the middle of the slant along its normal (0.8, 0.6), 0.2 m out: the polygon is at most 1.3 % of the radius
    // nearer.
    const double out = 0.15 + 0.2 * 0.8;
    const double distance = distance_from(cone, {out * std::cos(angle), out * std::sin(angle), 0.2 * 0.6});
    EXPECT_LE(distance, 0.2 + 1e-6) << angle;
    EXPECT_GE(distance, 0.2 - 0.013 * kRadius) << angle;
  }
}

TEST(Cone, IsTheSameAfterAMessage) {
  hecaton::world::Obstacle obstacle;
  obstacle.name = "cone";
  obstacle.shapes.push_back({make_cone(kSizes)});
  const auto received = hecaton::messages::from_message(hecaton::messages::to_message(obstacle));
  ASSERT_TRUE(received.value);
  EXPECT_NEAR(distance_from(received.value->shapes[0].shape, {0, 0, 0.3}), 0.1, 1e-6);
}

TEST(Cone, RejectsSizesOutsideTheirRange) {
  auto types = hecaton::config::shape_types();
  types.push_back(kCone);
  const auto load = [&](const std::string& sizes) {
    return hecaton::config::parse_cell_file(
        "name: test\n"
        "arms: [{name: arm, urdf: ../../deploy/cells/urdf/planar_3r.urdf, poses: {home: [0, 0, 0]}}]\n"
        "obstacles: [{name: cone, shapes: [{type: cone, " +
            sizes + "}], pose: {xyz: [3, 0, 0]}}]\n",
        HECATON_SOURCE_DIR "/examples/obstacle_shape/test.yaml", hecaton::planner::built_in_methods(), types);
  };
  EXPECT_EQ(load("radius: 0.3, height: 0.4").cell.scene.obstacles.size(), 1U);
  try {
    static_cast<void>(load("radius: 0.3, height: -1"));
    FAIL() << "a cone of negative height";
  } catch (const hecaton::config::ConfigError& error) {
    EXPECT_NE(std::string(error.what()).find("obstacles[0].shapes[0].height = -1 must be"), std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace example
