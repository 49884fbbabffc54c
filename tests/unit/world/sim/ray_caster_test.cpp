#include "world/sim/ray_caster.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace hecaton::world {
namespace {

Obstacle obstacle(const Shape& shape, const Eigen::Vector3d& place) {
  Obstacle obstacle;
  obstacle.name = "thing";
  obstacle.shapes.push_back({shape});
  obstacle.X_WO.translation() = place;
  return obstacle;
}

class RayCasterTest : public testing::Test {
 protected:
  std::optional<double> cast(const Eigen::Vector3d& p, const Eigen::Vector3d& d, double range = 5.0) {
    std::vector<ObstacleState> states;
    for (const Obstacle& one : obstacles_) states.push_back({one.X_WO, {}, 0.0});
    caster_.set_obstacles(obstacles_);
    caster_.place(states);
    return caster_.cast(p, d.normalized(), range);
  }
  std::vector<Obstacle> obstacles_;
  RayCaster caster_;
};

TEST_F(RayCasterTest, MeasuresNearestSurface) {
  obstacles_ = {obstacle(Box{{0.1, 0.2, 0.3}}, {2.0, 0.0, 0.0}), obstacle(Sphere{0.5}, {4.0, 0.0, 0.0})};
  EXPECT_NEAR(cast({0, 0, 0}, {1, 0, 0}).value(), 1.9, 1e-5);  // the box is before the ball
  EXPECT_NEAR(cast({0, 0.25, 0}, {1, 0, 0}).value(), 4.0 - std::sqrt(0.25 - 0.0625),
              1e-5);  // past the box, on the ball
  EXPECT_FALSE(cast({0, 0.6, 0}, {1, 0, 0}).has_value());
  EXPECT_FALSE(cast({0, 0, 0}, {1, 0, 0}, 1.8).has_value());  // out of range
  EXPECT_FALSE(cast({0, 0, 0}, {-1, 0, 0}).has_value());      // behind
}

TEST_F(RayCasterTest, MeasuresTurnedAndRoundShapes) {
  obstacles_ = {obstacle(Box{{0.1, 0.1, 0.1}}, {1.0, 0.0, 0.0}), obstacle(Cylinder{0.2, 0.5}, {0.0, 1.0, 0.0}),
                obstacle(Capsule{0.1, 0.4}, {0.0, -1.0, 0.0})};
  obstacles_[0].X_WO.linear() = Eigen::AngleAxisd(std::acos(-1.0) / 4.0, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  EXPECT_NEAR(cast({0, 0, 0}, {1, 0, 0}).value(), 1.0 - 0.1 * std::sqrt(2.0), 1e-5);  // its corner
  EXPECT_NEAR(cast({0, 0, 0}, {0, 1, 0}).value(), 0.8, 1e-5);
  EXPECT_NEAR(cast({0, 0, 0.45}, {0, 1, 0}).value(), 0.8, 1e-5);
  EXPECT_NEAR(cast({0, 0, 0}, {0, -1, 0}).value(), 0.9, 1e-5);
}

// Rays that nearly miss a corner: the measured point is on the surface, or there is none.
TEST_F(RayCasterTest, GrazingRayHitsTheSurfaceOrNothing) {
  obstacles_ = {obstacle(Box{{0.1, 0.075, 0.1}}, {0.7, -0.1, 0.0})};
  int hits = 0;
  for (int i = 0; i < 4000; ++i) {
    const double angle = -0.6 + 1.2 * i / 4000;
    const Eigen::Vector3d from(0.4 + 0.3 * std::cos(7.0 * i), 0.05 * std::sin(3.0 * i), 0.0);
    const Eigen::Vector3d d(std::cos(angle), std::sin(angle), 0.0);
    const auto t = cast(from, d, 0.8);
    if (!t || *t == 0.0) continue;
    ++hits;
    const Eigen::Vector3d outside =
        (from + *t * d - obstacles_[0].X_WO.translation()).cwiseAbs() - Eigen::Vector3d(0.1, 0.075, 0.1);
    EXPECT_NEAR(outside.maxCoeff(), 0.0, 1e-5) << "beam " << i;
  }
  EXPECT_GT(hits, 500);
}

TEST_F(RayCasterTest, IsZeroInsideAndIgnoresCarriedObstacles) {
  obstacles_ = {obstacle(Sphere{0.5}, {0.0, 0.0, 0.0})};
  EXPECT_EQ(cast({0.1, 0, 0}, {1, 0, 0}).value(), 0.0);
  obstacles_[0].attachment = Attachment{"arm"};
  EXPECT_FALSE(cast({-2, 0, 0}, {1, 0, 0}).has_value());
}

}  // namespace
}  // namespace hecaton::world
