#include "planner/route/multi_arm_coordinator.hpp"

#include <memory>

#include <gtest/gtest.h>

#include "tests/support/planar_point.hpp"
#include "tests/unit/planner/route/walls.hpp"

namespace hecaton::planner {
namespace {

using test::joints;

/// The first of two arms, which are far apart; the second one has proposed a plan for both.
class CoupledPlanOfTwo : public testing::Test {
 protected:
  CoupledPlanOfTwo() : arms_(2) {
    controller_.set_obstacles({});
    controller_.set_goal(joints({0.5, 0}));
    auto plan = std::make_shared<CoupledPlan>();
    plan->number = 1;
    plan->arms = {0, 1};
    for (const double x : {0.0, 0.25, 0.5}) plan->points.push_back({joints({x, 0}), joints({x, 2})});
    ArmObservation& other = arms_[1];
    other.known = other.plans = other.has_goal = true;
    other.q = joints({0, 2});
    other.qd = joints({0, 0});
    other.q_goal = joints({0.5, 2});
    other.proposal = plan;
    other.progress = {1, 1, 0};
  }
  void step() {
    const TickResult result = controller_.step(measured_, arms_, {}, false);
    (void)policy_.next(controller_, result, arms_, {});
    if (policy_.target()) {
      controller_.follow_coupled_plan(*policy_.target());
    } else {
      controller_.leave_coupled_plan();
    }
    measured_ = {result.q, result.qd};
  }
  void steps(int count) {
    for (int i = 0; i < count; ++i) step();
  }

  LocalParameters parameters_;
  ArmController controller_{CellGeometry({test::planar_point("one"), test::planar_point("other")}, 0), parameters_,
                            0.01, 3};
  MultiArmCoordinator policy_{parameters_, 7};
  std::vector<ArmObservation> arms_;
  MeasuredState measured_{joints({0, 0}), joints({0, 0})};
};

TEST_F(CoupledPlanOfTwo, FollowsThePlanAndWaitsAtEachPoint) {
  steps(2);
  EXPECT_TRUE(policy_.participating());
  EXPECT_EQ(policy_.progress().proposer, 1);
  EXPECT_EQ(policy_.left(), (std::vector{joints({0.25, 0}), joints({0.5, 0})}));
  steps(200);
  EXPECT_TRUE(policy_.participating());
  EXPECT_NEAR(measured_.q[0], 0.25, 0.01) << "the other has not reached the next point";
  arms_[1].progress.reached = 1;
  steps(200);
  EXPECT_NEAR(measured_.q[0], 0.5, 0.01);
  EXPECT_EQ(policy_.progress().reached, 2);
}

TEST_F(CoupledPlanOfTwo, EndsAtOnceWhenAnotherArmStopsPlanning) {
  steps(10);
  ASSERT_TRUE(policy_.participating());
  arms_[1].plans = false;  // held, stopped, or its planner is gone; its last progress still names the plan
  step();
  EXPECT_FALSE(policy_.participating());
  EXPECT_TRUE(policy_.left().empty());
  arms_[1].plans = true;
  steps(10);
  EXPECT_FALSE(policy_.participating()) << "the arm does not join a plan again";
}

TEST_F(CoupledPlanOfTwo, EndsAtOnceWhenAnotherArmIsLost) {
  steps(10);
  ASSERT_TRUE(policy_.participating());
  arms_[1].position_uncertainty = joints({0.1, 0.1});
  step();
  EXPECT_FALSE(policy_.participating());
}

TEST_F(CoupledPlanOfTwo, IsNotJoinedIfItEndsElsewhere) {
  controller_.set_goal(joints({0.5, 1}));
  steps(10);
  EXPECT_FALSE(policy_.participating());
}

/// A ball before an endless wall; a second ball rests nearby.
class BlockedBall {
 public:
  BlockedBall() : boxes_({test::box_obstacle("wall", {0.5, 0, 0}, {0.1, 4, 0.5})}), states_(test::states_of(boxes_)) {
    parameters_.rollout.candidates = 0;
    parameters_.replanning.stall_timeout = 0.0;
    parameters_.coordination.stall_timeout = 0.5;
    policy_.emplace(parameters_, 7, 100);
    controller_.emplace(CellGeometry({test::planar_point("a"), test::planar_point("b")}, 0), parameters_, 0.01, 3);
    controller_->set_obstacles(boxes_);
    controller_->set_goal(joints({1, 0}));
    measured_ = {joints({0, 0}), joints({0, 0})};
    arms_[1].q = joints({0, 0.4});
    arms_[1].qd = joints({0, 0});
    arms_[1].known = arms_[1].plans = true;
  }

  std::optional<RouteQuestion> step(bool hold = false) {
    const TickResult result = controller_->step(measured_, arms_, states_, hold);
    measured_ = {result.q, result.qd};
    return policy_->next(*controller_, result, arms_, states_);
  }
  /// True if the policy asks within this time [s].
  bool asks(double within = 60.0) {
    for (int period = 0; period * 0.01 < within; ++period) {
      if (step()) return true;
    }
    return false;
  }
  static RouteAnswer answer() {
    RouteAnswer found;
    found.kind = RouteAnswer::Kind::kFound;
    found.points = {{joints({0.2, 0}), joints({0, 0.4})}, {joints({1, 0}), joints({0, 0.4})}};
    return found;
  }

  MultiArmCoordinator& policy() { return *policy_; }

 private:
  LocalParameters parameters_;
  std::vector<world::Obstacle> boxes_;
  std::vector<world::ObstacleState> states_;
  std::optional<MultiArmCoordinator> policy_;
  std::optional<ArmController> controller_;
  std::vector<ArmObservation> arms_{2};
  MeasuredState measured_;
};

TEST(MultiArmCoordinator, ProposesThePlanThatWasFound) {
  BlockedBall arm;
  ASSERT_TRUE(arm.asks());
  arm.policy().receive(BlockedBall::answer());
  ASSERT_NE(arm.policy().proposal(), nullptr);
  EXPECT_GT(arm.policy().proposal()->number, 100U) << "numbers of an earlier planner are not reused";
  arm.step();
  EXPECT_TRUE(arm.policy().participating());
}

TEST(MultiArmCoordinator, IgnoresTheAnswerAfterWithdrawal) {
  BlockedBall arm;
  ASSERT_TRUE(arm.asks());
  arm.policy().withdraw();
  arm.policy().receive(BlockedBall::answer());
  EXPECT_EQ(arm.policy().proposal(), nullptr);
  // The answer to the next question counts again.
  ASSERT_TRUE(arm.asks());
  arm.policy().receive(BlockedBall::answer());
  EXPECT_NE(arm.policy().proposal(), nullptr);
}

TEST(MultiArmCoordinator, DropsItsProposalWhenHeld) {
  BlockedBall arm;
  ASSERT_TRUE(arm.asks());
  arm.policy().receive(BlockedBall::answer());
  arm.step();
  ASSERT_NE(arm.policy().proposal(), nullptr);
  arm.step(true);
  EXPECT_FALSE(arm.policy().participating());
  EXPECT_EQ(arm.policy().proposal(), nullptr);
}

}  // namespace
}  // namespace hecaton::planner
