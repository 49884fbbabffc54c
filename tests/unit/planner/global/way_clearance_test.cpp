#include <limits>

#include <gtest/gtest.h>

#include "planner/global/plan.hpp"
#include "tests/support/puma_among_boxes.hpp"

namespace hecaton::planner::global {
namespace {

using Configuration = std::vector<double>;

/// By exact distances, at so many places.
double looked_at(const Validity& validity, const Configuration& a, const Configuration& b, int steps) {
  double least = std::numeric_limits<double>::infinity();
  Configuration q(a.size());
  for (int k = 0; k <= steps; ++k) {
    for (std::size_t j = 0; j < q.size(); ++j) q[j] = a[j] + (b[j] - a[j]) * k / steps;
    least = std::min(least, validity.nearest(q).distance);
  }
  return least;
}

/// Ways of `reach` in each joint at most: what is `between` places that are looked at is nearer by no more than that.
void compare(const Validity& validity, double reach, int steps, double between, int ways, Random& random) {
  const Space space = space_of(validity);
  std::vector<float> q(space.stride);
  for (int i = 0; i < ways; ++i) {
    space.sample(random, q.data());
    const Configuration a(q.begin(), q.begin() + space.dimensions);
    Configuration b = a;
    for (double& x : b) x += random.uniform(-reach, reach);
    const double seen = looked_at(validity, a, b, steps);
    if (seen <= 0.0) continue;  // depths are another matter
    const double said = validity.clearance(a, b);
    EXPECT_LE(said, seen) << "way " << i;
    EXPECT_GE(said, seen * (1.0 - 2e-3) - 2e-6 - between) << "way " << i;
  }
}

TEST(WayClearance, IsTheSmallestDistanceFromBelow) {
  Random random(5);
  for (int scene = 0; scene < 4; ++scene) {
    const Validity validity({CellGeometry({test::puma()}, 0)}, test::random_boxes(4, random));
    compare(validity, 0.5, 400, 5e-3, 10, random);
  }
}

TEST(WayClearance, IsThatOfSeveralArmsToo) {
  Random random(6);
  std::vector<Arm> arms = {test::puma("one"), test::puma("two")};
  arms[1].X_WB.translation() = Eigen::Vector3d(0.9, 0.0, 0.0);
  const Validity validity({CellGeometry(arms, 0), CellGeometry(arms, 1)}, test::random_boxes(2, random));
  compare(validity, 0.3, 400, 8e-3, 20, random);
}

TEST(WayClearance, SeesWhatALookAtPlacesStepsOver) {
  // A needle that the wrist passes halfway along its way, and touches for a moment only.
  WorldBody needle{world::Sphere{0.001}, Pose::Identity(), "needle"};
  const Configuration a{-0.5, 0.0, 1.5, 0.0, 0.0, 0.0};
  Configuration b = a;
  b[0] = 0.5;
  needle.X_WS.translation() = Eigen::Vector3d(0.95, 0.15, 0.67);
  const Validity validity({CellGeometry({test::puma()}, 0)}, std::vector{needle});
  EXPECT_LE(validity.clearance(a, b), looked_at(validity, a, b, 100'000));
}

}  // namespace
}  // namespace hecaton::planner::global
