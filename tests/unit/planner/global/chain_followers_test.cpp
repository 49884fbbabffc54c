// The global planners' kernel and bounds for links that follow joints of others.

#include <cmath>

#include "planner/global/validity.hpp"
#include "planner/local/latency_compensation.hpp"
#include "planner/local/random.hpp"
#include "planner/methods/potential_field/free_motion.hpp"
#include "planner/model/kinematics.hpp"
#include "tests/support/mechanisms.hpp"

namespace hecaton::planner::global {
namespace {

Arm arm_of(std::shared_ptr<const RobotModel> model) {
  Arm arm;
  arm.name = "arm";
  arm.limits = model->limits;
  arm.model = std::move(model);
  arm.shapes = LinkShapes::kExact;
  return arm;
}

class KernelWithFollowers : public testing::TestWithParam<test::Mechanism> {
 protected:
  std::shared_ptr<const RobotModel> model_ = GetParam().load(false);
  Arm arm_ = arm_of(model_);
  Arm independent_ = arm_of(GetParam().load(true));
  CellGeometry geometry_{{arm_}, 0};
  std::mt19937_64 random_{7};

  [[nodiscard]] std::vector<WorldBody> boxes(int count) {
    std::uniform_real_distribution<double> along(-1.5, 1.5);
    std::vector<WorldBody> world;
    for (int i = 0; i < count; ++i) {
      const Eigen::Vector3d at(along(random_), along(random_), along(random_));
      if (at.norm() < 0.5) continue;
      world.push_back({world::Box{{0.15, 0.1, 0.2}}, Pose(Eigen::Translation3d(at)), "box"});
    }
    return world;
  }
  [[nodiscard]] static std::vector<float> row(const Validity& validity, const JointVector& q) {
    std::vector<float> floats(validity.stride(), 0.0F);
    for (Eigen::Index j = 0; j < q.size(); ++j) floats[j] = static_cast<float>(q[j]);
    return floats;
  }
};

TEST_P(KernelWithFollowers, DecidesAsForEquivalentJoints) {
  int free = 0;
  int hit = 0;
  for (int scene = 0; scene < 20; ++scene) {
    const std::vector<WorldBody> world = boxes(12);
    const Validity one({geometry_}, world);
    const Validity other({CellGeometry({independent_}, 0)}, world);
    for (int trial = 0; trial < 100; ++trial) {
      const JointVector q = test::random_joints(model_->limits, random_);
      const JointVector all = GetParam().positions(q);
      const bool is_free = one.state_free(row(one, q).data());
      const double margin = one.tightest(std::vector<double>(q.begin(), q.end())).distance;
      if (std::abs(margin) < 5e-3) continue;  // the kernel rounds to the safe side by a share of the arm's size
      ASSERT_EQ(is_free, other.state_free(row(other, all).data()));
      ++(is_free ? free : hit);
    }
  }
  EXPECT_GT(free, 100);
  EXPECT_GT(hit, 100);
}

TEST_P(KernelWithFollowers, ProvesOnlyFreeEdges) {
  int proven = 0;
  for (int scene = 0; scene < 20; ++scene) {
    const Validity validity({geometry_}, boxes(8));
    for (int trial = 0; trial < 20; ++trial) {
      const JointVector a = test::random_joints(model_->limits, random_);
      const JointVector b = a + 0.3 * (test::random_joints(model_->limits, random_) - a);
      if (!validity.edge_free(row(validity, a).data(), row(validity, b).data())) continue;
      ++proven;
      double least = INFINITY;
      for (int s = 0; s <= 200; ++s) {
        const JointVector q = a + s / 200.0 * (b - a);
        least = std::min(least, validity.nearest(std::vector<double>(q.begin(), q.end())).distance);
      }
      EXPECT_GT(least, -1e-9);
      const double clearance = validity.clearance(std::vector<double>(a.begin(), a.end()),
                                                  std::vector<double>(b.begin(), b.end()), Validity::Pairs::kAll);
      EXPECT_LE(clearance, least + 1e-6);
      EXPECT_GT(clearance, 0.9 * least - 1e-2) << "the bound is not tight";
    }
  }
  EXPECT_GT(proven, 20);
}

TEST_P(KernelWithFollowers, BoundsMotions) {
  const auto bodies = geometry_.own_bodies();
  const std::vector<float> levers = body_levers({geometry_});
  const std::size_t axes = levers.size() / bodies.size();
  const Eigen::MatrixXd gains = GetParam().gains().cwiseAbs();
  ASSERT_EQ(axes, GetParam().moving.size());
  potential::FreeMotion motion(geometry_, {}, {}, 0.0);
  double fullest = 0.0;
  for (int trial = 0; trial < 3000; ++trial) {
    const JointVector a = test::random_joints(model_->limits, random_);
    JointVector b = test::random_joints(model_->limits, random_);
    if (trial % 2 == 0) {
      const auto only = static_cast<Eigen::Index>(random_() % a.size());
      const double moved = a[only] + 0.01;
      b = a;
      b[only] = moved;
    }
    const Eigen::VectorXd way = gains * (b - a).cwiseAbs();
    Kinematics at_a;
    Kinematics at_b;
    forward_kinematics(*model_, arm_.X_WB, a, at_a);
    forward_kinematics(*model_, arm_.X_WB, b, at_b);
    for (std::size_t k = 0; k < bodies.size(); ++k) {
      const Body& body = bodies[k];
      const Eigen::Vector3d p = body.bound.centre + body.bound.radius * Eigen::Vector3d(0.6, 0.0, 0.8);
      const double moved = (at_a.X_WL[body.link] * p - at_b.X_WL[body.link] * p).norm();
      double bound = 0.0;
      for (std::size_t i = 0; i < axes; ++i) bound += levers[axes * k + i] * way[static_cast<Eigen::Index>(i)];
      ASSERT_LE(moved, bound + 1e-9);
      if (bound > 0.0) fullest = std::max(fullest, moved / bound);
      const double extent = body.bound.centre.norm() + body.bound.radius;
      ASSERT_LE(moved, longest_levers(arm_, body.link, extent).dot((b - a).cwiseAbs()) + 1e-9);
      ASSERT_LE(moved, motion.sweep(b - a) + 1e-9);
    }
  }
  EXPECT_GT(fullest, 0.5);
}

INSTANTIATE_TEST_SUITE_P(Mechanisms, KernelWithFollowers, testing::ValuesIn(test::mechanisms()), test::CaseName());

}  // namespace
}  // namespace hecaton::planner::global
