// Bounds on speeds against the speeds of points, and instruction sets against each other.
#include "planner/model/kinematics.hpp"
#include "planner/model/kinematics_kernels.hpp"
#include "planner/simd/instruction_set.hpp"
#include "tests/unit/planner/model/support.hpp"

namespace hecaton::planner {
namespace {

struct Drawn {
  Kinematics kinematics;
  std::array<double, kMaxJoints> speed{};
  std::vector<CarriedBall> balls;

  Drawn(const RobotModel& model, std::mt19937_64& random) {
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    JointVector q(model.joints());
    for (double& angle : q) angle = 3.0 * unit(random);
    forward_kinematics(model, Pose(Eigen::Translation3d(unit(random), unit(random), 0.0)), q, kinematics);
    for (int j = 0; j < model.joints(); ++j) speed[j] = 1.0 + unit(random);
    for (int link = 0; link < kinematics.links; ++link) {
      CarriedBall& ball = balls.emplace_back();
      ball.X_WL = kinematics.X_WL[link].data();
      for (double& c : ball.centre_L) c = 0.3 * unit(random);
      ball.radius = 0.1 * (1.0 + unit(random));
      ball.axes = axes_before(model, link);
    }
  }

  void bound(SpeedKernel kernel) {
    const auto& w = kinematics.angular_W;
    const auto& v = kinematics.linear_W;
    kernel({{w[0].data(), w[1].data(), w[2].data()}, {v[0].data(), v[1].data(), v[2].data()}}, speed.data(),
           balls.data(), static_cast<int>(balls.size()));
  }
};

std::shared_ptr<const RobotModel> model_with_a_slide() {
  auto model = std::make_shared<RobotModel>(*load_urdf(test::kPuma));
  for (Link& link : model->links) {
    if (link.joint == 2) link.joint_type = JointType::kPrismatic;
  }
  return model;
}

class SpeedBound : public testing::TestWithParam<bool> {
 protected:
  std::shared_ptr<const RobotModel> model_ = GetParam() ? model_with_a_slide() : load_urdf(test::kPuma);
  std::mt19937_64 random_{11};
};

TEST_P(SpeedBound, HoldsForAllPointsOfABall) {
  std::normal_distribution<double> normal;
  double tightest = 0.0;
  for (int trial = 0; trial < 2000; ++trial) {
    Drawn drawn(*model_, random_);
    drawn.bound(baseline::bound_speeds);
    JointVector qd(model_->joints());
    for (int j = 0; j < qd.size(); ++j) qd[j] = random_() % 2 == 0 ? drawn.speed[j] : -drawn.speed[j];
    for (std::size_t i = 0; i < drawn.balls.size(); ++i) {
      const CarriedBall& ball = drawn.balls[i];
      const Eigen::Vector3d out = Eigen::Vector3d(normal(random_), normal(random_), normal(random_)).normalized();
      const Eigen::Vector3d p_W = Eigen::Map<const Eigen::Vector3d>(ball.centre_W) + ball.radius * out;
      PointJacobian J(3, qd.size());
      point_jacobian(*model_, drawn.kinematics, static_cast<int>(i), p_W, J);
      const double speed = (J * qd).norm();
      ASSERT_LE(speed, ball.fastest + 1e-12) << "trial " << trial << ", link " << i;
      if (ball.axes > 0) tightest = std::max(tightest, speed / ball.fastest);
    }
  }
  EXPECT_GT(tightest, 0.95);  // the bound is nearly reached
}

TEST_P(SpeedBound, IsBitIdenticalForAllInstructionSets) {
  if (!has_avx2()) GTEST_SKIP();
  for (int trial = 0; trial < 500; ++trial) {
    Drawn one(*model_, random_);
    one.bound(baseline::bound_speeds);
    const std::vector<CarriedBall> expected = one.balls;
    one.bound(avx2::bound_speeds);
    for (std::size_t i = 0; i < expected.size(); ++i) {
      EXPECT_EQ(one.balls[i].fastest, expected[i].fastest);
      for (int k = 0; k < 3; ++k) EXPECT_EQ(one.balls[i].centre_W[k], expected[i].centre_W[k]);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Arms, SpeedBound, testing::Bool(),
                         [](const auto& slides) { return slides.param ? "WithASlide" : "Puma"; });

}  // namespace
}  // namespace hecaton::planner
