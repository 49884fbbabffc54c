#include <gtest/gtest.h>

#include "planner/route/multi_arm_coordinator.hpp"
#include "tests/unit/planner/route/room.hpp"

namespace hecaton::planner {
namespace {

using test::joints;

/// A ball before a wall without end, another one that stands beside it, period by period.
class Stuck {
 public:
  Stuck() : boxes_({test::box_obstacle("wall", {0.5, 0, 0}, {0.1, 4, 0.5})}), states_(test::states_of(boxes_)) {
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
  /// Whether it asks within so long [s].
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

TEST(CoupledPlanSearch, ProposesWhatWasFound) {
  Stuck arm;
  ASSERT_TRUE(arm.asks());
  arm.policy().answered(Stuck::answer());
  ASSERT_NE(arm.policy().proposal(), nullptr);
  EXPECT_GT(arm.policy().proposal()->number, 100U) << "numbers of a planner that was here before are not used again";
  arm.step();
  EXPECT_TRUE(arm.policy().takes_part());
}

TEST(CoupledPlanSearch, WhoWasRelievedMeanwhileProposesNothing) {
  Stuck arm;
  ASSERT_TRUE(arm.asks());
  arm.policy().resign();
  arm.policy().answered(Stuck::answer());
  EXPECT_EQ(arm.policy().proposal(), nullptr);
  // The next question is one again.
  ASSERT_TRUE(arm.asks());
  arm.policy().answered(Stuck::answer());
  EXPECT_NE(arm.policy().proposal(), nullptr);
}

TEST(CoupledPlanSearch, WhoIsHeldWithdrawsItsProposal) {
  Stuck arm;
  ASSERT_TRUE(arm.asks());
  arm.policy().answered(Stuck::answer());
  arm.step();
  ASSERT_NE(arm.policy().proposal(), nullptr);
  arm.step(true);
  EXPECT_FALSE(arm.policy().takes_part());
  EXPECT_EQ(arm.policy().proposal(), nullptr);
}

}  // namespace
}  // namespace hecaton::planner
