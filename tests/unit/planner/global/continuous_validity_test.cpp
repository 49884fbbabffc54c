#include <cmath>

#include <gtest/gtest.h>

#include "planner/global/plan.hpp"
#include "planner/global/validity.hpp"
#include "tests/support/fcl_collision_checker.hpp"
#include "tests/support/puma_among_boxes.hpp"

namespace hecaton::planner::global {
namespace {

using Floats = std::vector<float>;
using Configuration = std::vector<double>;

struct Scene {
  std::vector<WorldBody> world;
  Validity validity;
  Space space;
  test::FclCollisionChecker checker;

  Scene(int boxes, Random& random, const ValidityOptions& options = {})
      : world(test::random_boxes(boxes, random)),
        validity({CellGeometry({test::puma()}, 0)}, world, options),
        space(space_of(validity, std::vector<double>(6, 0.0), std::vector<double>(6, 0.0))),
        checker(validity, world) {}

  [[nodiscard]] Floats draw(Random& random) const {
    Floats q(space.stride);
    space.sample(random, q.data());
    return q;
  }
  /// A random configuration near q.
  [[nodiscard]] Floats draw_near(const Floats& q, double distance, Random& random) const {
    Floats near = q;
    for (int j = 0; j < space.dimensions; ++j) near[j] += static_cast<float>(random.uniform(-distance, distance));
    return near;
  }
};

Floats on_curve(const Floats& a, const Floats& c, const Floats& b, float t) {
  Floats q(a.size());
  for (std::size_t j = 0; j < q.size(); ++j) {
    q[j] = (1 - t) * (1 - t) * a[j] + 2 * t * (1 - t) * c[j] + t * t * b[j];
  }
  return q;
}

TEST(ProvenEdge, IsConfirmedByFclAtFineSteps) {
  Random random(3);
  int proven = 0, seen = 0;
  for (int i = 0; i < 60; ++i) {
    Scene scene(12, random);
    for (int k = 0; k < 4; ++k) {
      const Floats a = scene.draw(random);
      if (!scene.validity.state_free(a.data())) continue;
      const Floats b = scene.draw_near(a, 0.8, random), c = scene.draw_near(a, 0.8, random);
      const bool straight = k % 2 == 0;
      bool free = true;
      for (int s = 0; s <= 400 && free; ++s) {
        const auto t = static_cast<float>(s) / 400.0F;
        Floats q(a.size());
        if (straight) {
          scene.space.interpolate(a.data(), b.data(), t, q.data());
        } else {
          q = on_curve(a, c, b, t);
        }
        free = !scene.checker.collides(q.data());
      }
      const bool claimed = straight ? scene.validity.edge_free(a.data(), b.data())
                                    : scene.validity.curve_free(a.data(), c.data(), b.data());
      EXPECT_TRUE(free || !claimed) << i;
      if (free && !claimed) {
        // Finer than any step: it comes within rounding of something.
        double least = 1.0;
        for (int s = 0; s <= 4000; ++s) {
          const auto t = static_cast<float>(s) / 4000.0F;
          Floats q(a.size());
          if (straight) {
            scene.space.interpolate(a.data(), b.data(), t, q.data());
          } else {
            q = on_curve(a, c, b, t);
          }
          least = std::min(least, scene.validity.nearest(std::vector<double>(q.begin(), q.begin() + 6)).distance);
        }
        EXPECT_LT(least, 1e-4);
      }
      seen += free ? 1 : 0;
      proven += claimed ? 1 : 0;
    }
  }
  EXPECT_GT(seen, 40);
  EXPECT_GT(proven, 0.9 * seen);
}

TEST(ProvenEdge, HoldsForAllConfigurationsWithinTheSpread) {
  Random random(8);
  int proven = 0, less = 0;
  for (int i = 0; i < 60; ++i) {
    Scene scene(10, random);
    const Floats a = scene.draw(random);
    if (!scene.validity.state_free(a.data())) continue;
    const Floats b = scene.draw_near(a, 0.4, random), c = scene.draw_near(a, 0.4, random);
    Floats spread(a.size(), 0.0F);
    for (int j = 0; j < scene.space.dimensions; ++j) spread[j] = static_cast<float>(random.uniform(0.0, 0.03));
    const bool claimed = scene.validity.curve_free(a.data(), c.data(), b.data(), 0.0, spread.data());
    less += scene.validity.curve_free(a.data(), c.data(), b.data()) && !claimed ? 1 : 0;
    if (!claimed) continue;
    ++proven;
    for (int k = 0; k < 300; ++k) {
      Floats q = on_curve(a, c, b, static_cast<float>(random.uniform()));
      for (int j = 0; j < scene.space.dimensions; ++j) {
        q[j] += spread[j] * (k % 2 == 0               ? static_cast<float>(random.uniform(-1.0, 1.0))
                             : random.uniform() < 0.5 ? -1.0F
                                                      : 1.0F);
      }
      ASSERT_FALSE(scene.checker.collides(q.data())) << i;
    }
  }
  EXPECT_GT(proven, 10);
  EXPECT_GT(less, 0);
}

TEST(ProvenEdge, FindsCollisionBetweenSteps) {
  // A sheet of 0.5 mm in the path of the forearm, and steps of 0.5 rad.
  ValidityOptions options;
  options.step = 0.5;
  const WorldBody sheet{world::Box{{0.3, 0.00025, 0.3}}, Pose(Eigen::Translation3d(0.8, 0.0, 0.6)), "sheet"};
  const Validity validity({CellGeometry({test::puma()}, 0)}, std::vector{sheet}, options);
  const Floats left{0.9F, -0.3F, 1.5F, 0, 0, 0, 0, 0}, right{-0.6F, -0.3F, 1.5F, 0, 0, 0, 0, 0};
  ASSERT_TRUE(validity.state_free(left.data()) && validity.state_free(right.data()));
  EXPECT_FALSE(validity.edge_free(left.data(), right.data()));
  const Validity empty({CellGeometry({test::puma()}, 0)}, {}, options);
  EXPECT_TRUE(empty.edge_free(left.data(), right.data()));
}

TEST(ProvenEdge, KeepsTheClearance) {
  Random random(4);
  int proven = 0, refused = 0;
  for (int i = 0; i < 40; ++i) {
    Scene scene(8, random);
    ValidityOptions options;
    options.padding = 0.0299;
    const Validity padded({CellGeometry({test::puma()}, 0)}, scene.world, options);
    const Floats a = scene.draw(random), b = scene.draw_near(a, 0.5, random);
    if (!scene.validity.state_free(a.data()) || !scene.validity.edge_free(a.data(), b.data())) continue;
    if (!scene.validity.edge_free(a.data(), b.data(), {.clearance = 0.03})) {
      ++refused;
      continue;
    }
    ++proven;
    for (int s = 0; s <= 200; ++s) {
      Floats q(a.size());
      scene.space.interpolate(a.data(), b.data(), static_cast<float>(s) / 200.0F, q.data());
      EXPECT_TRUE(padded.state_free(q.data())) << i;
    }
  }
  EXPECT_GT(proven, 3);
  EXPECT_GT(refused, 1);
}

TEST(BodyLevers, BoundAllMotions) {
  const std::vector<CellGeometry> planned{CellGeometry({test::puma()}, 0)};
  const Arm& arm = planned[0].own_arm();
  const std::vector<float> levers = body_levers(planned);
  Random random(1);
  const auto draw = [&] {
    return JointVector(JointVector::NullaryExpr(
        6, [&](Eigen::Index j) { return random.uniform(arm.limits.lower[j], arm.limits.upper[j]); }));
  };
  double closest = 0.0;
  for (int i = 0; i < 20'000; ++i) {
    const JointVector a = draw();
    JointVector b = a;
    const auto joint = static_cast<Eigen::Index>(random.next() % 6);
    b[joint] += 0.01;
    if (i % 2 == 0) b = draw();
    Kinematics at_a, at_b;
    forward_kinematics(*arm.model, arm.X_WB, a, at_a);
    forward_kinematics(*arm.model, arm.X_WB, b, at_b);
    for (std::size_t k = 0; k < planned[0].own_bodies().size(); ++k) {
      const Body& body = planned[0].own_bodies()[k];
      Eigen::Vector3d way = Eigen::Vector3d::NullaryExpr([&] { return random.normal(); });
      const Eigen::Vector3d p = body.bound.centre + body.bound.radius * way.normalized();
      const double moved = (at_a.X_WL[body.link] * p - at_b.X_WL[body.link] * p).norm();
      double bound = 0.0;
      for (int j = 0; j < 6; ++j) bound += levers[6 * k + j] * std::abs(b[j] - a[j]);
      ASSERT_LE(moved, bound + 1e-12);
      if (bound > 0.0) closest = std::max(closest, moved / bound);
    }
  }
  EXPECT_GT(closest, 0.9) << "the bound is not tight";
}

TEST(Simplify, KeepsTheClearanceOfThePath) {
  int nearer = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Random random(seed);
    Scene scene(10, random);
    PlanOptions options;
    options.simplify = false;
    const auto free = [&] {
      Floats q;
      do {
        q = scene.draw(random);
      } while (!scene.validity.edge_free(q.data(), q.data(), {.clearance = 0.02}));
      return std::vector<double>(q.begin(), q.begin() + 6);
    };
    const std::vector<double> start = free(), goal = free();
    // A path with clearance: planned with the wanted clearance as padding.
    ValidityOptions roomy;
    roomy.padding = 0.021;
    Validity padded({CellGeometry({test::puma()}, 0)}, scene.world, roomy);
    const Plan found = plan(padded, start, goal, options);
    if (!found.solved()) continue;
    const auto keeps = [&](const Plan& plan) {
      for (std::size_t i = 0; i + 1 < plan.path.size(); ++i) {
        Floats a(8, 0.0F), b(8, 0.0F);
        std::copy(plan.path[i].begin(), plan.path[i].end(), a.begin());
        std::copy(plan.path[i + 1].begin(), plan.path[i + 1].end(), b.begin());
        if (!scene.validity.edge_free(a.data(), b.data(), {.clearance = 0.0199})) return false;
      }
      return true;
    };
    ASSERT_TRUE(keeps(found)) << seed;
    Plan clear = found, nearest = found;
    options.shortcuts.clearance = 0.02;
    simplify(scene.validity, options, clear);
    EXPECT_TRUE(keeps(clear)) << seed;
    EXPECT_LE(clear.length, found.length + 1e-6);
    options.shortcuts.clearance = 0.0;
    simplify(scene.validity, options, nearest);
    nearer += keeps(nearest) ? 0 : 1;
  }
  EXPECT_GT(nearer, 0) << "no shortcut came close to the world";
}

/// Smallest exact distance at steps + 1 configurations of the edge.
double sampled_clearance(const Validity& validity, const Configuration& a, const Configuration& b, int steps) {
  double least = std::numeric_limits<double>::infinity();
  Configuration q(a.size());
  for (int k = 0; k <= steps; ++k) {
    for (std::size_t j = 0; j < q.size(); ++j) q[j] = a[j] + (b[j] - a[j]) * k / steps;
    least = std::min(least, validity.nearest(q).distance);
  }
  return least;
}

/// Random edges of at most `reach` per joint. `between`: between samples, the clearance is smaller by at most this [m].
void compare_clearance(const Validity& validity, double reach, int steps, double between, int edges, Random& random) {
  const Space space = space_of(validity);
  std::vector<float> q(space.stride);
  for (int i = 0; i < edges; ++i) {
    space.sample(random, q.data());
    const Configuration a(q.begin(), q.begin() + space.dimensions);
    Configuration b = a;
    for (double& x : b) x += random.uniform(-reach, reach);
    const double sampled = sampled_clearance(validity, a, b, steps);
    if (sampled <= 0.0) continue;  // depths are not compared
    const double bound = validity.clearance(a, b);
    EXPECT_LE(bound, sampled) << "edge " << i;
    EXPECT_GE(bound, sampled * (1.0 - 2e-3) - 2e-6 - between) << "edge " << i;
  }
}

TEST(Clearance, IsATightLowerBound) {
  Random random(5);
  for (int scene = 0; scene < 4; ++scene) {
    const Validity validity({CellGeometry({test::puma()}, 0)}, test::random_boxes(4, random));
    compare_clearance(validity, 0.5, 400, 5e-3, 10, random);
  }
}

TEST(Clearance, IsATightLowerBoundForSeveralArms) {
  Random random(6);
  std::vector<Arm> arms = {test::puma("one"), test::puma("two")};
  arms[1].X_WB.translation() = Eigen::Vector3d(0.9, 0.0, 0.0);
  const Validity validity({CellGeometry(arms, 0), CellGeometry(arms, 1)}, test::random_boxes(2, random));
  compare_clearance(validity, 0.3, 400, 8e-3, 20, random);
}

TEST(Clearance, FindsContactBetweenSamples) {
  // A needle that the wrist touches only for a moment, halfway along the edge.
  WorldBody needle{world::Sphere{0.001}, Pose::Identity(), "needle"};
  const Configuration a{-0.5, 0.0, 1.5, 0.0, 0.0, 0.0};
  Configuration b = a;
  b[0] = 0.5;
  needle.X_WS.translation() = Eigen::Vector3d(0.95, 0.15, 0.67);
  const Validity validity({CellGeometry({test::puma()}, 0)}, std::vector{needle});
  EXPECT_LE(validity.clearance(a, b), sampled_clearance(validity, a, b, 100'000));
}

}  // namespace
}  // namespace hecaton::planner::global
