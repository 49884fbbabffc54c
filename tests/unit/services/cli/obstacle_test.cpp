#include <CLI/CLI.hpp>
#include <gtest/gtest.h>

#include "services/cli/command_obstacle.hpp"
#include "services/command_line/program.hpp"

namespace hecaton::services::cli {
namespace {

world::Obstacle parse(const std::string& line) {
  CLI::App app;
  ObstacleOptions options;
  add_obstacle_options(app, options);
  app.parse(line);
  return make_obstacle(options);
}

TEST(ObstacleOptions, ReadFullSizes) {
  const world::Obstacle obstacle = parse("crate --box '0.2 0.4 0.6' --pose '1 2 3 0 0 0'");
  EXPECT_EQ(obstacle.name, "crate");
  ASSERT_EQ(obstacle.shapes.size(), 1U);
  EXPECT_TRUE(std::get<world::Box>(obstacle.shapes[0].shape).half_extents.isApprox(Eigen::Vector3d(0.1, 0.2, 0.3)));
  EXPECT_TRUE(obstacle.X_WO.translation().isApprox(Eigen::Vector3d(1, 2, 3)));
  EXPECT_TRUE(std::holds_alternative<world::StaticMotion>(obstacle.motion));
}

TEST(ObstacleOptions, ReadRoundShapes) {
  const auto cylinder = std::get<world::Cylinder>(parse("a --cylinder 0.1 0.5 --pose 0 0 0 0 0 0").shapes[0].shape);
  EXPECT_EQ(cylinder.radius, 0.1);
  EXPECT_EQ(cylinder.half_length, 0.25);
  const auto capsule = std::get<world::Capsule>(parse("a --capsule 0.1,0.5 --pose 0,0,0,0,0,0").shapes[0].shape);
  EXPECT_EQ(capsule.radius, 0.1);
  EXPECT_EQ(capsule.half_length, 0.25);
  EXPECT_EQ(std::get<world::Sphere>(parse("a --sphere 0.07 --pose 0 0 0 0 0 0").shapes[0].shape).radius, 0.07);
}

TEST(ObstacleOptions, ReadPointsFromAFile) {
  const std::string folder = std::string(HECATON_SOURCE_DIR) + "/tests/data/bad/clouds/";
  const auto points =
      std::get<world::Points>(parse("a --points " + folder + "good.xyz 0.02 --pose 0 0 0 0 0 0").shapes[0].shape);
  EXPECT_EQ(points.cloud->size(), 1U);
  EXPECT_EQ(points.cloud->radius(), 0.02);
  for (const char* bad : {"nan.xyz 0.02", "missing.xyz 0.02", "good.xyz x", "good.xyz 0", "good.xyz 0.02 --mass 1"}) {
    EXPECT_THROW(static_cast<void>(parse("a --pose 0 0 0 0 0 0 --points " + folder + bad)), Failure) << bad;
  }
}

TEST(ObstacleOptions, ReadMotions) {
  const auto conveyor =
      std::get<world::ConveyorMotion>(parse("a --sphere 1 --pose 0 0 0 0 0 0 --conveyor '0 -0.3 0.4 2'").motion);
  EXPECT_DOUBLE_EQ(conveyor.speed, 0.5);  // √(0.3² + 0.4²)
  EXPECT_TRUE(conveyor.direction_W.isApprox(Eigen::Vector3d(0, -0.6, 0.8)));
  EXPECT_EQ(conveyor.length, 2.0);
  EXPECT_EQ(std::get<world::DynamicMotion>(parse("a --sphere 1 --pose 0 0 0 0 0 0 --mass 2").motion).mass, 2.0);
  EXPECT_EQ(std::get<world::SineMotion>(parse("a --sphere 1 --pose 0 0 0 0 0 0 --sine 0.1 0 0 4").motion).period, 4.0);
  EXPECT_EQ(
      std::get<world::CircleMotion>(parse("a --sphere 1 --pose 0 0 0 0 0 0 --circle 1 2 3 -0.5").motion).angular_speed,
      -0.5);
}

TEST(ObstacleOptions, RejectWrongUsage) {
  for (const char* line : {
           "a --pose 0 0 0 0 0 0",                                    // no shape
           "a --sphere 1",                                            // no pose
           "a --sphere 1 --box 1 1 1 --pose 0 0 0 0 0 0",             // two shapes
           "a --sphere 1 --pose 0 0 0 0 0 0 --mass 1 --sine 1 0 0 1"  // two motions
       }) {
    EXPECT_THROW(static_cast<void>(parse(line)), CLI::ParseError) << line;
  }
}

TEST(ObstacleOptions, RejectInvalidValues) {
  for (const char* line : {
           "a --sphere 0 --pose 0 0 0 0 0 0",                     // no size
           "a --sphere nan --pose 0 0 0 0 0 0",                   // no number
           "a --cylinder 0.1 1000 --pose 0 0 0 0 0 0",            // beyond the largest size
           "a --capsule 0.1 0.2 0.3 --pose 0 0 0 0 0 0",          // a size too many
           "a --box '1 -1 1' --pose 0 0 0 0 0 0",                 // negative size
           "a --sphere 1 --pose 0 0 0",                           // half a pose
           "a --sphere 1 --pose 0 0 0 0 0 0 --mass -1",           // negative mass
           "a --sphere 1 --pose 0 0 0 0 0 0 --conveyor 0 0 0 1",  // does not move
           "a/b --sphere 1 --pose 0 0 0 0 0 0"                    // no name
       }) {
    EXPECT_THROW(static_cast<void>(parse(line)), Failure) << line;
  }
}

}  // namespace
}  // namespace hecaton::services::cli
