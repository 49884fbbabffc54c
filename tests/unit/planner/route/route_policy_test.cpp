#include "planner/route/route_policy.hpp"

#include <optional>
#include <utility>

#include <gtest/gtest.h>

#include "tests/unit/planner/route/walls.hpp"

namespace hecaton::planner {
namespace {

using test::joints;

/// One arm with its policy and its search. Answers take two periods.
class ArmWithPolicy {
 public:
  ArmWithPolicy(const std::vector<world::Obstacle>& boxes, double stall_timeout)
      : boxes_(boxes), states_(test::states_of(boxes)) {
    parameters_.replanning.stall_timeout = stall_timeout;
    parameters_.rollout.candidates = 0;
    policy_.emplace(parameters_, 7);
    controller_.emplace(CellGeometry({test::planar_point()}, 0), parameters_, 0.01, 3);
    controller_->set_obstacles(boxes);
    search_.set_obstacles(boxes);
  }

  void start(const JointVector& from, const JointVector& to) {
    measured_ = {from, joints({0, 0})};
    controller_->set_goal(to);
  }

  TickResult step() {
    if (waiting_ && --delay_ <= 0) {
      if (auto points = policy_->receive(*waiting_, *controller_)) controller_->follow(std::move(*points));
      waiting_.reset();
    }
    const std::vector<ArmObservation> arms(1);
    const TickResult result = controller_->step(measured_, arms, states_, false);
    const RoutePolicy::Next next = policy_->next(*controller_, result, arms, states_);
    if (next.leaves_route) controller_->follow({});
    if (next.question) {
      waiting_ = search_.answer(*next.question);
      delay_ = 2;
      ++questions;
    }
    measured_ = {result.q, result.qd};
    least_clearance = std::min(least_clearance, test::clearance_at(result.q, boxes_, states_));
    return result;
  }

  /// Moves to the goal. Returns the time taken [s], or −1 if the limit has passed.
  double drive(double limit) {
    for (int period = 1; period * 0.01 <= limit; ++period) {
      if (step().status == TickStatus::kReached) return period * 0.01;
    }
    return -1.0;
  }

  /// Steps until the policy has asked; the answer is pending.
  void until_asked() {
    for (int before = questions; questions == before;) step();
  }
  /// Moves the arm by hand.
  void place(const JointVector& q) { measured_ = {q, joints({0, 0})}; }
  void discard() { policy_->discard(); }

  [[nodiscard]] ArmController& controller() { return *controller_; }
  [[nodiscard]] const RoutePolicy& policy() const { return *policy_; }
  std::vector<world::ObstacleState>& states() { return states_; }

  double least_clearance = std::numeric_limits<double>::infinity();
  int questions = 0;

