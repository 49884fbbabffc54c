#include "planner/simulation/arm_in_world.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "planner/model/urdf_loader.hpp"

namespace hecaton::planner {
namespace {

/// The planar arm, stretched along x, with one sideways ray from its elbow to a wall 1 m away.
class RangeScannerTest : public testing::Test {
 protected:
  RangeScannerTest() {
    arm_.arm.model = load_urdf(std::string(HECATON_SOURCE_DIR) + "/deploy/cells/urdf/planar_2r.urdf");
    RangeSensor sensor;
    sensor.name = "side";
    sensor.link = link("upper");
    sensor.rays = {{{0.5, 0.0, 0.0}, {0.0, 1.0, 0.0}}};
    sensor.range = 1.5;
    arm_.sensors = {sensor};
    world::Obstacle wall;
    wall.name = "wall";
    wall.shapes.push_back({world::Box{{5.0, 0.5, 0.5}}});
    wall.X_WO.translation() = Eigen::Vector3d(0.0, 1.5, 0.0);
    obstacles_ = {wall};
    states_ = {{wall.X_WO, {}, 0.0}};
    caster_.set_obstacles(obstacles_);
    caster_.place(states_);
  }

  [[nodiscard]] int link(const std::string& name) const {
    int i = 0;
    while (arm_.arm.model->links[i].name != name) ++i;
    return i;
  }
  [[nodiscard]] std::vector<RangeScan> scan(RangeScanner& scanner, double now) {
    return scanner.scan(now, stretched_, caster_);
  }

  PlannedArm arm_;
  std::vector<world::Obstacle> obstacles_;
  std::vector<world::ObstacleState> states_;
  world::RayCaster caster_;
  JointVector stretched_ = JointVector::Zero(2);
};

TEST_F(RangeScannerTest, MeasuresFromTheLinkPose) {
  RangeScanner scanner(arm_, 1);
  const auto scans = scan(scanner, 0.0);
  ASSERT_EQ(scans.size(), 1U);
  EXPECT_EQ(scans[0].link, link("upper"));
  EXPECT_TRUE(scans[0].readings[0].hit);
  EXPECT_NEAR(scans[0].readings[0].distance, 1.0, 1e-5);
  RangeScanner other(arm_, 1);
  const JointVector turned = Eigen::Vector2d(std::asin(0.8), 0.0);  // the ray leans to the left, from y = 0.4
  const auto aside = other.scan(0.0, turned, caster_);
  EXPECT_NEAR(aside[0].readings[0].distance, 0.6 / 0.6, 1e-5);
}

TEST_F(RangeScannerTest, ReportsNoHitBeyondRange) {
  arm_.sensors[0].range = 0.99;
  RangeScanner scanner(arm_, 1);
  const auto scans = scan(scanner, 0.0);
  EXPECT_FALSE(scans[0].readings[0].hit);
  EXPECT_DOUBLE_EQ(scans[0].readings[0].distance, 0.99);
}

TEST_F(RangeScannerTest, ScansAtSensorPeriod) {
  arm_.sensors[0].period = 0.03;
  RangeScanner scanner(arm_, 1);
  int scans = 0;
  for (int tick = 0; tick < 300; ++tick) scans += static_cast<int>(scan(scanner, 0.01 * tick).size());
  EXPECT_EQ(scans, 100);
}

TEST_F(RangeScannerTest, AddsBoundedNoise) {
  arm_.sensors[0].noise = 0.01;
  RangeScanner scanner(arm_, 7);
  double sum = 0.0;
  double squares = 0.0;
  constexpr int kScans = 20'000;
  for (int i = 0; i < kScans; ++i) {
    const double off = scan(scanner, 0.01 * i)[0].readings[0].distance - 1.0;
    ASSERT_LE(std::abs(off), 0.03 + 1e-5);
    sum += off;
    squares += off * off;
  }
  EXPECT_NEAR(sum / kScans, 0.0, 3e-4);
  EXPECT_NEAR(std::sqrt(squares / kScans), 0.01, 5e-4);
}

}  // namespace
}  // namespace hecaton::planner
