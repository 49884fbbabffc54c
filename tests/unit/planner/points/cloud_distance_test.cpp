#include "planner/collision/cloud_distance.hpp"

#include <cstring>
#include <limits>
#include <memory>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>

#include "planner/collision/exact_distance.hpp"
#include "planner/collision/pass_kernels.hpp"
#include "planner/simd/instruction_set.hpp"
#include "tests/unit/planner/collision/random_cell.hpp"
#include "tests/unit/planner/points/clouds.hpp"

namespace hecaton::planner {
namespace {

using test::Random;
using test::uniform;
using world::PointCloud;
using world::Pose;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// The ball at p_P of the cloud at X_WP.
ShapeDistance ball_distance(const SweptCore& a, const Pose& X_WA, const PointCloud& cloud, const Pose& X_WP,
                            const Eigen::Vector3f& p_P) {
  return prepared_distance(a, X_WA, make_swept_core(world::Sphere{cloud.radius()}),
                           Pose(Eigen::Translation3d(X_WP * p_P.cast<double>())));
}

double brute_force(const SweptCore& a, const Pose& X_WA, const PointCloud& cloud, const Pose& X_WP) {
  double least = kInfinity;
  for (const Eigen::Vector3f& point : cloud.points()) {
    least = std::min(least, ball_distance(a, X_WA, cloud, X_WP, point).distance);
  }
  return least;
}

// 100,000 queries in all.
TEST(CloudDistance, IsThatOfTheNearestBall) {
  Random random(3);
  struct Case {
    test::Kind kind;
    int clouds;
    int queries;
  };
  for (const Case& one :
       {Case{test::Kind::kCapsule, 40, 1400}, Case{test::Kind::kSphere, 40, 1000}, Case{test::Kind::kBox, 20, 80},
        Case{test::Kind::kCylinder, 20, 80}, Case{test::Kind::kConvex, 20, 40}}) {
    const bool thin = one.kind == test::Kind::kCapsule || one.kind == test::Kind::kSphere;
    for (int i = 0; i < one.clouds; ++i) {
      const int count = 1 + static_cast<int>(random() % (thin ? 300 : 60));
      const auto cloud = test::cloud_of(test::random_points(count, random), uniform(random, 0.002, 0.05));
      const Pose X_WP = test::random_pose(random, 0.5);
      for (int query = 0; query < one.queries; ++query) {
        const SweptCore core = make_swept_core(test::random_shape(one.kind, random));
        const Pose X_WA = test::random_pose(random, 1.0);
        const double expected = brute_force(core, X_WA, *cloud, X_WP);
        const ShapeDistance found = cloud_distance({core, X_WA}, *cloud, X_WP, kInfinity);
        const double error = thin ? 1e-9 : expected > 0.0 ? 2e-6 : 1e-4;
        ASSERT_NEAR(found.distance, expected, error) << test::kKindNames[static_cast<int>(one.kind)] << " " << i;
        ASSERT_NEAR((found.p_b_W - found.p_a_W - found.distance * found.n_W).norm(), 0.0, 1e-9);
        ASSERT_EQ(cloud_distance({core, X_WA}, *cloud, X_WP, found.distance - 1e-5).distance, kInfinity);
      }
    }
  }
}

// Each ball within the limit is behind the plane of a pair, up to what planes let through, unless all pairs are used.
TEST(CloudDistance, IsTheSameFromEitherSideAndOfNoTwoClouds) {
  const world::Shape cloud =
      world::Points{std::make_shared<const PointCloud>(std::vector<Eigen::Vector3f>{{0, 0, 0}, {1, 0, 0}}, 0.1)};
  const world::Shape ball = world::Sphere{0.2};
  const Pose beside(Eigen::Translation3d(1.0, 0.5, 0.0));
  const ShapeDistance one = shape_distance(cloud, Pose::Identity(), ball, beside);
  const ShapeDistance other = shape_distance(ball, beside, cloud, Pose::Identity());
  EXPECT_NEAR(one.distance, 0.2, 1e-12);
  EXPECT_EQ(one.distance, other.distance);
  EXPECT_EQ(one.p_a_W, other.p_b_W);
  EXPECT_EQ(one.n_W, -other.n_W);
  EXPECT_THROW(static_cast<void>(shape_distance(cloud, Pose::Identity(), cloud, beside)), std::logic_error);
}

TEST(CloudDistance, PairsStandForAllBalls) {
  Random random(4);
  int most = 0;
  for (int i = 0; i < 2000; ++i) {
    const auto cloud = test::cloud_of(test::random_points(400, random), 0.01);
    const Pose X_WP = test::random_pose(random, 0.3);
    const SweptCore core = make_swept_core(test::random_shape(test::Kind::kCapsule, random));
    const Pose X_WA = test::random_pose(random, 1.0);
    const double limit = 0.3;
    ShapeDistance pairs[kMostBallPairs];
    const int count = nearest_balls({core, X_WA}, *cloud, X_WP, limit, pairs);
    most = std::max(most, count);
    const double nearest = brute_force(core, X_WA, *cloud, X_WP);
    ASSERT_EQ(count > 0, nearest < limit);
    if (count == 0) continue;
    ASSERT_NEAR(pairs[0].distance, nearest, 1e-9);
    for (int k = 1; k < count; ++k) ASSERT_GE(pairs[k].distance, pairs[k - 1].distance);
    for (const Eigen::Vector3f& point : cloud->points()) {
      const double distance = ball_distance(core, X_WA, *cloud, X_WP, point).distance;
      if (distance >= limit) continue;
      const Eigen::Vector3d centre_W = X_WP * point.cast<double>();
      bool stands = count == kMostBallPairs && distance >= pairs[count - 1].distance - 1e-9;
      for (int k = 0; k < count; ++k) {
        const Eigen::Vector3d ball_W = pairs[k].p_b_W + cloud->radius() * pairs[k].n_W;
        const double through = std::min(0.01, 0.25 * std::max(pairs[k].distance, 0.0));
        stands = stands || pairs[k].n_W.dot(centre_W - ball_W) >= -through - 1e-6;
      }
      ASSERT_TRUE(stands) << i;
    }
  }
  EXPECT_GT(most, 2);
}

TEST(CloudDistance, FlatSurfaceGivesOnePairAndCornerOneForEachSide) {
  test::CloudPoints points;
  for (int i = -50; i <= 50; ++i) {
    for (int k = -50; k <= 50; ++k) {
      const float x = 0.01F * static_cast<float>(i);
      const float y = 0.01F * static_cast<float>(k);
      points.emplace_back(x, y, 0.0F);              // a table
      if (k >= 0) points.emplace_back(0.5F, x, y);  // a wall
    }
  }
  const auto cloud = test::cloud_of(points, 0.01);
  const SweptCore link = make_swept_core(world::Capsule{0.05, 0.1});
  Pose X_WA = Pose::Identity();
  ShapeDistance pairs[kMostBallPairs];
  X_WA.translation() = Eigen::Vector3d(-0.2, 0.0, 0.25);
  EXPECT_EQ(nearest_balls({link, X_WA}, *cloud, Pose::Identity(), 0.3, pairs), 1);
  X_WA.translation() = Eigen::Vector3d(0.38, 0.0, 0.22);
  ASSERT_EQ(nearest_balls({link, X_WA}, *cloud, Pose::Identity(), 0.3, pairs), 2);
  EXPECT_NEAR(pairs[0].distance, 0.06, 1e-6);
  EXPECT_NEAR(pairs[1].distance, 0.06, 1e-6);
  EXPECT_NEAR(pairs[0].n_W.dot(pairs[1].n_W), 0.0, 1e-3);
}

/// A cell's geometry with a cloud beside its own obstacles.
std::vector<world::Obstacle> with_cloud(const std::shared_ptr<const PointCloud>& cloud, const Pose& X_OS) {
  world::Obstacle obstacle;
  obstacle.name = "cloud";
  obstacle.shapes = {{world::Points{cloud}, X_OS}};
  return {obstacle};
}

TEST(Clearances, OfACloudAreThoseOfItsBallsOnAllInstructionSets) {
  Random random(5);
  int near = 0;
  for (int seed = 0; seed < 30; ++seed) {
    for (const LinkShapes shapes : {LinkShapes::kFast, LinkShapes::kExact}) {
      test::RandomCell cell(static_cast<std::uint64_t>(seed), shapes, 1, 2);
      CellGeometry geometry = cell.geometry();
      const auto cloud = test::cloud_of(test::random_points(500, random), 0.01);
      const Pose X_OS = test::random_pose(random, 0.2);
      geometry.set_obstacles(with_cloud(cloud, X_OS));
      std::vector<PassKernel> kernels = {baseline::run_pass};
      if (fastest_pass() != baseline::run_pass) kernels.push_back(fastest_pass());
      for (int i = 0; i < 20; ++i) {
        const Arm& arm = geometry.own_arm();
        Kinematics kinematics;
        JointVector q(arm.model->joints());
        for (double& angle : q) angle = uniform(random, -3.0, 3.0);
        forward_kinematics(*arm.model, arm.X_WB, q, kinematics);
        std::vector<world::ObstacleState> states(1);
        states[0].X_WO = test::random_pose(random, 1.0);
        const CellPoses poses{&kinematics, {&kinematics, 1}, states};
        std::vector<std::vector<Clearance>> found;
        for (const PassKernel kernel : kernels) {
          ExactDistance distance(geometry, kernel);
          found.emplace_back(256);
          found.back().resize(static_cast<std::size_t>(distance.clearances(poses, {.others = 0.2}, found.back())));
        }
        for (const auto& other : found) {
          ASSERT_EQ(other.size(), found.front().size());
          for (std::size_t k = 0; k < other.size(); ++k) {
            ASSERT_EQ(other[k].distance, found.front()[k].distance);
            ASSERT_EQ(other[k].p_own_W, found.front()[k].p_own_W);
            ASSERT_EQ(other[k].n_W, found.front()[k].n_W);
          }
        }
        for (int own = 0; own < static_cast<int>(geometry.own_bodies().size()); ++own) {
          const Body& body = geometry.own_bodies()[own];
          if (!body.moves) continue;
          const world::Shape shape = body.capsule ? world::Shape(body.capsule->capsule) : body.shape;
          const Pose X_WS = kinematics.X_WL[body.link] * (body.capsule ? body.capsule->X_FS : body.X_CS);
          const double expected = brute_force(make_swept_core(shape), X_WS, *cloud, states[0].X_WO * X_OS);
          double nearest = kInfinity;
          for (const Clearance& c : found.front()) {
            if (c.counterpart == Counterpart::kObstacle && c.own_body == own) nearest = std::min(nearest, c.distance);
          }
          if (expected < 0.2 - 1e-5) {
            ASSERT_NEAR(nearest, expected, expected > 0.0 ? 2e-6 : 1e-4);
            ++near;
          } else if (expected > 0.2 + 1e-5) {
            ASSERT_EQ(nearest, kInfinity);
          }
        }
      }
    }
  }
  EXPECT_GT(near, 500);
}

}  // namespace
}  // namespace hecaton::planner
