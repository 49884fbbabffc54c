#include "planner/route/multi_arm_coordinator.hpp"

#include <memory>

#include <gtest/gtest.h>

#include "tests/support/planar_point.hpp"

namespace hecaton::planner {
namespace {

using test::joints;

/// The first of two arms far from each other, period by period; the other one has proposed a plan for both.
class WithAPartner : public testing::Test {
 protected:
  WithAPartner() : arms_(2) {
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
    if (policy_.aim()) {
      controller_.follow_coupled_plan(*policy_.aim());
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

TEST_F(WithAPartner, GoesByItsPlanAndWaitsForItAtEveryPoint) {
  steps(2);
  EXPECT_TRUE(policy_.takes_part());
  EXPECT_EQ(policy_.progress().proposer, 1);
  steps(200);
  EXPECT_TRUE(policy_.takes_part());
  EXPECT_NEAR(measured_.q[0], 0.25, 0.01) << "the other has not reached the next point";
  arms_[1].progress.reached = 1;
  steps(200);
  EXPECT_NEAR(measured_.q[0], 0.5, 0.01);
  EXPECT_EQ(policy_.progress().reached, 2);
}

TEST_F(WithAPartner, APartnerThatFailsEndsThePlanAtOnce) {
  steps(10);
  ASSERT_TRUE(policy_.takes_part());
  arms_[1].plans = false;  // held, stopped, or its planner is gone: what it said last still says that it takes part
  step();
  EXPECT_FALSE(policy_.takes_part());
  arms_[1].plans = true;
  steps(10);
  EXPECT_FALSE(policy_.takes_part()) << "a plan that was left is not joined again";
}

TEST_F(WithAPartner, APartnerThatIsLostEndsThePlanAtOnce) {
  steps(10);
  ASSERT_TRUE(policy_.takes_part());
  arms_[1].position_uncertainty = joints({0.1, 0.1});
  step();
  EXPECT_FALSE(policy_.takes_part());
}

TEST_F(WithAPartner, DoesNotJoinWhatLeadsElsewhere) {
  controller_.set_goal(joints({0.5, 1}));
  steps(10);
  EXPECT_FALSE(policy_.takes_part());
}

}  // namespace
}  // namespace hecaton::planner
