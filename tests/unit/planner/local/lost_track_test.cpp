/// An arm that is not where its set-points say.

#include <algorithm>
#include <array>
#include <optional>

#include <gtest/gtest.h>

#include "planner/arm_controller.hpp"
#include "planner/methods/registry.hpp"
#include "tests/support/planar_point.hpp"

namespace hecaton::planner {
namespace {

using test::joints;
using test::kPeriod;

/// A position servo with the lag of a first order. It can be three times as fast as the arm may be.
class LaggingServo {
 public:
  static constexpr double kLag = 0.1;  // [s]

  explicit LaggingServo(JointLimits limits) : limits_(std::move(limits)) {}

  void step(const JointVector& target) {
    const JointVector wanted = (target - state_.q) / kLag;
    const JointVector change = 4.0 * limits_.acceleration * kPeriod;
    const JointVector before = state_.qd;
    state_.qd = wanted.cwiseMax(before - change).cwiseMin(before + change);
    state_.qd = state_.qd.cwiseMax(-3.0 * limits_.velocity).cwiseMin(3.0 * limits_.velocity);
    state_.q += 0.5 * (before + state_.qd) * kPeriod;
  }
  [[nodiscard]] const MeasuredState& state() const { return state_; }

 private:
  JointLimits limits_;
  MeasuredState state_{joints({-1, 0}), joints({0, 0})};
};

// A simulated controller's clock stands still while its machine stalls: afterwards its newest state seems old.
TEST(LostTrack, NeverMovesAnArmFasterThatSeemsOlderThanItIs) {
  const JointLimits limits = test::planar_point().limits;
  for (const double seems_older : {0.0, 0.1, 0.2, 0.4}) {
    LocalParameters parameters;
    parameters.method = built_in_method("local");
    ArmController controller(CellGeometry({test::planar_point()}, 0), parameters, kPeriod, 1);
    controller.set_goal(joints({1, 0.5}));
    LaggingServo servo(limits);
    const std::array<ArmObservation, 1> no_arms{};
    double fastest = 0.0;
    for (std::uint64_t number = 1; number < 1500; ++number) {
      OwnArmFeedback feedback;
      feedback.state = servo.state();
      feedback.follows = true;
      feedback.setpoint = number - 1;
      feedback.age = seems_older;
      feedback.setpoint_age = kPeriod - seems_older;
      feedback.tracking_delay = LaggingServo::kLag;
      const TickResult result = controller.step(feedback, no_arms, {}, false);
      controller.sent(number);
      servo.step(result.q);
      fastest = std::max(fastest, servo.state().qd.cwiseAbs().cwiseQuotient(limits.velocity).maxCoeff());
    }
    EXPECT_LE(fastest, 1.01) << seems_older;
    EXPECT_GT(servo.state().q[0], -0.95) << "it moves on, " << seems_older;
    if (seems_older == 0.0) {
      EXPECT_NEAR(servo.state().q[0], 1.0, 0.01);
    }
  }
}

}  // namespace
}  // namespace hecaton::planner
