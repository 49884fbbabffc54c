// Passing obstacles in random encounters: docs/explanation/0010-passing-obstacles.md.
#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include "planner/arm_controller.hpp"
#include "tests/support/planar_point.hpp"

namespace hecaton::planner {
namespace {

using Eigen::Vector3d;
using test::joints;

constexpr double kPeriod = 0.01;       // [s]
constexpr double kRadius = 0.05;       // of all balls [m]
constexpr double kAcceleration = 2.0;  // of what flies [m/s²]
constexpr double kField = 1.0;         // half the side of the square in which the arm has its goals [m]

/// A ball that moves through the field, partly straight, partly with changing velocity within kAcceleration.
struct Flyer {
  Vector3d p = Vector3d::Zero();
  Vector3d v = Vector3d::Zero();
  Vector3d a = Vector3d::Zero();

  void enter(Random& random) {
    const double angle = random.uniform(-3.2, 3.2);
    const Vector3d from(std::cos(angle), std::sin(angle), 0.0);
    p = 2.5 * kField * from;
    const Vector3d at(random.uniform(-kField, kField), random.uniform(-kField, kField), 0.0);
    v = random.uniform(0.3, 3.0) * (at - p).normalized();
    a.setZero();
  }
  void fly(Random& random, double dt) {
    if (random.uniform() < 0.05) {
      const double angle = random.uniform(-3.2, 3.2);
      a = random.uniform(0.0, kAcceleration) * Vector3d(std::cos(angle), std::sin(angle), 0.0);
    }
    p += v * dt + 0.5 * a * dt * dt;
    v += a * dt;
    if (p.norm() > 2.6 * kField) enter(random);
  }
};

struct Outcome {
  int goals = 0;           ///< number of reached goals
  int hits = 0;            ///< number of contacts
  double fastest = -10.0;  ///< largest approach speed of the arm itself at a contact, unless it braked [m/s]
};

/// `own`: speed and acceleration limits of the arm [m/s, m/s²].
Outcome fly_among(int flyers, double speed, double acceleration, double seconds, std::uint64_t seed) {
  Random random(seed);
  Arm arm = test::planar_point("ball", kRadius);
  arm.limits.velocity.setConstant(speed);
  arm.limits.acceleration.setConstant(acceleration);
  LocalParameters parameters;
  parameters.damper = {.influence_distance = 0.12, .security_distance = 0.03, .convergence_speed = 0.55};
  parameters.acceleration_of_obstacles = kAcceleration;
  parameters.rollout.candidates = 0;
  ArmController controller(CellGeometry({arm}, 0), parameters, kPeriod, random.next());
  std::vector<world::Obstacle> balls(flyers);
  std::vector<Flyer> all(flyers);
  for (int i = 0; i < flyers; ++i) {
    balls[i].name = "flyer" + std::to_string(i);
    balls[i].shapes.push_back({world::Sphere{kRadius}, world::Pose::Identity()});
    all[i].enter(random);
  }
  controller.set_obstacles(balls);

  Outcome outcome;
  MeasuredState own{joints({0, 0}), joints({0, 0})};
  const std::vector<ArmObservation> no_arms(1);
  std::vector<world::ObstacleState> states(flyers);
  std::vector<bool> touched(flyers, false);
  for (double now = 0.0; now < seconds; now += kPeriod) {
    for (int i = 0; i < flyers; ++i) {
      states[i].X_WO.translation() = all[i].p;
      states[i].velocity.linear = all[i].v;
    }
    const TickResult result = controller.step(own, no_arms, states, false);
    if (result.status == TickStatus::kReached || result.status == TickStatus::kIdle) {
      if (result.status == TickStatus::kReached) ++outcome.goals;
      controller.set_goal(joints({random.uniform(-kField, kField), random.uniform(-kField, kField)}));
    }
    own = {result.q, result.qd};
    for (int i = 0; i < flyers; ++i) {
      all[i].fly(random, kPeriod);
      const Vector3d way = all[i].p - Vector3d(own.q[0], own.q[1], 0.0);
      const bool touches = way.norm() < 2.0 * kRadius;
      if (touches && !touched[i]) {
        ++outcome.hits;
        const double approach = way.normalized().dot(Vector3d(own.qd[0], own.qd[1], 0.0));
        if (!result.relaxed) outcome.fastest = std::max(outcome.fastest, approach);
      }
      touched[i] = touches;
    }
  }
  return outcome;
}

// Some obstacles are too fast for a retreat. But no arm hits an obstacle: a touched arm stands, retreats or brakes as
// hard as it can.
TEST(PassingProperty, TouchedArmDidNotApproachTheObstacle) {
  Random random(31);
  Outcome all;
  for (int trial = 0; trial < 60; ++trial) {
    const double speed = random.uniform(0.3, 1.5);
    const double stop = random.uniform(0.05, 0.15);
    const Outcome one = fly_among(1 + trial % 3, speed, speed / stop, 60.0, random.next());
    all.goals += one.goals;
    all.hits += one.hits;
    all.fastest = std::max(all.fastest, one.fastest);
  }
  RecordProperty("goals", all.goals);
  RecordProperty("hits", all.hits);
  EXPECT_GT(all.goals, 2000);
  EXPECT_GT(all.hits, 20) << "or nothing was tried";
  EXPECT_LT(all.fastest, 1e-3) << all.hits << " hits, " << all.goals << " goals";
}

}  // namespace
}  // namespace hecaton::planner