 private:
  LocalParameters parameters_;
  std::vector<world::Obstacle> boxes_;
  std::vector<world::ObstacleState> states_;
  std::optional<RoutePolicy> policy_;
  std::optional<ArmController> controller_;
  RouteSearch search_{{test::planar_point()}, {parameters_}, 0};
  MeasuredState measured_;
  std::optional<RouteAnswer> waiting_;
  int delay_ = 0;
};

/// A pocket open to the left, 2 m deep and wide. From inside, the path to a goal behind it leads back first.
std::vector<world::Obstacle> pocket() {
  return {test::box_obstacle("end", {1.0, 0, 0}, {0.1, 1.2, 0.5}),
          test::box_obstacle("floor", {0.0, -1.1, 0}, {1.1, 0.1, 0.5}),
          test::box_obstacle("roof", {0.0, 1.1, 0}, {1.1, 0.1, 0.5})};
}

TEST(RoutePolicy, LeadsOutOfAPocket) {
  ArmWithPolicy arm(pocket(), 0.5);
  arm.start(joints({0.5, 0.1}), joints({2, 0}));
  EXPECT_GT(arm.drive(60.0), 0.0);
  EXPECT_GE(arm.policy().begun(), 1);
  EXPECT_GT(arm.least_clearance, 0.0);
}

TEST(RoutePolicy, DoesNotAskWhileTheArmMakesProgress) {
  ArmWithPolicy arm({test::box_obstacle("far", {0, 2.5, 0}, {0.1, 0.1, 0.5})}, 0.5);
  arm.start(joints({-1, 0}), joints({1, 0}));
  EXPECT_GT(arm.drive(20.0), 0.0);
  EXPECT_EQ(arm.questions, 0);
}

TEST(RoutePolicy, NeverAsksWithoutStallTimeout) {
  ArmWithPolicy arm(pocket(), 0.0);
  arm.start(joints({0.5, 0.1}), joints({2, 0}));
  arm.drive(5.0);
  EXPECT_EQ(arm.questions, 0);
}

// Two gaps, y = 1.2 and y = 2.4. The nearer one closes while the arm moves towards it; the arm continues to the other
// one without stopping.
TEST(RoutePolicy, ReplacesABlockedRouteWithoutStopping) {
  const std::vector<world::Obstacle> boxes{test::box_obstacle("below", {0, -1.55, 0}, {0.1, 2.5, 0.5}),
                                           test::box_obstacle("middle", {0, 1.8, 0}, {0.1, 0.35, 0.5}),
                                           test::box_obstacle("above", {0, 3.4, 0}, {0.1, 0.75, 0.5}),
                                           test::box_obstacle("door", {0, 9, 0}, {0.1, 0.3, 0.5})};
  ArmWithPolicy arm(boxes, 0.3);
  arm.start(joints({-1, -0.5}), joints({1, -0.5}));
  while (!arm.controller().route().under_way()) arm.step();
  while (arm.controller().setpoint().qd[1] < 0.3) arm.step();
  ASSERT_TRUE(arm.controller().route().under_way());
  arm.states()[3].X_WO.translation().y() = 1.2;
  const int before = arm.policy().begun();
  double slowest = 1.0;
  for (int period = 0; period < 100; ++period) slowest = std::min(slowest, arm.step().qd.norm());
  EXPECT_EQ(arm.policy().begun(), before + 1);
  EXPECT_GT(slowest, 0.2);
  EXPECT_GT(arm.drive(60.0), 0.0);
  EXPECT_GT(arm.least_clearance, 0.0);
}

TEST(RoutePolicy, NewGoalEndsTheRoute) {
  ArmWithPolicy arm(pocket(), 0.3);
  arm.start(joints({0.5, 0.1}), joints({2, 0}));
  while (!arm.controller().route().under_way()) arm.step();
  arm.controller().set_goal(joints({-2, 0}));
  EXPECT_FALSE(arm.controller().route().under_way());
  EXPECT_FALSE(arm.controller().memory().detour.active);
  EXPECT_GT(arm.drive(20.0), 0.0);
}

// An answer is ignored if the arm has been moved, or discard() was called, since the question. The next answer counts.
TEST(RoutePolicy, IgnoresOutdatedAnswer) {
  for (const bool carried : {true, false}) {
    ArmWithPolicy arm(pocket(), 0.5);
    arm.start(joints({0.5, 0.1}), joints({2, 0}));
    arm.until_asked();
    ASSERT_FALSE(arm.controller().route().under_way());
    carried ? arm.place(joints({-0.7, -0.5})) : arm.discard();
    for (int period = 0; period < 5; ++period) arm.step();
    EXPECT_EQ(arm.policy().begun(), 0) << carried;
    EXPECT_FALSE(arm.controller().route().under_way()) << carried;
    EXPECT_EQ(arm.questions, 1);
    EXPECT_GT(arm.drive(60.0), 0.0) << carried;
    EXPECT_GE(arm.policy().begun(), 1) << carried;
  }
}

TEST(RoutePolicy, DiscardWithoutQuestionHasNoEffect) {
  ArmWithPolicy arm(pocket(), 0.5);
  arm.start(joints({0.5, 0.1}), joints({2, 0}));
  arm.step();
  arm.discard();
  arm.until_asked();
  for (int period = 0; period < 5; ++period) arm.step();
  EXPECT_EQ(arm.policy().begun(), 1);
}

}  // namespace
}  // namespace hecaton::planner
