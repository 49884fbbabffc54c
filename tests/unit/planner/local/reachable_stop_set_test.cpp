#include "planner/local/reachable_stop_set.hpp"

#include <algorithm>

#include <gtest/gtest.h>

#include "planner/collision/cell_geometry.hpp"
#include "planner/local/random.hpp"
#include "planner/model/urdf_loader.hpp"
#include "planner/trajectory/stop_profile.hpp"
#include "tests/support/planar_point.hpp"

namespace hecaton::planner {
namespace {

using test::joints;

constexpr double kStep = 1e-3;  // [s]

double draw(Random& random, double bound) {
  return random.uniform(-bound, bound);
}

/// Where an arm rests that accelerates at random, in bursts, for `moved_for`, then goes on its stop profile.
JointVector rest_of_adversary(const JointLimits& limits, JointVector q, JointVector qd, double moved_for,
                              Random& random) {
  JointVector push = JointVector::Zero(q.size());
  for (double t = 0.0; t + 0.5 * kStep < moved_for; t += kStep) {
    for (Eigen::Index j = 0; j < q.size(); ++j) {
      // Mostly as hard as it can, as who wants to get far does.
      if (random.uniform() < 0.03) push[j] = limits.acceleration[j] * (random.uniform() < 0.8 ? 1.0 : -1.0);
      const double next = std::clamp(qd[j] + push[j] * kStep, -limits.velocity[j], limits.velocity[j]);
      q[j] += 0.5 * (qd[j] + next) * kStep;
      qd[j] = next;
    }
  }
  return rest_position(limits, q, qd).cwiseMax(limits.lower).cwiseMin(limits.upper);
}

TEST(ReachableStopSet, IsAPointForAnArmAtRestThatNeverMoves) {
  const JointLimits limits = test::planar_point().limits;
  const ReachableStopSet region = reachable_stop_set(limits, joints({0.3, -1.0}), joints({0, 0}), 0.0);
  EXPECT_EQ(region.q, joints({0.3, -1.0}));
  EXPECT_EQ(region.position_uncertainty, joints({0, 0}));
}

// From rest, 0.1 s at 4 m/s²: 20 mm and 0.4 m/s; then as long and as far to a stop.
TEST(ReachableStopSet, ByHand) {
  const JointLimits limits = test::planar_point().limits;
  ReachableStopSet region = reachable_stop_set(limits, joints({0, 0}), joints({0, 0}), 0.1);
  EXPECT_NEAR(region.position_uncertainty[0], 0.04, 1e-12);
  EXPECT_NEAR(region.q[0], 0.0, 1e-12);
  // At 0.5 m/s already, the limit: 50 mm and 31.25 mm on; or in 0.1 s down to 0.1 m/s: 30 mm on.
  region = reachable_stop_set(limits, joints({0, 0}), joints({0.5, 0}), 0.1);
  EXPECT_NEAR(region.q[0] + region.position_uncertainty[0], 0.08125, 1e-12);
  EXPECT_NEAR(region.q[0] - region.position_uncertainty[0], 0.03, 1e-12);
}

TEST(ReachableStopSet, EndsAtTheJointLimits) {
  const JointLimits limits = test::planar_point().limits;
  const ReachableStopSet region = reachable_stop_set(limits, joints({2.99, 0}), joints({0.5, 0}), 0.5);
  EXPECT_LE(region.q[0] + region.position_uncertainty[0], 3.0 + 1e-12);
}

TEST(ReachableStopSet, HoldsWhateverTheArmDid) {
  const JointLimits limits = test::planar_point().limits;
  Random random(3);
  double fullest = 0.0;
  for (int trial = 0; trial < 2000; ++trial) {
    const JointVector q = joints({draw(random, 2.9), draw(random, 2.9)});
    const JointVector qd = joints({draw(random, 0.5), draw(random, 0.5)});
    const double moved_for = 0.3 * random.uniform();
    const ReachableStopSet region = reachable_stop_set(limits, q, qd, moved_for);
    const double braked_after = moved_for * (random.uniform() < 0.5 ? 1.0 : random.uniform());
    const JointVector rest = rest_of_adversary(limits, q, qd, braked_after, random);
    const JointVector away = (rest - region.q).cwiseAbs();
    ASSERT_TRUE((away.array() <= region.position_uncertainty.array() + 1e-3).all())
        << "trial " << trial;  // steps of 1 ms
    fullest = std::max(fullest, away.cwiseQuotient(region.position_uncertainty.cwiseMax(1e-3)).maxCoeff());
  }
  EXPECT_GT(fullest, 0.95) << "a region that nobody comes near the edge of is too wide";
}

TEST(LongestLevers, NoPointGoesFartherThanTheyAllow) {
  Arm arm;
  arm.name = "arm";
  arm.model = load_urdf(HECATON_SOURCE_DIR "/deploy/cells/urdf/puma560.urdf");
  arm.limits = arm.model->limits;
  const CellGeometry geometry({arm}, 0);
  const int n = arm.model->joints();
  Random random(4);
  Kinematics centre;
  Kinematics there;
  double fullest = 0.0;
  for (int trial = 0; trial < 2000; ++trial) {
    JointVector q(n);
    JointVector position_uncertainty(n);
    JointVector moved(n);
    for (int j = 0; j < n; ++j) {
      q[j] = random.uniform(-2.0, 2.0);
      position_uncertainty[j] = 0.5 * random.uniform();
      moved[j] = q[j] + position_uncertainty[j] * (random.uniform() < 0.5 ? 1.0 : random.uniform(-1.0, 1.0));
    }
    forward_kinematics(*arm.model, arm.X_WB, q, centre);
    forward_kinematics(*arm.model, arm.X_WB, moved, there);
    for (const Body& body : geometry.own_bodies()) {
      const double extent = body.bound.centre.norm() + body.bound.radius;
      const double most = longest_levers(arm, body.link, extent).dot(position_uncertainty);
      const Eigen::Vector3d direction = Eigen::Vector3d(draw(random, 1), draw(random, 1), draw(random, 1)).normalized();
      const Eigen::Vector3d point = body.bound.centre + body.bound.radius * direction;
      const double way = (there.X_WL[body.link] * point - centre.X_WL[body.link] * point).norm();
      ASSERT_LE(way, most + 1e-12) << arm.model->links[body.link].name;
      if (most > 0.0) fullest = std::max(fullest, way / most);
    }
  }
  EXPECT_GT(fullest, 0.5);
}

}  // namespace
}  // namespace hecaton::planner
